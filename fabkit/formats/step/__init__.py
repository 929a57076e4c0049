"""STEP, written by ourselves: exact Part 21, streamed."""

from fabkit.formats.step.files import instance_name, stream_step, write_part_step, write_part_steps, write_step

__all__ = ["instance_name", "stream_step", "write_part_step", "write_part_steps", "write_step"]
