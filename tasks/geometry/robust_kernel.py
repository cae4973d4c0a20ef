"""Tukey's biweight of a single residual, compiled: for loops that weigh points."""

from tasks.geometry.compiled import compiled


@compiled
def biweight(residual: float, reach: float) -> float:
    """Weight of a residual; those beyond ``reach``, which may be infinite, have none."""
    u = min(abs(residual) / reach, 1.0)
    root = 1.0 - u * u
    return root * root
