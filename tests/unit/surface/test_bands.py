"""The bands of a surface beside its axis: where stations err, both say the same, and as surely as stated."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.surface import SurfaceFit, SurfacePoints, SurfaceRequest, fit_surface
from tasks.surface.normal import Normal
from tests.unit.surface.shafts import HIGH_M, LEAN, LOW_M, Shaft, scanned, start_of, stations_of

STATIONS = 8
SIGMAS = np.array([1e-5, 1e-5, 2e-6, 1e-3, 1e-3, 1e-3])
"""Of a pose: rotations in radians, shifts in metres."""

BENDS = ("bend_east", "bend_north", "s_bend_east", "s_bend_north")


def seen_in_parts(seed: int) -> tuple[SurfacePoints, SurfaceRequest]:
    """A straight shaft of which every other station sees the upper or the lower part only, all of them out of place."""
    rng = np.random.default_rng(seed)
    shaft = Shaft(points=16_000, stations=STATIONS, sigma_m=0.003)
    cloud = scanned(shaft, seed)
    z, station = cloud.points_m[:, 2], cloud.station_index
    seen = np.where(station % 2 == 0, z < LOW_M + 0.6 * (HIGH_M - LOW_M), z > LOW_M + 0.3 * (HIGH_M - LOW_M))
    poses = stations_of(STATIONS, np.diag(np.tile(SIGMAS**2, STATIONS)))
    points, station = cloud.points_m[seen].copy(), station[seen]
    for number, error in enumerate(rng.normal(size=(STATIONS, 6)) * SIGMAS):
        own = station == number
        arm = points[own] - poses.positions_m[number]
        points[own] += error[3:] + np.cross(error[:3], arm)
    cloud = SurfacePoints(points, station, STATIONS)
    return cloud, SurfaceRequest(cloud, start_of(shaft), "horizontal", poses)


def fit_of(seed: int) -> SurfaceFit:
    fit = fit_surface("shaft", seen_in_parts(seed)[1])
    assert isinstance(fit, SurfaceFit), fit
    return fit


def bends_of(fit: SurfaceFit) -> NDArray[np.float64]:
    places = [fit.parameter_names.index(name) for name in BENDS]
    return np.asarray(fit.parameter_values[places])


def bends_of_bands(fit: SurfaceFit) -> NDArray[np.float64]:
    """Second and third Legendre polynomial of the bands' centres, as ``BENDS``."""
    good = [band for band in fit.bands if band.state == "ok"]
    share = (2.0 * np.array([band.z_m for band in good]) - LOW_M - HIGH_M) / (HIGH_M - LOW_M)
    centres = np.array([[band.center_east_m, band.center_north_m] for band in good])
    return np.asarray((np.linalg.pinv(np.polynomial.legendre.legvander(share, 3)) @ centres)[2:].ravel())


def largest_apart(fits: list[SurfaceFit]) -> float:
    return float(np.abs([bends_of_bands(fit) - bends_of(fit) for fit in fits]).max())


@pytest.mark.slow
def test_bands_bend_no_more_than_the_axis_where_stations_are_out_of_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seeds = range(6)
    apart_m = largest_apart([fit_of(seed) for seed in seeds])
    monkeypatch.setattr(Normal, "without_poses", lambda _normal, residual_m: residual_m)
    as_they_are_m = largest_apart([fit_of(seed) for seed in seeds])
    assert apart_m < 1e-4
    assert as_they_are_m > 2.0 * apart_m


@pytest.mark.slow
def test_the_bending_scatters_as_stated() -> None:
    chi2 = []
    for seed in range(24):
        fit = fit_of(seed)
        places = [fit.parameter_names.index(name) for name in BENDS]
        covariance = (fit.joint.own + fit.joint.form)[np.ix_(places, places)]
        bends = bends_of(fit)
        chi2.append(float(bends @ np.linalg.solve(covariance, bends)))
    # four degrees of freedom: mean 4 with a standard deviation of sqrt(8 / 24)
    assert np.mean(chi2) < 4.0 + 3.0 * np.sqrt(8.0 / 24.0)
    # on the safe side: noise is taken from points that poses move, too
    assert np.mean(chi2) > 1.2


def test_the_lean_of_such_a_shaft_is_within_its_covariance() -> None:
    fit = fit_of(1)
    assert fit.pose_jacobian is not None
    covariance = (
        fit.point_covariance + fit.pose_jacobian @ np.diag(np.tile(SIGMAS**2, STATIONS)) @ fit.pose_jacobian.T
    )
    off = fit.lean - LEAN
    assert off @ np.linalg.solve(covariance, off) < 13.8
