"""Cells of a surface made of numbers, and normal equations made of a covariance: no cloud, no fit."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tasks.surface.cells import SECTORS, Cells
from tasks.surface.form import Form
from tasks.surface.normal import Normal

SHAFT_Z_M = (2.0, 102.0)
N_HEIGHTS = 120


def cells_with(residual_m: NDArray[np.float64], sigma_m: float) -> Cells:
    """One cell for every height and sector, with mean residuals (``N_HEIGHTS``, ``SECTORS``) of that sigma each."""
    height, sector = np.divmod(np.arange(N_HEIGHTS * SECTORS), SECTORS)
    ones = np.ones(len(height))
    heights_m = SHAFT_Z_M[0] + (height + 0.5) * (SHAFT_Z_M[1] - SHAFT_Z_M[0]) / N_HEIGHTS
    return Cells(
        station=np.zeros(len(height), dtype=np.intp),
        height=height,
        sector=sector,
        z_m=heights_m,
        foot_m=heights_m,
        direction=np.exp(2j * np.pi * (sector + 0.5) / SECTORS),
        n_points=4.0 * ones,
        n_used=4.0 * ones,
        weight=ones / sigma_m**2,
        residual_m=residual_m.ravel(),
        square_m2=4.0 * sigma_m**2 * ones,
        influence=1.0,
        slope=1.0,
        mean_weight=1.0,
    )


def white(rng: np.random.Generator, sigma_m: float) -> NDArray[np.float64]:
    """Residuals (``N_HEIGHTS``, ``SECTORS``) of noise alone."""
    return np.asarray(sigma_m * rng.standard_normal((N_HEIGHTS, SECTORS)))


def patches(rng: np.random.Generator, sigma_m: float, heights: int, sectors: int) -> NDArray[np.float64]:
    """Residuals (``N_HEIGHTS``, ``SECTORS``) of a wall whose pieces stand in or out as a whole."""
    pieces = sigma_m * rng.standard_normal((-(-N_HEIGHTS // heights), -(-SECTORS // sectors)))
    whole = np.repeat(np.repeat(pieces, heights, axis=0), sectors, axis=1)
    return np.asarray(whole[:N_HEIGHTS, :SECTORS])


def without_sectors(cells: Cells, first: int) -> Cells:
    """The cells of the sectors below the first one that is not seen."""
    seen = cells.sector < first
    columns = (
        "station",
        "height",
        "sector",
        "z_m",
        "foot_m",
        "direction",
        "n_points",
        "n_used",
        "weight",
        "residual_m",
    )
    return replace(
        cells, **{name: getattr(cells, name)[seen] for name in columns}, square_m2=cells.square_m2[seen]
    )


def equations_of(form: Form, covariance: NDArray[np.float64]) -> Normal:
    """Normal equations of coefficients with that covariance (p, p), square metres, at their minimum."""
    p = form.size
    return Normal(
        matrix=np.linalg.inv(covariance),
        right=np.zeros(p),
        design=np.zeros((0, p)),
        weight=np.zeros(0),
        poses=np.zeros((0, 0)),
        inner=np.zeros((0, 0)),
        cross=np.zeros((p, 0)),
    )
