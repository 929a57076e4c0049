"""Where a mesh meets or crosses itself, in n log n time."""

from geometry.mesh.intersections.crossing_sheets import crossing_triangles
from geometry.mesh.intersections.meeting_faces import intersecting_faces, is_embedded, self_crossing_faces
from geometry.mesh.intersections.near_pairs import meeting_boxes

__all__ = ["crossing_triangles", "intersecting_faces", "is_embedded", "meeting_boxes", "self_crossing_faces"]
