"""A surface with bending that may be nothing: by it epochs are compared, whether the data of one ask for it or not."""

from dataclasses import replace
from typing import Final

import numpy as np

from tasks.surface.fit import Adjusted
from tasks.surface.form import kept_in
from tasks.surface.normal import Weighed, normal_of

BENT: Final = 3
"""Order of the axis by which epochs are compared: it bends once, and in the shape of an S."""


def with_bending(adjusted: Adjusted) -> Adjusted:
    """The surface at the minimum with bending; weights and what is robust stay as they are.

    Its cells are those after the step; the right side of its normal equations is the one before.
    """
    wide, step = _widened(adjusted)
    return replace(wide, profile=wide.profile.moved(step), cells=wide.cells.moved(wide.normal.design @ step))


def bent_beside(adjusted: Adjusted) -> Adjusted:
    """The surface with the bending of ``with_bending``; axis and radius stay as they are stated."""
    wide, step = _widened(adjusted)
    old, large = adjusted.profile.form, wide.profile.form
    step[kept_in(old, large)] = 0.0
    return replace(wide, profile=wide.profile.moved(step))


def _widened(adjusted: Adjusted) -> tuple[Adjusted, np.ndarray]:
    """The same surface with coefficients of bending, which are nothing yet, and the step to the minimum."""
    form = adjusted.profile.form
    if form.axis_order >= BENT:
        return adjusted, np.zeros(form.size)
    large = replace(form, axis_order=BENT)
    values = np.zeros(large.size)
    values[kept_in(form, large)] = adjusted.profile.values_m
    weighed = Weighed(adjusted.cells, adjusted.blocks.share, adjusted.normal.poses)
    normal = normal_of(weighed, large, values)
    profile = replace(adjusted.profile, form=large, values_m=values)
    return replace(adjusted, profile=profile, normal=normal), normal.step()
