"""A network of curves as two directions in each triangle, and how far they are from conjugate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import ComplexArray, FloatArray, floats, short_repr
from geometry.networks.tangent_frames import TangentFrames

__all__ = ["Network", "determinants", "forms_of_isolines"]


@dataclass(frozen=True, eq=False)
class Network:
    """first, second (F,): unit tangent vectors in the frames of triangles, the second to the left of the first.

    forms (F, 3): II(first, first), II(first, second), II(second, second), over `curvature`, its root mean square.
    sizes (F,): wanted edge lengths over the typical one.

    >>> from geometry import Surface, lay_quads
    >>> from geometry.mesh import shapes
    >>> barrel = Surface(shapes.rotational_mesh([[2, 0.3 * k] for k in range(10)], 30, closed=False))
    >>> network = lay_quads(barrel, n_faces=100).network
    >>> np.degrees(network.crossing_angles).round().tolist(), set(network.sizes.tolist())
    ([90.0, 90.0], {1.0})
    """

    __repr__ = short_repr

    frames: TangentFrames
    first: ComplexArray
    second: ComplexArray
    forms: FloatArray
    curvature: float
    sizes: FloatArray

    @classmethod
    def of(cls, frames: TangentFrames, first: FloatArray, second: FloatArray, tensors: FloatArray) -> Network:
        """Along directions (F, 3) in space, of any length, on a surface with II (F, 3, 3)."""
        a, b = frames.flat(first), frames.flat(second)
        a, b = a / np.abs(a), b / np.abs(b)
        vectors = (frames.in_space(a), frames.in_space(b))
        forms = np.stack(
            [np.einsum("fi,fij,fj->f", vectors[i], tensors, vectors[j]) for i, j in ((0, 0), (0, 1), (1, 1))], axis=1
        )
        mean_square = frames.areas @ (tensors**2).sum(axis=(1, 2)) / frames.areas.sum()
        size = float(np.sqrt(mean_square))
        flat = np.zeros_like(forms)
        relative = floats(np.divide(forms, size, out=flat, where=size > 0))
        return cls(frames, a, b, relative, size, floats(np.ones(len(forms))))

    @property
    def crossing_angles(self) -> FloatArray:
        """(2,) angles in radians between the two directions: the 5 % quantile by area, and the median."""
        angles = np.abs(np.angle(self.second * self.first.conj()))
        angles = np.minimum(angles, np.pi - angles)
        order = np.argsort(angles)
        shares = np.cumsum(self.frames.areas[order]) / self.frames.areas.sum()
        return floats(angles[order][np.minimum(np.searchsorted(shares, (0.05, 0.5)), len(angles) - 1)])

    def with_sizes(self, sizes: FloatArray) -> Network:
        """The network with other wanted edge lengths (F,)."""
        return replace(self, sizes=sizes)

    def corrected(self, twists: FloatArray) -> Network:
        """The network with twists (F,) added to II(first, second), over the root mean square of the curvature."""
        forms = self.forms.copy()
        forms[:, 1] += twists
        return replace(self, forms=floats(forms))


def determinants(derivatives: FloatArray) -> FloatArray:
    """(F,) of p, q, r, s (F, 4), see `integration`."""
    p, q, r, s = derivatives.T
    return np.asarray(p * s - q * r)


def forms_of_isolines(forms: FloatArray, derivatives: FloatArray) -> FloatArray:
    """(F,) II of the tangents of the isolines of u and v, times the determinant of p, q, r, s (F, 4), per h^2."""
    p, q, r, s = derivatives.T
    xx, xy, yy = forms.T
    return np.asarray(xy * (s * p + r * q) - xx * s * q - yy * r * p)
