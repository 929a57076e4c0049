"""Rigid positions of parts in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, floats

__all__ = ["Frame"]


@dataclass(frozen=True, eq=False)
class Frame:
    """A right-handed orthonormal frame.

    origin (3,) in mm; axes (3, 3): its rows are the unit vectors x, y, z of the frame, in world coordinates.

    >>> from fabkit.parts import Frame
    >>> frame = Frame(np.array([10.0, 0, 0]), np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]))
    >>> frame.to_world(np.array([2.0, 0, 0])).tolist(), frame.to_local(np.array([10.0, 2, 0])).tolist()
    ([10.0, 2.0, 0.0], [2.0, 0.0, 0.0])
    """

    origin: FloatArray
    axes: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", floats(self.origin))
        object.__setattr__(self, "axes", floats(self.axes))

    @classmethod
    def world(cls) -> Frame:
        return cls(np.zeros(3), np.eye(3))

    def to_world(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) given in this frame, in world coordinates."""
        return self.origin + points @ self.axes

    def to_local(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) given in world coordinates, in this frame."""
        return (points - self.origin) @ self.axes.T

    def place(self, inner: Frame) -> Frame:
        """A frame given in this frame, in world coordinates."""
        return Frame(self.to_world(inner.origin), inner.axes @ self.axes)
