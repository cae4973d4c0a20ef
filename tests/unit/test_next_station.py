"""What one more station would do: laws of the prediction, and the prediction against fits of simulated epochs."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.conventions import ARCSEC_RAD
from tasks.coverage import SECTORS, Coverage
from tasks.geometry.failure import FitFailure
from tasks.next_station import (
    Network,
    NextStation,
    form_sigma_m,
    lean_covariance,
    network_of,
    suggest_station,
)
from tasks.registration import registered_cloud
from tests.unit.networks import MODEL, coverage_from, registration, sigmas, with_more_points

EVEN = tuple(45.0 * i for i in range(8))
WEST = (240.0, 270.0, 300.0)


def suggested(
    azimuths_deg: Sequence[float], coverage: Coverage | None = None, level_arcsec: float = 2.9
) -> NextStation:
    stated = sigmas(level_arcsec)
    known = registration(azimuths_deg, stated)
    found = suggest_station(coverage or coverage_from(azimuths_deg), MODEL, known, stated)
    assert isinstance(found, NextStation)
    return found


def network(azimuths_deg: Sequence[float], level_arcsec: float = 2.9, **changed: object) -> Network:
    known = registration(azimuths_deg, sigmas(level_arcsec))
    return replace(network_of(coverage_from(azimuths_deg), MODEL, known), **changed)


def covariance_of(seen: Network) -> NDArray[np.float64]:
    covariance = lean_covariance(seen)
    assert not isinstance(covariance, FitFailure)
    return covariance


@pytest.mark.parametrize("level_arcsec", [0.5, 2.9, 30.0])
def test_with_all_stations_in_the_west_one_in_the_east_is_suggested(level_arcsec: float) -> None:
    assert suggested(WEST, level_arcsec=level_arcsec).azimuth_deg == pytest.approx(90.0, abs=30.0)


def test_what_is_suggested_turns_with_the_stations() -> None:
    turned = tuple((azimuth + 130.0) % 360.0 for azimuth in WEST)
    # other points, and azimuths in steps of 10 degrees
    assert suggested(turned).azimuth_deg == pytest.approx(220.0, abs=30.0)


def test_a_station_that_fell_out_of_a_ring_is_where_one_is_suggested() -> None:
    ring_without_east = tuple(azimuth for azimuth in EVEN if azimuth != 90.0)
    assert suggested(ring_without_east).azimuth_deg == pytest.approx(90.0, abs=30.0)


def test_a_ninth_station_beside_eight_even_ones_gains_little() -> None:
    # nine levels for eight leave 1 - sqrt(8/9) = 6 %
    assert 0.0 < suggested(EVEN).gain < 0.08


def test_a_second_station_gains_much() -> None:
    assert suggested([270.0]).gain > 0.15


@pytest.mark.parametrize("azimuths_deg", [EVEN, WEST, (0.0, 120.0, 240.0), (270.0,)])
def test_one_more_station_at_its_best_place_never_harms(azimuths_deg: tuple[float, ...]) -> None:
    assert suggested(azimuths_deg).gain > 0.0


def test_with_many_points_the_levels_of_the_stations_are_what_remains() -> None:
    perfect = network(EVEN, noise_m=1e-6, form_m=0.0)
    found = np.sqrt(np.trace(covariance_of(perfect)) / 2.0) / ARCSEC_RAD
    # equal shares would leave the least; a station that sees one side pulls more along its view than across
    assert 1.0 < found / (2.9 / np.sqrt(8.0)) < 1.1


def test_a_larger_level_sigma_makes_the_poses_dominate() -> None:
    fine, coarse = suggested(EVEN, level_arcsec=10.0), suggested(EVEN, level_arcsec=100.0)
    assert coarse.sigma_now_arcsec == pytest.approx(10.0 * fine.sigma_now_arcsec, rel=0.05)


def test_more_noise_makes_the_points_dominate() -> None:
    quiet, loud = (np.trace(covariance_of(network(EVEN, noise_m=s, form_m=0.0))) for s in (1.0, 10.0))
    # the levels are 1" of 39" of the quieter one
    assert loud == pytest.approx(100.0 * quiet, rel=5e-3)


def test_more_points_do_not_lower_what_the_form_of_the_shaft_leaves() -> None:
    few = coverage_from(EVEN)
    known = registration(EVEN, sigmas(1e-3))
    covariances = [
        covariance_of(replace(network_of(coverage, MODEL, known), noise_m=0.0, form_m=0.005))
        for coverage in (few, with_more_points(few, 100))
    ]
    assert covariances[1] == pytest.approx(covariances[0], rel=1e-9)


def test_full_even_coverage_reaches_the_closed_form() -> None:
    counts = np.full((20, SECTORS, 1), 100.0)
    seen = Network(
        z_m=4.5 + 5.0 * np.arange(20),
        counts=counts,
        pose_covariance=np.zeros((6, 6)),
        lean=np.zeros(2),
        noise_m=0.02,
        form_m=0.0,
    )
    # science.md section 3: 24 sigma^2 (m - 1) / (N L^2 m (m + 1)), N points a slice, m slices over L
    expected = 24.0 * 0.02**2 * 19.0 / (3600.0 * 95.0**2 * 20.0 * 21.0)
    assert covariance_of(seen) == pytest.approx(expected * np.eye(2), rel=1e-9, abs=1e-18)


def test_predicted_covariance_matches_the_scatter_of_fits() -> None:
    seen = network((240.0, 270.0, 20.0), noise_m=0.05, form_m=0.004, lean=np.zeros(2))
    rng = np.random.default_rng(3)
    leans = fitted_leans(seen, 1_500, rng)
    # 1,500 repeats tell a variance to 4 %
    assert np.cov(leans.T) == pytest.approx(covariance_of(seen), rel=0.15, abs=0.15 * np.var(leans))


def fitted_leans(seen: Network, repeats: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Leans (repeats, 2) of a shaft whose stations are out of level: circles in all bands, a line through the centres."""
    middle = np.radians(10.0 * np.arange(SECTORS) + 5.0)
    u = np.stack([np.sin(middle), np.cos(middle)], axis=1)
    n = seen.counts.sum(axis=2)
    level = np.sqrt(np.diag(seen.pose_covariance)[[0, 1]])
    rotation = level * rng.normal(size=(repeats, seen.counts.shape[2], 2))
    # a rotation about east and north moves the axis by (+w_north, -w_east) per metre of height
    shift = np.stack([rotation[..., 1], -rotation[..., 0]], axis=2)
    share = seen.counts / np.maximum(n, 1.0)[:, :, None]
    radial = np.einsum("bsk,b,rki,si->rbs", share, seen.z_m, shift, u, optimize=True)
    spread = np.sqrt(seen.noise_m**2 / np.maximum(n, 1.0) + seen.form_m**2)
    radial += spread * rng.normal(size=radial.shape)
    design = np.column_stack([u, np.ones(SECTORS)])
    normal, right = np.zeros((4, 4)), np.zeros((4, repeats))
    for band, (z, weight) in enumerate(zip(seen.z_m, n, strict=True)):
        information = design.T @ (weight[:, None] * design)
        circle = np.linalg.solve(information, design.T @ (weight[:, None] * radial[:, band].T))
        of_centre = np.linalg.inv(np.linalg.inv(information)[:2, :2])
        line = np.hstack([np.eye(2), z * np.eye(2)])
        normal += line.T @ of_centre @ line
        right += line.T @ of_centre @ circle[:2]
    return np.asarray(np.linalg.solve(normal, right)[2:].T)


