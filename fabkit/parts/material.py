"""Materials of parts."""

from __future__ import annotations

from dataclasses import dataclass

from fabkit.errors import FabkitError
from geometry.errors import described, finite_number

__all__ = ["Material"]


@dataclass(frozen=True)
class Material:
    """A material. name: in ASCII; density_kg_m3: density in kg/m3.

    Raises FabkitError for another name, and FabkitError or GeometryError for a density that is not a number above 0.

    >>> from fabkit.parts import Material
    >>> round(Material("steel", 7850.0).mass_kg(volume_mm3=1e6), 2)
    7.85
    """

    name: str
    density_kg_m3: float

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise FabkitError(f"the name of a material is {described(self.name)}: a text is needed, then its density")
        if finite_number(f"the density of {self.name} in kg/m3", self.density_kg_m3) <= 0:
            raise FabkitError(f"the density of {self.name} is {self.density_kg_m3} kg/m3: a number above 0 is needed")

    def mass_kg(self, volume_mm3: float) -> float:
        return self.density_kg_m3 * volume_mm3 * 1e-9
