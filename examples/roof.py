"""A freeform roof of 288 planar quads: the mesh of the quick start in the README.

An arch moved along a wave gives planar quads; a projective map, which preserves planes, then widens one end. Run the
script to write roof.obj next to it, in metres with four decimals, as modelling programs do. The faces are then planar
only to about 1e-4, and have to be planarised.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geometry.mesh import Mesh

BAYS_ALONG, BAYS_ACROSS = 24, 12


def roof() -> Mesh:
    """The roof in metres, outside up."""
    x, y = np.meshgrid(np.linspace(0, 40, BAYS_ALONG + 1), np.linspace(-9, 9, BAYS_ACROSS + 1), indexing="ij")
    arch = 3.6 * np.cos(y / 9 * 1.15)
    wave = 1.5 * np.cos((x - 4) / 40 * 2.6 * np.pi)
    points = np.stack([x, y, arch + wave], axis=-1).reshape(-1, 3)
    taper = 1 + 0.011 * points[:, :1]
    corner = np.arange(BAYS_ALONG * (BAYS_ACROSS + 1)).reshape(BAYS_ALONG, BAYS_ACROSS + 1)[:, :-1].ravel()
    step = BAYS_ACROSS + 1
    faces = np.stack([corner, corner + step, corner + step + 1, corner + 1], axis=1)
    return Mesh.from_faces(points / taper, faces.tolist())


def main() -> dict[str, float]:
    mesh = roof()
    return {"faces": mesh.n_faces, "mean edge": mesh.mean_edge_length, "planarity": float(mesh.planarity.max())}


def write(path: Path) -> None:
    mesh = roof()
    lines = ["# a freeform roof of planar quads, in metres; made by roof.py"]
    lines += [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in mesh.vertices]
    lines += ["f " + " ".join(str(vertex + 1) for vertex in face) for face in mesh.combinatorics.faces]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    write(Path(__file__).with_suffix(".obj"))
    print(main())