def test_form_of_the_shaft_is_what_the_noise_does_not_explain() -> None:
    round_shaft = coverage_from(EVEN)
    bumps_m = 0.006 * np.random.default_rng(4).normal(size=round_shaft.points.shape)
    bumpy = replace(round_shaft, off_sum_m=round_shaft.off_sum_m + bumps_m * round_shaft.points)
    # the noise of 10 mm on some 90 points of a piece leaves 1 mm
    assert form_sigma_m(round_shaft, 0.01) < 0.001
    assert form_sigma_m(bumpy, 0.01) == pytest.approx(0.006, rel=0.1)


def test_form_of_a_shaft_without_points_cannot_be_asked_for() -> None:
    coverage = coverage_from([0.0])
    empty = replace(coverage, counts=0 * coverage.counts)
    with pytest.raises(ShapeError, match="needs a coverage with points"):
        form_sigma_m(empty, 0.01)


def test_a_registered_cloud_gives_no_suggestion_because_its_stations_are_not_known() -> None:
    known = registered_cloud("registered", sigmas())
    found = suggest_station(coverage_from([0.0]), MODEL, known, sigmas())
    assert isinstance(found, FitFailure)
    assert "does not say where its scanners stood" in found.reason


def test_a_station_that_saw_nothing_of_the_shaft_changes_nothing() -> None:
    three = suggested(WEST)
    coverage = coverage_from(WEST)
    blind = replace(coverage, counts=np.pad(coverage.counts, ((0, 0), (0, 0), (0, 1))))
    found = suggested((*WEST, 90.0), blind)
    assert found.azimuth_deg == three.azimuth_deg
    assert found.sigma_then_arcsec == pytest.approx(three.sigma_then_arcsec, rel=1e-9)


@pytest.mark.parametrize(
    ("bands", "sectors", "why"),
    [
        (slice(0, 0), slice(None), "there are none"),
        (slice(3, 4), slice(None), "too few heights"),
        (slice(None), slice(7, 8), "too little of the circumference"),
    ],
)
def test_too_little_of_the_shaft_gives_a_reason(bands: slice, sectors: slice, why: str) -> None:
    coverage = coverage_from(EVEN)
    counts = np.zeros_like(coverage.counts)
    counts[bands, sectors] = coverage.counts[bands, sectors]
    found = suggest_station(replace(coverage, counts=counts), MODEL, registration(EVEN, sigmas()), sigmas())
    assert isinstance(found, FitFailure)
    assert why in found.reason
