"""Curves traced on a surface: lines of curvature, other conjugate curves and asymptotic curves, evenly spaced."""

from geometry.traced_curves.curve_tracing import CurveKind, TracedCurves, trace_curves

__all__ = ["CurveKind", "TracedCurves", "trace_curves"]
