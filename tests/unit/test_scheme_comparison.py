"""Schemes and reference measurements of an epoch beside each other: covariances, workload, recommendation."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.records import SchemeComparisonRow, SliceRow, TiltRow
from tasks.accuracy import lean_difference
from tasks.axis import fit_axis
from tasks.compared_axes import axis_of_scheme, difference_of
from tasks.evaluation import Occasion, ReferenceLean
from tasks.geometry.failure import FitFailure
from tasks.reference_rows import reference_rows
from tasks.scheme_comparison import EpochAxes, compare_schemes, labels_of
from tests.storage.campaign import reference_lean_row, slice_row, tilt_row

LEAN = np.array([0.007, -0.0057])
POSES = np.array([[4e-10, 1e-10], [1e-10, 5e-10]])
HEIGHTS_M = 2.1 + np.arange(100.0)
ROWS = {"A": np.arange(100), "B": np.arange(0, 100, 5), "C": np.arange(0, 100, 10), "E": np.array([0, 99])}
THICK_M, THIN_M = 0.2, 0.01


def axis_rows(
    scheme: str, method: str, noise_m: NDArray[np.float64], sigma_m: float
) -> tuple[TiltRow, list[SliceRow]]:
    """Rows of a scheme whose centres are off by noise_m (100, 2), fitted as the program does."""
    rows, estimator = ROWS[scheme], {"robust": "robust_line", "paper": "irls"}[method]
    z = HEIGHTS_M[rows]
    centres = np.column_stack([z[:, None] * LEAN + noise_m[rows], z])
    axis = fit_axis(estimator, centres, np.tile(np.eye(2) * sigma_m**2, (len(rows), 1, 1)))
    assert not isinstance(axis, FitFailure)
    P, C = axis.lean_covariance, axis.lean_covariance + POSES
    row = tilt_row("e1", 0, (float(axis.lean[0]), float(axis.lean[1])), scheme=scheme, method=method)
    slices = [
        replace(
            slice_row("e1", i),
            scheme=scheme,
            method=method,
            z_m=float(z[i]),
            thickness_m=THICK_M if method == "robust" else THIN_M,
            center_cov_ee=sigma_m**2,
            center_cov_nn=sigma_m**2,
            weight=float(axis.weights[i]),
        )
        for i in range(len(rows))
    ]
    stated = {
        "lean_cov_ee": float(C[0, 0]),
        "lean_cov_en": float(C[0, 1]),
        "lean_cov_nn": float(C[1, 1]),
        "point_cov_ee": float(P[0, 0]),
        "point_cov_en": float(P[0, 1]),
        "point_cov_nn": float(P[1, 1]),
    }
    return replace(row, n_slices=len(rows), n_centres=len(rows), **stated), slices


def epoch_of(rng: np.random.Generator, *wanted: tuple[str, str], sigma_m: float = 0.002) -> EpochAxes:
    """An epoch whose thin slices hold a fifth of the information of the thick ones about them."""
    thick = rng.normal(0.0, sigma_m, (100, 2))
    thin = thick + rng.normal(0.0, 2.0 * sigma_m, (100, 2))
    noise = {"robust": (thick, sigma_m), "paper": (thin, math.sqrt(5.0) * sigma_m)}
    made = [axis_rows(scheme, method, *noise[method]) for scheme, method in wanted]
    slices = [one for _, several in made for one in several]
    return EpochAxes("chimney-01", "e1", [row for row, _ in made], slices, [])


def by_label(rows: list[SchemeComparisonRow]) -> dict[str, SchemeComparisonRow]:
    return {row.compared: row for row in rows}


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("B", "robust"), ("A", "robust")),
        (("B", "paper"), ("A", "robust")),
        (("B", "paper"), ("A", "paper")),
        (("E", "robust"), ("A", "robust")),
    ],
)
def test_stated_sigma_of_a_difference_holds_for_the_estimators_as_they_are(
    one: tuple[str, str], other: tuple[str, str]
) -> None:
    rng = np.random.default_rng(8)
    squares, stated = [], []
    for _ in range(80):
        axes = epoch_of(rng, one, other)
        row = compare_schemes(axes, "/".join(other))[0]
        assert row.d_lean_east is not None
        assert row.d_cov_ee is not None
        squares.append([row.d_lean_east**2, (row.d_lean_north or 0.0) ** 2])
        stated.append([row.d_cov_ee, row.d_cov_nn])
    # 160 numbers know a sigma to 5.6 %; reweighting scatters up to 10 % more than it states, few centres state more
    assert math.sqrt(np.mean(stated) / np.mean(squares)) == pytest.approx(1.0, abs=0.2)


def test_poses_common_to_both_do_not_count_in_the_difference() -> None:
    rng = np.random.default_rng(2)
    axes = epoch_of(rng, ("A", "robust"), ("C", "robust"))
    c = by_label(compare_schemes(axes, "A/robust"))["C/robust"]
    assert c.shared == "poses and slices"
    assert c.d_cov_ee is not None
    assert c.d_cov_ee == pytest.approx(axes.tilt[1].point_cov_ee - axes.tilt[0].point_cov_ee, rel=0.5)
    assert c.d_cov_ee < axes.tilt[1].lean_cov_ee < axes.tilt[0].lean_cov_ee + axes.tilt[1].lean_cov_ee


def test_a_jackknife_as_stated_covariance_does_not_count_as_poses() -> None:
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"), ("C", "robust"))
    propagated = {f"propagated_cov_{k}": getattr(axes.tilt[1], f"lean_cov_{k}") for k in ("ee", "en", "nn")}
    jackknifed = replace(axes.tilt[1], **propagated, lean_cov_ee=1e-6, lean_cov_nn=1e-6)
    plain, stated = (
        compare_schemes(replace(axes, tilt=[axes.tilt[0], row]), "A/robust")[1]
        for row in (axes.tilt[1], jackknifed)
    )
    assert stated.d_cov_ee == pytest.approx(plain.d_cov_ee)
    assert stated.sigma_m == pytest.approx(0.102)


def test_a_reference_measurement_shares_nothing_with_ours() -> None:
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"))
    station = reference_lean_row("e1", lean_east=0.0072, lean_north=-0.0057, sigma=5e-5)
    row = by_label(compare_schemes(replace(axes, references=[station]), "A/robust"))["total station"]
    assert row.shared == "nothing"
    assert row.d_cov_ee == pytest.approx(axes.tilt[0].lean_cov_ee + 25e-10)
    assert row.significant is True
    assert (row.scheme, row.n_slices, row.is_enough, row.reason) == (None, None, None, None)


def test_ours_may_be_compared_with_a_reference_measurement() -> None:
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"), ("C", "robust"))
    axes = replace(axes, references=[reference_lean_row("e1")])
    rows = by_label(compare_schemes(axes, "total station"))
    assert rows["A/robust"].d_lean_east == pytest.approx(axes.tilt[0].lean_east - 0.00702)
    assert rows["total station"].d_lean_east is None
    assert labels_of(axes) == ["A/robust", "C/robust", "total station"]


def test_the_fewest_slices_that_cost_nothing_are_recommended_with_the_reason() -> None:
    axes = epoch_of(np.random.default_rng(2), *((scheme, "robust") for scheme in "ABCE"), sigma_m=2e-4)
    rows = by_label(compare_schemes(axes, "A/robust"))
    assert [label for label, row in rows.items() if row.is_recommended] == ["C/robust"]
    assert rows["C/robust"].reason == "sigma 0 % above that of A/robust, no significant difference"
    assert rows["E/robust"].is_enough is False
    assert rows["A/robust"].reason == "the smallest sigma of all"
    assert rows["B/robust"].workload_ratio == pytest.approx(0.2)


def test_poor_points_ask_for_more_slices() -> None:
    axes = epoch_of(np.random.default_rng(2), *((scheme, "robust") for scheme in "ABC"), sigma_m=4e-3)
    rows = by_label(compare_schemes(axes, "A/robust"))
    assert [label for label, row in rows.items() if row.is_recommended] == ["A/robust"]
    assert rows["C/robust"].excess_pct is not None
    assert rows["C/robust"].excess_pct > 10.0


def surface_of(row: TiltRow, share: float) -> TiltRow:
    """The whole surface, with that share of the point variances of a scheme."""
    points = {name: share * getattr(row, name) for name in ("point_cov_ee", "point_cov_en", "point_cov_nn")}
    stated = {
        name.replace("point", "lean"): value
        + getattr(row, name.replace("point", "lean"))
        - getattr(row, name)
        for name, value in points.items()
    }
    return replace(row, scheme="S", method="surface", **points, **stated)


def test_difference_from_the_whole_surface_is_the_one_variance_less_the_other() -> None:
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"))
    a, s = axes.tilt[0], surface_of(axes.tilt[0], 0.2)
    row = by_label(compare_schemes(replace(axes, tilt=[a, s]), "S/surface"))["A/robust"]
    assert row.shared == "poses and all points"
    assert row.d_cov_ee == pytest.approx(0.8 * a.point_cov_ee)
    assert row.workload_ratio is None


def test_surface_that_states_no_less_than_a_scheme_counts_as_independent() -> None:
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"))
    a, s = axes.tilt[0], surface_of(axes.tilt[0], 1.0)
    row = by_label(compare_schemes(replace(axes, tilt=[a, s]), "S/surface"))["A/robust"]
    assert row.shared == "poses"
    assert row.d_cov_ee == pytest.approx(2.0 * a.point_cov_ee)


def test_without_slices_points_count_as_independent() -> None:
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"), ("B", "robust"))
    one, other = (axis_of_scheme(row, []) for row in axes.tilt)
    found, shared = difference_of(one, other)
    assert shared == "poses"
    assert found.covariance == pytest.approx(one.point_covariance + other.point_covariance)


def test_unknown_covariances_leave_nulls_and_the_reason() -> None:
    names = ("lean_cov_ee", "lean_cov_en", "lean_cov_nn", "point_cov_ee", "point_cov_en", "point_cov_nn")
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"), ("B", "robust"))
    bare = replace(axes.tilt[1], **dict.fromkeys(names))
    row = compare_schemes(replace(axes, tilt=[axes.tilt[0], bare]), "A/robust")[1]
    assert (row.sigma_m, row.d_cov_ee, row.chi2, row.significant, row.is_enough) == (None,) * 5
    assert row.d_lean_east is not None
    assert row.reason == "its sigma is not known"


def test_a_primary_without_an_axis_leaves_the_advice_and_no_difference() -> None:
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"), ("B", "robust"))
    rows = compare_schemes(axes, "S/surface")
    assert {row.d_lean_east for row in rows} == {None}
    assert all(
        (row.reason or "").endswith("no difference: S/surface has no axis in this epoch") for row in rows
    )
    assert sum(row.is_recommended for row in rows) == 1


def test_reference_row_has_tilt_azimuth_and_deviation_with_sigmas() -> None:
    occasion = Occasion("chimney-01", "e1", "2025-03-14T06:00:00+08:00")
    (row,) = reference_rows(occasion, [ReferenceLean("plumb line", 0.01, 0.0, 1e-4)], 100.0)
    assert row.tilt_deg == pytest.approx(math.degrees(math.atan(0.01)))
    assert (row.azimuth_deg, row.azimuth_sigma_deg) == pytest.approx((90.0, math.degrees(0.01)))
    assert (row.deviation_m, row.deviation_sigma_m) == pytest.approx((1.0, 0.01))


def test_reference_below_three_sigmas_has_no_azimuth() -> None:
    occasion = Occasion("chimney-01", "e1", "2025-03-14T06:00:00+08:00")
    (row,) = reference_rows(occasion, [ReferenceLean("plumb line", 2e-4, 0.0, 1e-4)], 100.0)
    assert (row.azimuth_deg, row.azimuth_sigma_deg) == (None, None)
    assert row.deviation_sigma_m == pytest.approx(0.01)


def test_a_lean_against_itself_is_no_difference() -> None:
    axes = epoch_of(np.random.default_rng(2), ("A", "robust"))
    (axis,) = (axis_of_scheme(row, axes.slices) for row in axes.tilt)
    found, _ = difference_of(axis, axis)
    assert found.size == 0.0
    assert lean_difference(np.zeros(2), None).chi2 is None
