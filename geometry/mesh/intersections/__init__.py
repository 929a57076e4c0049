"""Where a mesh meets or crosses itself, in n log n time."""

from geometry.mesh.intersections.meeting_faces import (
    intersecting_faces,
    is_embedded,
    meeting_boxes,
    self_crossing_faces,
)

__all__ = ["intersecting_faces", "is_embedded", "meeting_boxes", "self_crossing_faces"]
