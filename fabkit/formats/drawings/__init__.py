"""Drawings in two dimensions."""
