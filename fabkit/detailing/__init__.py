"""Decisions: from a support structure to an assembly, by the rules of the shop, and the check that all of it fits."""
