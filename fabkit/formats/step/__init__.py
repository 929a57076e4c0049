"""STEP, written by ourselves: exact Part 21, streamed."""
