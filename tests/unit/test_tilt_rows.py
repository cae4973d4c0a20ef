"""What a row of the tilt table tells of an axis, with numbers made by hand."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from storage.records import TiltRow
from tasks.axis import Axis, AxisCurve, fit_axis
from tasks.geometry.plane_vectors import DETECTABLE_FACTOR
from tasks.lean import Lean
from tasks.tilt_rows import RowHome, tilt_row

HOME = RowHome("chimney-01", "e1", "2025-03-14T06:00:00+08:00", "S", "surface")
HEIGHT_M = 102.0

COVARIANCES = {
    "lean": np.array([[5.0, 3.0], [3.0, 4.0]]) * 1e-10,
    "point": np.array([[1.0, 0.1], [0.1, 1.1]]) * 1e-10,
    "form": np.array([[0.2, 0.02], [0.02, 0.3]]) * 1e-10,
    "propagated": np.array([[2.0, 0.3], [0.3, 2.1]]) * 1e-10,
    "jackknife": np.array([[4.0, 2.5], [2.5, 3.0]]) * 1e-10,
    "bootstrap": np.array([[1.3, 0.4], [0.4, 1.4]]) * 1e-10,
}

CURVE = AxisCurve(
    model="parabola",
    reason="order 2: 20.00 mm, p 1e-9",
    z_m=np.array([2.0, 102.0]),
    east_m=np.array([0.0, 0.7]),
    north_m=np.array([0.0, -0.5]),
    base_lean=np.array([0.0061, -0.0048]),
    chord_lean=np.array([0.0072, -0.0058]),
    base_lean_sigma=3.1e-5,
)


def axis() -> Axis:
    found = fit_axis(
        "two_points", np.array([[0.3, -0.2, 0.0], [1.0, -0.77, 100.0]]), np.tile(1e-6 * np.eye(2), (2, 1, 1))
    )
    assert isinstance(found, Axis), found
    return found


def lean_of(found: Axis, covariances: dict[str, NDArray[np.float64]]) -> Lean:
    return Lean(
        axis=found,
        lean=found.lean,
        covariance=covariances["lean"],
        point_covariance=covariances["point"],
        form_covariance=covariances["form"],
        propagated=covariances["propagated"],
        jackknife=covariances.get("jackknife"),
        bootstrap=covariances.get("bootstrap"),
        source="jackknife",
        misfit_p=2e-4,
        n_slices=28,
        n_centres=27,
        cone_factor=1.0004,
        base_covariance=np.diag([9.0, 1.0]) * 1e-6,
    )


def whole_row() -> TiltRow:
    return tilt_row(
        HOME, lean_of(replace(axis(), curve=CURVE, warning="mind the ladder"), COVARIANCES), HEIGHT_M, None
    )


def bare_row() -> TiltRow:
    few = {name: COVARIANCES[name] for name in ("lean", "point", "form", "propagated")}
    lean = replace(
        lean_of(axis(), few), misfit_p=0.3, cone_factor=None, base_covariance=None, source="propagation"
    )
    return tilt_row(HOME, lean, HEIGHT_M, None)


@pytest.mark.parametrize("part", COVARIANCES)
def test_every_covariance_stands_in_its_own_columns(part: str) -> None:
    row, covariance = whole_row(), COVARIANCES[part]
    stored = tuple(getattr(row, f"{part}_cov_{entry}") for entry in ("ee", "en", "nn"))
    assert stored == (covariance[0, 0], covariance[0, 1], covariance[1, 1])


def test_the_row_says_where_its_covariance_comes_from() -> None:
    assert (whole_row().covariance_source, bare_row().covariance_source) == ("jackknife", "propagation")


@pytest.mark.parametrize(
    "column",
    [
        *(f"{part}_cov_{entry}" for part in ("jackknife", "bootstrap") for entry in ("ee", "en", "nn")),
        *("axis_model", "axis_reason", "base_lean_east", "base_lean_north", "base_lean_sigma"),
        *("chord_lean_east", "chord_lean_north", "cone_factor", "base_sigma_m", "warning"),
        # two centres leave nothing over
        *("iterations", "n_effective", "mean_deviation_m", "rmse_m", "bending_m", "update_weight_ratio_pct"),
    ],
)
def test_what_a_line_through_two_centres_does_not_have_is_missing_and_not_zero(column: str) -> None:
    assert getattr(bare_row(), column) is None


def test_what_bending_says_is_told_beside_the_straight_lean() -> None:
    row = whole_row()
    assert (row.axis_model, row.axis_reason) == (CURVE.model, CURVE.reason)
    assert (row.base_lean_east, row.base_lean_north, row.base_lean_sigma) == (0.0061, -0.0048, 3.1e-5)
    assert (row.chord_lean_east, row.chord_lean_north) == (0.0072, -0.0058)
    assert (row.lean_east, row.lean_north) == pytest.approx((0.007, -0.0057), rel=1e-12)
    assert row.cone_factor == 1.0004


def test_all_that_is_to_be_minded_stands_in_the_warning() -> None:
    minded = str(whole_row().warning).split("; ")
    assert minded[0] == "mind the ladder"
    assert minded[1].startswith("the stations disagree more than their stated errors allow (p = 0.0002)")
    assert len(minded) == 2


def test_a_lean_without_a_significant_direction_is_minded() -> None:
    upright = lean_of(axis(), {**COVARIANCES, "lean": 1e-4 * np.eye(2)})
    row = tilt_row(HOME, replace(upright, source="propagation"), HEIGHT_M, None)
    assert row.azimuth_deg is None
    assert row.warning == "the lean is below 3 sigma: its direction is not significant"


def test_the_base_is_where_the_axis_crosses_zero() -> None:
    assert (whole_row().base_east_m, whole_row().base_north_m) == pytest.approx((0.3, -0.2), abs=1e-12)


def test_the_sigma_of_the_base_is_that_of_one_component() -> None:
    assert whole_row().base_sigma_m == pytest.approx(np.sqrt(5e-6), rel=1e-12)


def test_what_shows_against_an_epoch_like_this_one_counts_the_worst_direction() -> None:
    # eigenvalues of [[5, 3], [3, 4]] are 4.5 +- sqrt(9.25)
    worst = (4.5 + np.sqrt(9.25)) * 1e-10
    wanted = HEIGHT_M * 3.7257 * np.sqrt(2.0 * worst)
    assert whole_row().smallest_detectable_m == pytest.approx(wanted, rel=1e-9)


def test_a_movement_of_that_size_shows_in_80_of_100() -> None:
    power = stats.ncx2.sf(stats.chi2.ppf(0.99, 2), 2, DETECTABLE_FACTOR**2)
    assert power == pytest.approx(0.80, abs=1e-4)


def test_the_sigma_of_the_deviation_is_along_the_lean() -> None:
    row = whole_row()
    along = np.array([0.007, -0.0057]) / np.hypot(0.007, 0.0057)
    assert row.deviation_m == pytest.approx(HEIGHT_M * np.hypot(0.007, 0.0057), rel=1e-12)
    assert row.deviation_sigma_m == pytest.approx(
        HEIGHT_M * np.sqrt(along @ COVARIANCES["lean"] @ along), rel=1e-9
    )


def test_the_row_belongs_to_its_epoch_at_its_instant() -> None:
    row = whole_row()
    assert (row.structure, row.epoch, row.scheme, row.method) == ("chimney-01", "e1", "S", "surface")
    assert row.epoch_time.astimezone(UTC) == datetime(2025, 3, 13, 22, tzinfo=UTC)
    assert (row.n_slices, row.n_centres, row.verdict) == (28, 27, "no limit")
