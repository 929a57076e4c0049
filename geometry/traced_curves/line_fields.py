"""Two directions at each point of a triangulated surface: of principal, other conjugate, or asymptotic curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, ComplexArray, FloatArray, IntArray, complexes, floats
from geometry.mesh import Mesh
from geometry.networks.tangent_frames import TangentFrames
from geometry.surface import Curvature

__all__ = ["LineField"]

UMBILIC_SHARE = 0.02
"""Half the difference of the principal curvatures over their size, below which curves end: near an umbilic their
direction is uncertain."""

PARABOLIC_SHARE = 0.999
"""Mean curvature over half the difference of the principal curvatures, above which asymptotic curves end: their two
families become one there."""

LEAST_CURVATURE = 1e-6
"""Curvature times the size of the surface, below which it is plane and has no directions."""


@dataclass(frozen=True, eq=False)
class LineField:
    """forms (F, 3, 3): xx, xy, yy of the second fundamental form at the corners of each triangle, in its frame or in
    that of its affine image. back (F, 2): complex numbers a, b such that z in the frame of the image is the direction
    a z + b conj(z) in that of the triangle. is_umbilic (F,): triangles with an umbilic, about which directions
    turn, and their neighbours. is_asymptotic: whether II(X, X) = 0 along the curves.
    """

    frames: TangentFrames
    forms: FloatArray
    back: ComplexArray
    is_umbilic: BoolArray
    is_asymptotic: bool

    @classmethod
    def of(cls, mesh: Mesh, affine: FloatArray | None, *, is_asymptotic: bool) -> LineField:
        frames = TangentFrames(mesh)
        image = frames if affine is None else TangentFrames(mesh.with_vertices(mesh.vertices @ affine.T))
        tensors = Curvature.of(image.mesh).tensors[frames.triangles]
        first, second = image.axes.swapaxes(0, 1)
        pairs = ((first, first), (first, second), (second, second))
        forms = np.stack([np.einsum("fi,fkij,fj->fk", a, tensors, b) for a, b in pairs], axis=2)
        # both frames begin with a side of the triangle, so that its two first sides say what the map does
        from_sides, to_sides = image.sides[:, :2], frames.sides[:, :2]
        matrix = np.stack([from_sides, from_sides.conj()], axis=2)
        back = np.linalg.solve(matrix, to_sides[:, :, None])[:, :, 0]
        corners = (forms[:, :, 0] - forms[:, :, 2]) / 2 + 1j * forms[:, :, 1]
        turn = np.angle(np.roll(corners, -1, axis=1) * corners.conj()).sum(axis=1)
        near_umbilic = np.zeros(mesh.n_vertices, dtype=bool)
        near_umbilic[frames.triangles[np.abs(turn) > np.pi]] = True
        is_umbilic = np.asarray(near_umbilic[frames.triangles].any(axis=1))
        return cls(frames, floats(forms), complexes(back), is_umbilic, is_asymptotic)

    def directions(
        self, triangles: IntArray, weights: FloatArray, families: IntArray
    ) -> tuple[ComplexArray, BoolArray]:
        """(n,) unit vectors, up to sign, at barycentric coordinates (n, 3) in triangles (n,), for families (n,) 0 or 1;
        and whether there is a direction.

        Family 0 has the larger principal curvature, with its sign; of asymptotic curves it is to the left of that.
        """
        xx, xy, yy = np.einsum("nk,nkc->cn", weights, self.forms[triangles])
        mean, traceless = (xx + yy) / 2, (xx - yy) / 2 + 1j * xy
        half = np.abs(traceless)
        size = np.sqrt(mean**2 + half**2)
        unit = np.divide(traceless, half, out=np.ones_like(traceless), where=half > 0)
        extent = np.sqrt(self.frames.areas.sum())
        if self.is_asymptotic:
            exists = (np.abs(mean) < PARABOLIC_SHARE * half) & (half * extent > LEAST_CURVATURE)
            angle = np.arccos(np.divide(-mean, half, out=np.zeros_like(mean), where=exists).clip(-1, 1)) / 2
            angle = np.where(families == 0, angle, -angle)
        else:
            exists = (half > UMBILIC_SHARE * size) & (size * extent > LEAST_CURVATURE)
            angle = np.where(families == 0, 0.0, np.pi / 2)
        z = np.sqrt(unit) * np.exp(1j * angle)
        a, b = self.back[triangles].T
        z = a * z + b * z.conj()
        return np.asarray(z / np.abs(z)), np.asarray(exists & ~self.is_umbilic[triangles])
