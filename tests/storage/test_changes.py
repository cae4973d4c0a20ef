"""The view ``changes`` against the same test written out in NumPy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from storage.catalog import rebuild_catalog
from storage.publish import publish_epoch
from storage.records import TiltRow
from storage.views import ChangeRow, change_rows
from storage.workspace import Workspace
from tests.storage.campaign import HEIGHT_M, STRUCTURE, epoch_tables, tilt_row

COVARIANCES = ("lean_cov_ee", "lean_cov_en", "lean_cov_nn")


def publish(ws: Workspace, number: int, *axes: TiltRow, **changed: object) -> None:
    epoch = f"e{number}"
    publish_epoch(ws, STRUCTURE, epoch, {**epoch_tables(epoch, number, **changed), "tilt": list(axes)})


def changes_between(ws: Workspace, base: TiltRow, later: TiltRow) -> list[ChangeRow]:
    publish(ws, 0, base)
    publish(ws, 1, later)
    rebuild_catalog(ws)
    return change_rows(ws, STRUCTURE)


def covariance(row: TiltRow) -> np.ndarray:
    return np.array([[row.lean_cov_ee, row.lean_cov_en], [row.lean_cov_en, row.lean_cov_nn]])


def test_a_change_is_tested_as_two_degrees_of_freedom_demand(ws: Workspace) -> None:
    base = tilt_row("e0", 0, (0.0070, -0.0057))
    later = tilt_row("e1", 1, (0.00713, -0.00562), lean_cov_ee=5e-10, lean_cov_en=-2e-10, lean_cov_nn=3e-10)
    (row,) = changes_between(ws, base, later)
    d = np.array([0.00013, 0.00008])
    C = covariance(base) + covariance(later)
    u = d / np.linalg.norm(d)
    # differences of doubles near 0.007: 1e-18 of 1e-4 at best, so 1e-12 relative is ample
    assert row.d_top_m == pytest.approx(HEIGHT_M * np.linalg.norm(d), rel=1e-12)
    assert row.sigma_top_m == pytest.approx(HEIGHT_M * math.sqrt(u @ C @ u), rel=1e-12)
    assert row.chi2 == pytest.approx(d @ np.linalg.solve(C, d), rel=1e-12)
    assert row.p_value == pytest.approx(chi2.sf(row.chi2, 2), rel=1e-12)
    assert row.significant == (row.p_value < 0.01)
    largest = np.linalg.eigvalsh(C)[-1]
    # the constant is rounded to five figures
    assert row.smallest_detectable_m == pytest.approx(
        HEIGHT_M * noncentrality() ** 0.5 * math.sqrt(largest), rel=1e-5
    )


def noncentrality() -> float:
    """What a test of 1 % with two degrees of freedom finds in 80 % of cases."""
    return float(brentq(lambda shift: ncx2.sf(chi2.ppf(0.99, 2), 2, shift) - 0.8, 1.0, 40.0))


def test_the_stated_power_is_that_of_the_noncentral_distribution() -> None:
    assert math.sqrt(noncentrality()) == pytest.approx(3.7257, abs=5e-5)


def test_no_movement_is_not_significant_and_has_the_larger_sigma(ws: Workspace) -> None:
    base = tilt_row("e0", 0)
    (row,) = changes_between(ws, base, tilt_row("e1", 1))
    assert (row.d_top_m, row.chi2, row.p_value, row.significant) == (0.0, 0.0, 1.0, False)
    largest = np.linalg.eigvalsh(2.0 * covariance(base))[-1]
    assert row.sigma_top_m == pytest.approx(HEIGHT_M * math.sqrt(largest), rel=1e-12)


def test_an_unknown_covariance_tests_nothing(ws: Workspace) -> None:
    base = tilt_row("e0", 0, **dict.fromkeys(COVARIANCES))
    (row,) = changes_between(ws, base, tilt_row("e1", 1, (0.008, 0.0)))
    assert row.d_top_m > 0.0
    unknown = (row.sigma_top_m, row.chi2, row.p_value, row.significant, row.smallest_detectable_m)
    assert unknown == (None,) * 5


@pytest.mark.parametrize(
    "entries", [(0.0, 0.0, 0.0), (1e-10, 1e-10, 1e-10), (1e-10, 3e-10, 1e-10), (-1e-10, 0.0, -1e-10)]
)
def test_a_covariance_that_is_not_positive_definite_tests_nothing(
    ws: Workspace, entries: tuple[float, float, float]
) -> None:
    known = dict(zip(COVARIANCES, entries, strict=True))
    (row,) = changes_between(ws, tilt_row("e0", 0, **known), tilt_row("e1", 1, (0.008, 0.0), **known))
    assert (row.sigma_top_m, row.chi2, row.p_value, row.smallest_detectable_m) == (None,) * 4


def test_a_huge_movement_has_a_p_value_of_zero_not_an_error(ws: Workspace) -> None:
    (row,) = changes_between(ws, tilt_row("e0", 0), tilt_row("e1", 1, (0.5, 0.5)))
    assert (row.p_value, row.significant) == (0.0, True)


def test_changes_count_from_the_epoch_that_is_marked(ws: Workspace) -> None:
    for number in range(3):
        publish(ws, number, tilt_row(f"e{number}", number), is_reference=number == 1)
    rebuild_catalog(ws)
    assert [(row.epoch, row.reference_epoch) for row in change_rows(ws, STRUCTURE)] == [
        ("e0", "e1"),
        ("e2", "e1"),
    ]


def test_without_a_mark_changes_count_from_the_earliest_epoch_that_did_not_fail(ws: Workspace) -> None:
    publish(ws, 0, is_reference=False, state="failed")
    for number in (1, 2):
        publish(ws, number, tilt_row(f"e{number}", number), is_reference=False)
    rebuild_catalog(ws)
    assert [(row.epoch, row.reference_epoch) for row in change_rows(ws, STRUCTURE)] == [("e2", "e1")]


def test_only_the_same_scheme_and_method_are_compared(ws: Workspace) -> None:
    publish(ws, 0, tilt_row("e0"), replace(tilt_row("e0"), scheme="B"))
    publish(ws, 1, tilt_row("e1", 1), replace(tilt_row("e1", 1), method="robust"))
    rebuild_catalog(ws)
    assert [(row.scheme, row.method) for row in change_rows(ws, STRUCTURE)] == [("A", "paper")]


def test_the_chance_of_a_false_alarm_is_one_in_a_hundred(ws: Workspace) -> None:
    rng = np.random.default_rng(11)
    base = tilt_row("e0", 0, scheme="S0")
    sqrt_c = np.linalg.cholesky(covariance(base))
    n = 4000
    drawn = [np.array([0.007, -0.0057]) + sqrt_c @ rng.standard_normal(2) for _ in range(2 * n)]
    publish(
        ws,
        0,
        *(replace(base, scheme=f"S{k}", lean_east=d[0], lean_north=d[1]) for k, d in enumerate(drawn[:n])),
    )
    later = replace(base, epoch="e1")
    publish(
        ws,
        1,
        *(replace(later, scheme=f"S{k}", lean_east=d[0], lean_north=d[1]) for k, d in enumerate(drawn[n:])),
    )
    rebuild_catalog(ws)
    share = np.mean([row.significant for row in change_rows(ws, STRUCTURE)])
    # binomial standard deviation sqrt(0.01 * 0.99 / 4000) = 0.0016; four of them
    assert share == pytest.approx(0.01, abs=0.0064)
