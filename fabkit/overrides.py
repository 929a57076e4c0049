"""Settings of the command line in place of those of a project file."""

from __future__ import annotations

from typing import Any

__all__ = ["layer_tables", "with_overrides"]


def with_overrides(found: dict[str, Any], overrides: dict[str, Any]) -> dict[str, Any]:
    """The settings of a file, nested as in it, with those of the command line in their place. A unit replaces the
    length of the mean edge, a section the sizes of a bar, and so on; of the layers, the outermost one is set.

    >>> from fabkit.overrides import with_overrides
    >>> with_overrides({"layers": [{"build_up": "44.2", "joint_mm": 8}, {"z_mm": -200}]}, {"layers": [{"z_mm": 40}]})
    {'layers': [{'build_up': '44.2', 'joint_mm': 8, 'z_mm': 40}, {'z_mm': -200}]}
    """
    kept = dict(found)
    if "unit" in overrides or "mean_edge_mm" in overrides:
        kept.pop("unit", None)
        kept.pop("mean_edge_mm", None)
    if isinstance(kept.get("beams"), dict):
        kept["beams"] = _without(kept["beams"], _of_beams(overrides.get("beams", {})))
    if layers := layer_tables(kept):
        kept["layers"] = [_without(layers[0], _of_layer(overrides.get("layers", [{}])[0])), *layers[1:]]
    wanted = overrides.get("gauss_image")
    if isinstance(wanted, dict) and "file" in wanted:
        kept.pop("gauss_image", None)
    return _merged(kept, overrides)


def layer_tables(found: dict[str, Any]) -> list[dict[str, Any]]:
    """The tables [[layers]] of a file, none where they are something else."""
    layers = found.get("layers")
    return layers if isinstance(layers, list) and all(isinstance(layer, dict) for layer in layers) else []


def _of_beams(beams: dict[str, Any]) -> tuple[str, ...]:
    """The keys of [beams] that these settings replace."""
    if "section" in beams:
        return ("width_mm", "height_mm")
    return ("section",) if beams.keys() & {"width_mm", "height_mm"} else ()


def _of_layer(layer: dict[str, Any]) -> tuple[str, ...]:
    """The keys of a layer that these settings replace."""
    of_thickness = ("build_up",) if "thickness_mm" in layer else ()
    return (*of_thickness, *(("distance_mm", "parallel", "lift") if "z_mm" in layer else ()))


def _without(table: dict[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key not in keys}


def _merged(under: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    both = dict(under)
    for key, value in over.items():
        inner = both.get(key)
        if isinstance(inner, dict) and isinstance(value, dict):
            both[key] = _merged(inner, value)
        elif key == "layers" and (layers := layer_tables(under)):
            both[key] = [_merged(layers[0], value[0]), *layers[1:]]
        else:
            both[key] = value
    return both
