"""Materials of parts."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Material"]


@dataclass(frozen=True)
class Material:
    """A material. name: in ASCII; density_kg_m3: density in kg/m3.

    >>> from fabkit.parts import Material
    >>> round(Material("steel", 7850.0).mass_kg(volume_mm3=1e6), 2)
    7.85
    """

    name: str
    density_kg_m3: float

    def mass_kg(self, volume_mm3: float) -> float:
        return self.density_kg_m3 * volume_mm3 * 1e-9
