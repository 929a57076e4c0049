"""STEP files (ISO 10303-21), written directly, without a CAD kernel."""

from fabkit.formats.step.files import (
    instance_name,
    product_names,
    stream_step,
    write_part_step,
    write_part_steps,
    write_step,
)

__all__ = ["instance_name", "product_names", "stream_step", "write_part_step", "write_part_steps", "write_step"]
