"""The methods: which contour and which axis estimator a scheme is measured with."""

from dataclasses import dataclass
from typing import Final

from storage.errors import InputError
from tasks.slicing import SlicingScheme

ROBUST_THICKNESS_M: Final = 0.2
"""Slices of 1 cm throw away 80 to 99 % of the points; 20 cm, straightened for taper and lean, keep them."""

WITHOUT_ROBUST: Final = ("F",)
"""Scheme F is the vertex mean: with another centre it would be scheme E."""


@dataclass(frozen=True, slots=True)
class Method:
    """How the slices of a scheme become an axis."""

    name: str
    contour: str
    axis: str
    thickness_m: float


def methods_of(scheme: SlicingScheme) -> tuple[Method, ...]:
    """All methods that a scheme is measured with: ``paper`` to the letter, ``robust`` beside it."""
    paper = Method("paper", scheme.contour, scheme.axis, scheme.thickness_m)
    if scheme.name in WITHOUT_ROBUST:
        return (paper,)
    thickness_m = max(scheme.thickness_m, ROBUST_THICKNESS_M)
    return (paper, Method("robust", scheme.robust_contour, scheme.robust_axis, thickness_m))


def method_of(scheme: SlicingScheme, name: str) -> Method:
    """The method of that name.

    Raises
    ------
    InputError
        If the scheme is not measured with it; the message lists those that it is.
    """
    known = {method.name: method for method in methods_of(scheme)}
    if name not in known:
        raise InputError(f"scheme {scheme.name} has no method {name!r}; known: {', '.join(sorted(known))}")
    return known[name]
