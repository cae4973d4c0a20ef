"""Every scheme and method on one shaft: the axis that was put in, and what is told of it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.methods import method_of, methods_of
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.registration import Registration
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.slicing import SCHEMES
from tasks.whole_surface import RoundCut
from tests.unit.networks import MODEL, SHAFT_Z_M, registration, sigmas

AZIMUTHS_DEG = tuple(45.0 * k for k in range(8))
TRUTH = np.array([MODEL.lean_east, MODEL.lean_north])
EVERY = [(scheme.name, method.name) for scheme in SCHEMES.values() for method in methods_of(scheme)]

STEADY = replace(registration(AZIMUTHS_DEG, sigmas()), covariance=1e-16 * np.eye(48))
"""Stations whose poses are known: what is left is the noise of the points."""


def heights(rng: np.random.Generator) -> NDArray[np.float64]:
    """Points all along the shaft, and as many in the thin slices of the paper as a scan of millions has."""
    thin = np.repeat(SHAFT_Z_M[0] + np.arange(100.0), 60)
    ends = np.repeat(np.array(SHAFT_Z_M) - [0.0, 0.02], 500)
    return np.concatenate(
        [rng.uniform(*SHAFT_Z_M, 20_000), *(z + rng.uniform(0.0, 0.02, len(z)) for z in (thin, ends))]
    )


def scanned(seed: int = 1, sigma_m: float = 0.01) -> PlacedCloud:
    """Points of ``MODEL`` all around, each seen by a station that stands before it."""
    rng = np.random.default_rng(seed)
    z_m = heights(rng)
    station = rng.integers(0, len(AZIMUTHS_DEG), len(z_m))
    turn = np.radians(np.array(AZIMUTHS_DEG)[station] + rng.uniform(-80.0, 80.0, len(z_m)))
    radius_m = MODEL.radius_at(z_m) + sigma_m * rng.standard_normal(len(z_m))
    xy = MODEL.axis_at(z_m) + radius_m[:, None] * np.column_stack([np.sin(turn), np.cos(turn)])
    return PlacedCloud(np.column_stack([xy, z_m]), station.astype(np.uint16))


CLOUD = scanned()


def tipped(cloud: PlacedCloud, station: int, angle_rad: float) -> PlacedCloud:
    """The cloud with a station turned about its own east."""
    points, own = cloud.points_m.copy(), cloud.station_index == station
    points[own] += np.cross([angle_rad, 0.0, 0.0], points[own] - STEADY.poses[station].position_m)
    return replace(cloud, points_m=points)


def shaft_of(cloud: PlacedCloud = CLOUD, stations: Registration = STEADY) -> IsolatedShaft:
    return IsolatedShaft(cloud, MODEL, stations, SHAFT_Z_M)


def lean(scheme: str, method: str, shaft: IsolatedShaft) -> Lean:
    found = lean_of_scheme(shaft, SCHEMES[scheme], method_of(SCHEMES[scheme], method))
    assert isinstance(found, Lean), found
    return found


@cache
def plain(scheme: str, method: str) -> Lean:
    """The lean of ``CLOUD`` from steady stations."""
    return lean(scheme, method, shaft_of())


def sigma(covariance: NDArray[np.float64] | None) -> float:
    """Standard deviation of one component, arc seconds."""
    assert covariance is not None
    return float(np.sqrt(np.trace(covariance) / 2.0) / ARCSEC_RAD)


@pytest.mark.parametrize(("scheme", "method"), EVERY)
def test_every_scheme_and_method_finds_the_axis_within_four_sigmas(scheme: str, method: str) -> None:
    found = plain(scheme, method)
    off = found.lean - TRUTH
    assert off @ np.linalg.solve(found.covariance, off) < 4.0**2
    assert sigma(found.covariance) >= sigma(found.point_covariance)


def test_the_more_of_the_surface_counts_the_smaller_the_sigma() -> None:
    stated = [
        sigma(plain(scheme, method).point_covariance)
        for scheme, method in (
            ("S", "surface"),
            ("A", "robust"),
            ("B", "robust"),
            ("C", "robust"),
            ("F", "paper"),
        )
    ]
    assert stated == sorted(stated)
    # 27,000 points of 10 mm all around, over 100 m: sigma sqrt(24 / N) / L
    assert stated[0] == pytest.approx(0.010 * np.sqrt(24.0 / 27_000) / 100.0 / ARCSEC_RAD, rel=0.2)


@pytest.mark.parametrize(("scheme", "method"), [("A", "robust"), ("S", "surface")])
def test_poses_add_what_level_errors_of_eight_stations_do(scheme: str, method: str) -> None:
    stated = replace(STEADY, covariance=registration(AZIMUTHS_DEG, sigmas(level_arcsec=20.0)).covariance)
    alone, with_poses = plain(scheme, method), lean(scheme, method, shaft_of(stations=stated))
    more = np.sqrt(sigma(with_poses.propagated) ** 2 - sigma(alone.point_covariance) ** 2)
    # each station a share of 1 / 8, whichever side it sees: 20" / sqrt(8)
    assert more == pytest.approx(20.0 / np.sqrt(8.0), rel=0.15)


@pytest.mark.parametrize(("scheme", "method"), [("A", "robust"), ("S", "surface")])
def test_a_station_that_is_off_level_beyond_its_sigma_makes_the_jackknife_count(
    scheme: str, method: str
) -> None:
    tilted = lean(scheme, method, shaft_of(tipped(CLOUD, 3, 45.0 * ARCSEC_RAD)))
    assert (plain(scheme, method).source, tilted.source) == ("propagation", "jackknife")
    # some eighth of 45" is outside the region of propagation, and inside the one that is stated
    off = tilted.lean - TRUTH
    assert off @ np.linalg.solve(tilted.propagated, off) > 5.991
    assert off @ np.linalg.solve(tilted.covariance, off) < 5.991


TAPER = -0.02
TANGENT = float(np.tan(np.radians(5.0)))
LEANING = ShaftModel(
    0.0, 0.0, TANGENT, 0.0, (0.0, 110.0), (4.6, 4.6 + 110.0 * TAPER), (0.0, 0.0), (0.0, 0.0), 0.001
)


def leaning_cone(round_cut: RoundCut) -> IsolatedShaft:
    """A cone that was built plumb, round across its axis, and leans by 5 degrees; noise of 1 mm."""
    rng = np.random.default_rng(2)
    direction = np.array([TANGENT, 0.0, 1.0]) / np.hypot(TANGENT, 1.0)
    across = np.array([direction[2], 0.0, -direction[0]])
    along, turn = rng.uniform(-2.0, 106.0, 40_000), rng.uniform(0.0, 2.0 * np.pi, 40_000)
    radius = 4.6 + TAPER * along + 0.001 * rng.standard_normal(len(along))
    skin = along[:, None] * direction + (radius * np.cos(turn))[:, None] * across
    skin[:, 1] += radius * np.sin(turn)
    station = (turn / (2.0 * np.pi) * 8).astype(np.uint16)
    return IsolatedShaft(PlacedCloud(skin, station), LEANING, STEADY, SHAFT_Z_M, round_cut)


@pytest.mark.parametrize(("scheme", "method"), [("A", "robust"), ("C", "robust"), ("S", "surface")])
def test_of_a_cone_that_is_round_across_its_axis_the_axis_is_found(scheme: str, method: str) -> None:
    found = lean(scheme, method, leaning_cone("perpendicular"))
    # horizontal cuts lean by 4e-4 of it more; sigma is some 1e-5 of it and less
    assert found.lean[0] / TANGENT - 1.0 == pytest.approx(0.0, abs=4e-5)


def test_what_the_cone_took_from_the_lean_is_told() -> None:
    right, raw = (lean("A", "robust", leaning_cone(cut)) for cut in ("perpendicular", "horizontal"))
    factor = (1.0 + TAPER**2) / (1.0 - TAPER**2 * TANGENT**2)
    assert raw.cone_factor is None
    assert raw.lean[0] / TANGENT == pytest.approx(factor, abs=4e-5)
    assert right.cone_factor == pytest.approx(factor, abs=1e-5)
    assert raw.lean / right.cone_factor == pytest.approx(right.lean, rel=1e-9)
    assert right.axis.lean == pytest.approx(right.lean, rel=1e-12)


def test_the_paper_knows_no_cone() -> None:
    found = lean("A", "paper", leaning_cone("perpendicular"))
    assert found.cone_factor is None
    assert found.lean == pytest.approx(lean("A", "paper", leaning_cone("horizontal")).lean, rel=1e-12)


def test_two_heights_without_points_are_a_failure_with_a_reason() -> None:
    middle = (CLOUD.points_m[:, 2] > 30.0) & (CLOUD.points_m[:, 2] < 31.0)
    few = PlacedCloud(CLOUD.points_m[middle], CLOUD.station_index[middle])
    found = lean_of_scheme(shaft_of(few), SCHEMES["E"], method_of(SCHEMES["E"], "robust"))
    assert found == FitFailure("needs at least 2 centres, got 0")
