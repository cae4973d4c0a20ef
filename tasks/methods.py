"""The methods: which contour and which axis estimator a scheme is measured with."""

from dataclasses import dataclass, replace
from typing import Final

from storage.errors import InputError
from tasks.contours import CONTOURS
from tasks.geometry.variants import choose
from tasks.preprocessing import KINDS
from tasks.slicing import SlicingScheme

ROBUST_THICKNESS_M: Final = 0.2
"""Slices of 1 cm throw away 80 to 99 % of the points; 20 cm, straightened for taper and lean, keep them."""

ROUND_CONTOUR: Final = "robust_circle"
"""The contour of method robust where nobody asked for another one."""

ROUND_SURFACE: Final = "shaft"
FACES: Final = "faces"
"""Models of the whole surface of round shafts, and of those with plane faces."""

WHOLE_SURFACE: Final = "whole surface"
"""Stands for the contour of method surface, which fits none."""

POLYGON: Final = "polygon"
"""The contour of shafts with plane faces."""

WITHOUT_ROBUST: Final = ("F",)
"""Scheme F is the vertex mean: with another centre it would be scheme E."""


@dataclass(frozen=True, slots=True)
class Method:
    """How the slices of a scheme become an axis; of slices that follow the points ``thickness_m`` is the least."""

    name: str
    contour: str
    axis: str
    thickness_m: float


def methods_of(scheme: SlicingScheme) -> tuple[Method, ...]:
    """All methods that a scheme is measured with: ``paper`` to the letter, ``robust`` beside it.

    The paper knows no slices that follow the points: they are measured with ``robust`` only. Schemes of the whole
    surface have no slices and are measured with ``surface``.
    """
    if scheme.surface is not None:
        return (Method("surface", WHOLE_SURFACE, scheme.surface, scheme.thickness_m),)
    if scheme.adaptive is not None:
        return (Method("robust", scheme.robust_contour, scheme.robust_axis, scheme.thickness_m),)
    paper = Method("paper", scheme.contour, scheme.axis, scheme.thickness_m)
    if scheme.name in WITHOUT_ROBUST:
        return (paper,)
    thickness_m = max(scheme.thickness_m, ROBUST_THICKNESS_M)
    return (paper, Method("robust", scheme.robust_contour, scheme.robust_axis, thickness_m))


def needs_sights(scheme: SlicingScheme, method: Method) -> bool:
    """Whether the sigma of every point counts: for slices that follow the points, and for contours that weigh them."""
    return scheme.adaptive is not None or weighs_sights(method)


def weighs_sights(method: Method) -> bool:
    """Whether the contour model of the method weighs every point by its own sigma."""
    if method.contour == WHOLE_SURFACE:
        return False
    return choose(CONTOURS, method.contour, "contour model").weighs_sights


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


def suited_to(scheme: SlicingScheme, kind: str) -> SlicingScheme:
    """The scheme with the contour that the sections of this kind of structure need in method ``robust``.

    A contour other than the circle, that a user chose, stays.

    Raises
    ------
    InputError
        If there is no such kind.
    """
    structure = choose(KINDS, kind, "kind of structure")
    if scheme.surface == ROUND_SURFACE and structure.n_faces:
        return replace(scheme, surface=FACES)
    needed = structure.robust_contour
    if needed is None or scheme.robust_contour != ROUND_CONTOUR:
        return scheme
    return replace(scheme, robust_contour=needed)
