"""Uncertainty: what levelling and registration of the stations do to the lean vector."""

from tasks.uncertainty.poses import combine, propagate_directional_poses, propagate_poses

__all__ = ["combine", "propagate_directional_poses", "propagate_poses"]
