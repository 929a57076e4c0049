"""A page of networks on one surface side by side, the best first: what `fabkit mesh --study` writes."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from fabkit.formats.drawings.picture import lines_picture
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.remeshing import NetworkTrial

__all__ = ["networks_html"]

_STYLE = """
body{margin:0;color:#1c232b;background:#fff;font:15px/1.5 system-ui,"Segoe UI","Liberation Sans",Arial,sans-serif}
main{max-width:1240px;margin:0 auto;padding:1rem 1.5rem 3rem}h1{font-weight:600;font-size:1.9rem;margin:1rem 0 .3rem}
p{max-width:46rem;margin:0 0 .6rem}.soft{color:#5d6873}
.networks{display:grid;grid-template-columns:repeat(auto-fill,minmax(330px,1fr));gap:1.6rem 1.2rem;margin-top:1.4rem}
figure{margin:0}svg{width:100%;height:auto;display:block;background:#f5f7f8}
figcaption{font-size:.9rem;margin-top:.4rem}figcaption b{font-size:1rem}code{font-size:.85em}
path{stroke-linejoin:round;stroke-linecap:round}.f{stroke:#9aa5ae;stroke-width:.5}
.a{fill:none;stroke:#1d5f8f;stroke-width:1.5}.b{fill:none;stroke:#c4690c;stroke-width:1.5}circle{fill:#c8202c}
"""

LEAST_SHOWN_SHARE = 1e-3
"""Entry of an affine map over its largest one, below which it is shown as 0: entries have three digits."""


def networks_html(name: str, trials: Sequence[NetworkTrial], n_triangles: int) -> str:
    """The text of an HTML file that opens offline: for each network a picture of a coarse mesh along it, and figures.

    >>> from fabkit.formats.drawings import networks_html
    >>> "A surface of 800 triangles" in networks_html("canopy", [], 800)
    True
    """
    drawn = [trial for trial in trials if trial.remeshed is not None and trial.pair is not None]
    figures = "\n".join(_figure(number, trial) for number, trial in enumerate(drawn, start=1))
    failed = len(trials) - len(drawn)
    left_out = f"<p class='soft'>Along {failed} more networks no mesh could be made.</p>" if failed else ""
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">
<title>Networks on {escape(name)}</title><style>{_STYLE}</style></head><body><main>
<h1>Networks on {escape(name)}</h1>
<p>A surface of {n_triangles} triangles. Each picture shows a coarse mesh of planar faces along conjugate lines, the one
whose beams vary least in height first. Blue and orange are the two families of lines, red dots are vertices where other
than four edges meet.</p>
<p class="soft">The affine map under each picture takes its lines to lines of curvature of the image of the surface; the
identity gives lines of curvature of the surface itself. Heights vary less in finer meshes.</p>
{left_out}<div class="networks">
{figures}
</div></main></body></html>
"""


def _figure(number: int, trial: NetworkTrial) -> str:
    assert trial.remeshed is not None
    laid, mesh = trial.remeshed.laid, trial.remeshed.mesh
    families = [_edges_of(lines, mesh.combinatorics.edges, mesh.n_vertices) for lines in laid.polylines]
    angles = np.degrees(trial.crossing_angles)
    return (
        f"<figure>{lines_picture(mesh, families[0], families[1], laid.singularities)}<figcaption>"
        f"<b>{number}. Heights within {100 * trial.height_spread:.1f} %</b> (from 5 to 95 % of the beams)<br>"
        f"node axes lean up to {np.degrees(trial.lean):.0f}° (95 %); median crossing angle of the lines "
        f"{angles[1]:.0f}°, "
        f"95 % above {angles[0]:.0f}°; {trial.n_singularities} singular vertices, "
        f"{100 * laid.quality.quad_share:.0f} % quads<br><code>{_map(trial.affine)}</code></figcaption></figure>"
    )


def _edges_of(lines: Sequence[IntArray], edges: IntArray, n_vertices: int) -> BoolArray:
    """(E,) which edges lie on one of the lines."""
    steps = [np.sort(np.stack([line[:-1], line[1:]], axis=1), axis=1) for line in lines]
    keys = np.concatenate([step @ [n_vertices, 1] for step in steps]) if steps else np.zeros(0, dtype=np.int64)
    found: BoolArray = np.isin(np.sort(edges, axis=1) @ [n_vertices, 1], keys)
    return found


def _map(affine: FloatArray) -> str:
    if (affine == np.eye(3)).all():
        return "lines of curvature: the identity"
    shown = np.where(np.abs(affine) < LEAST_SHOWN_SHARE * np.abs(affine).max(), 0.0, affine)
    return "; ".join(" ".join(f"{value:.3g}" for value in row) for row in shown.tolist())
