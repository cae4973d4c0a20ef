"""Contour model ``taubin``: Taubin's algebraic circle."""

from typing import Final

from tasks.contours.algebraic import fit_algebraic
from tasks.contours.circle_start import taubin_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.geometry.failure import FitFailure


def fit_taubin(section: Section) -> Contour | FitFailure:
    """Fit Taubin's circle: nearly unbiased on arcs, half the bias of Pratt's, not robust.

    References
    ----------
    Taubin 1991, IEEE PAMI 13; the bias: Al-Sharadqah & Chernov 2009, doi 10.1214/09-EJS419.
    """
    return fit_algebraic(section, taubin_circle)


CONTOUR: Final = ContourModel(
    "taubin", "algebraic circle after Taubin, nearly unbiased on arcs", min_points=4, fit=fit_taubin
)
