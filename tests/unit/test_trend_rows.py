"""Trends and control charts of stored axes, with numbers made by hand."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from storage.records import TiltRow, TrendRow
from tasks.lean_series import YEAR, own_covariance, stored_series
from tasks.trend import control_limit
from tasks.trend_rows import chart_rows, trend_rows

HEIGHT_M = 100.0
FIRST = datetime(2015, 3, 1, tzinfo=UTC)
SIGMA = 1e-5
"""Of a component of the lean: 1 mm at the top."""

BARE = TiltRow(
    structure="chimney-01",
    epoch="",
    epoch_time=FIRST,
    scheme="S",
    method="surface",
    n_slices=0,
    n_centres=0,
    base_east_m=0.0,
    base_north_m=0.0,
    d_east=0.0,
    d_north=0.0,
    d_up=1.0,
    lean_east=0.0,
    lean_north=0.0,
    lean_cov_ee=SIGMA**2,
    lean_cov_en=0.0,
    lean_cov_nn=SIGMA**2,
    point_cov_ee=None,
    point_cov_en=None,
    point_cov_nn=None,
    tilt_deg=0.0,
    tilt_sigma_deg=None,
    azimuth_deg=None,
    azimuth_sigma_deg=None,
    beta_deg=90.0,
    verticality_permille=0.0,
    height_m=HEIGHT_M,
    deviation_m=0.0,
    deviation_sigma_m=None,
    allowable_m=0.5,
    verdict="pass",
    verdict_reason=None,
    iterations=None,
    update_weight_ratio_pct=None,
    n_effective=None,
    mean_deviation_m=None,
    rmse_m=None,
    bending_m=None,
)


def rows_of(
    movements_m: np.ndarray, days: np.ndarray, scheme: str = "S", method: str = "surface"
) -> list[TiltRow]:
    return [
        replace(
            BARE,
            epoch=f"e{k + 1:02d}",
            epoch_time=FIRST + timedelta(days=float(day)),
            scheme=scheme,
            method=method,
            lean_east=float(moved[0]) / HEIGHT_M,
            lean_north=float(moved[1]) / HEIGHT_M,
        )
        for k, (moved, day) in enumerate(zip(movements_m, days, strict=True))
    ]


def campaign(rate_m: float = 0.010, n: int = 12, seed: int = 3) -> tuple[list[TiltRow], datetime]:
    """Half-yearly to yearly; a movement to the north-east sets in half a year before the seventh epoch."""
    rng = np.random.default_rng(seed)
    days = np.cumsum(rng.integers(182, 366, n))
    onset = float(days[6]) - 100.0
    years = np.maximum(days - onset, 0.0) / 365.25
    moved = np.array([0.15, 0.05]) + rate_m * years[:, None] * [0.8, 0.6]
    return rows_of(moved + 0.001 * rng.standard_normal((n, 2)), days), FIRST + timedelta(days=onset)


def only(rows: list[TrendRow]) -> TrendRow:
    assert len(rows) == 1
    return rows[0]


def test_a_movement_that_starts_at_the_seventh_of_twelve_epochs_is_told() -> None:
    tilt, onset = campaign()
    row = only(trend_rows(tilt))
    assert (row.change_point_kind, row.change_point_epoch) == ("rate", "e07")
    assert row.change_point_p_value is not None
    assert row.change_point_p_value < 0.01
    assert row.change_point_earliest is not None
    assert row.change_point_latest is not None
    assert row.change_point_earliest <= onset <= row.change_point_latest
    assert row.rate_after_m_per_year == pytest.approx(0.010, abs=2 * (row.rate_after_sigma_m_per_year or 0.0))
    assert row.rate_before_m_per_year == pytest.approx(0.0, abs=0.003)
    assert row.model.startswith("turn of the rate + rate")
    assert f"turn of the rate in {row.change_point_time:%Y-%m}" in row.reason


def test_rate_and_date_after_a_change_are_those_that_hold_now() -> None:
    tilt, _ = campaign()
    row = only(trend_rows(tilt))
    assert row.rate_m_per_year == row.rate_after_m_per_year
    assert row.rate_significant
    last = np.array([tilt[-1].lean_east, tilt[-1].lean_north]) * HEIGHT_M
    rate = np.array([0.008, 0.006])
    ahead = np.linspace(0.0, 100.0, 100001)
    reached = ahead[np.argmax(np.linalg.norm(last + np.outer(ahead, rate), axis=1) >= 0.5)]
    assert row.limit_earliest_at is not None
    assert row.limit_latest_at is not None
    assert row.limit_earliest_at < row.last_time + reached * YEAR < row.limit_latest_at


def test_a_still_structure_has_no_change_point_and_no_significant_rate() -> None:
    row = only(trend_rows(campaign(rate_m=0.0)[0]))
    assert row.change_point_epoch is None
    assert row.change_point_p_value is not None
    assert row.change_point_p_value > 0.01
    assert row.rate_significant is False
    assert "no change point: the best has p =" in row.reason


def test_schemes_beside_the_primary_follow_its_change_point() -> None:
    tilt, _ = campaign()
    others = [replace(row, scheme="A", method="robust") for row in tilt]
    first, second = trend_rows([*others, *tilt], primary=("S", "surface"))
    assert (first.scheme, second.scheme) == ("A", "S")
    assert first.change_point_epoch is None
    assert first.change_point_p_value is None
    assert "change as found under the primary scheme" in first.reason
    assert first.rate_m_per_year == pytest.approx(second.rate_m_per_year, rel=0.1)


def test_movements_are_those_at_the_height_of_the_last_epoch() -> None:
    tilt, _ = campaign()
    taller = [*tilt[:-1], replace(tilt[-1], height_m=2 * HEIGHT_M)]
    row = only(trend_rows(taller))
    assert row.height_m == 2 * HEIGHT_M
    assert row.rate_m_per_year == pytest.approx(0.020, rel=0.1)


def test_order_of_the_rows_does_not_matter() -> None:
    tilt, _ = campaign()
    assert trend_rows(tilt[::-1]) == trend_rows(tilt)


def test_epochs_without_a_covariance_are_left_out_and_counted() -> None:
    tilt, _ = campaign()
    lame = [replace(tilt[0], lean_cov_ee=None), *tilt[1:]]
    row = only(trend_rows(lame))
    assert (row.n_epochs, row.first_epoch) == (11, "e02")
    assert "1 epochs without a covariance left out" in row.reason
    assert len(chart_rows(lame)) == 10
    assert trend_rows([replace(one, lean_cov_ee=None) for one in tilt]) == []


@pytest.mark.parametrize("n", [1, 2])
def test_one_or_two_epochs_have_a_row_with_a_reason_and_no_rate(n: int) -> None:
    row = only(trend_rows(campaign(n=12)[0][:n]))
    assert row.n_epochs == n
    assert row.rate_m_per_year is None
    assert row.reason.startswith("no rate")
    assert len(chart_rows(campaign()[0][:n])) == n - 1


def test_without_a_limit_no_date_is_told() -> None:
    tilt = [replace(row, allowable_m=None) for row in campaign()[0]]
    row = only(trend_rows(tilt))
    assert (row.limit_m, row.limit_reached_at) == (None, None)
    assert "no limit at this height" in row.reason


def test_temperatures_of_every_epoch_are_used_and_those_of_some_are_not() -> None:
    tilt, _ = campaign(rate_m=0.0)
    rng = np.random.default_rng(1)
    kelvin = rng.uniform(0.0, 30.0, 12)
    warm = [
        replace(row, lean_east=row.lean_east + 0.0005 * t / HEIGHT_M)
        for row, t in zip(tilt, kelvin, strict=True)
    ]
    known = {row.epoch: float(t) for row, t in zip(tilt, kelvin, strict=True)}
    row = only(trend_rows(warm, known))
    assert row.temperature_m_per_degree == pytest.approx(
        0.0005, abs=3 * (row.temperature_sigma_m_per_degree or 0)
    )
    known.pop("e05")
    assert only(trend_rows(warm, known)).temperature_m_per_degree is None


def test_form_of_the_wall_is_common_to_all_epochs() -> None:
    """It widens the deviation, not the rate."""
    tilt, _ = campaign()
    form = (3 * SIGMA) ** 2
    waved = [
        replace(
            row,
            lean_cov_ee=SIGMA**2 + form,
            lean_cov_nn=SIGMA**2 + form,
            form_cov_ee=form,
            form_cov_en=0.0,
            form_cov_nn=form,
        )
        for row in tilt
    ]
    plain, wavy = only(trend_rows(tilt)), only(trend_rows(waved))
    assert wavy.rate_sigma_m_per_year == pytest.approx(plain.rate_sigma_m_per_year, rel=1e-6)
    assert wavy.misfit_p_value == pytest.approx(plain.misfit_p_value, rel=1e-6)
    assert (wavy.limit_earliest_at or FIRST) < (plain.limit_earliest_at or FIRST)
    found = stored_series(waved, {})[0].series.common
    np.testing.assert_allclose(found, HEIGHT_M**2 * form * np.eye(2))


def test_covariance_of_an_epoch_is_never_below_that_of_its_points() -> None:
    row = replace(
        BARE,
        point_cov_ee=0.5 * SIGMA**2,
        point_cov_en=0.1 * SIGMA**2,
        point_cov_nn=0.4 * SIGMA**2,
        form_cov_ee=0.9 * SIGMA**2,
        form_cov_en=0.0,
        form_cov_nn=0.1 * SIGMA**2,
    )
    own = own_covariance(row)
    assert own is not None
    points = SIGMA**2 * np.array([[0.5, 0.1], [0.1, 0.4]])
    assert np.linalg.eigvalsh(own - points).min() > -1e-6 * SIGMA**2


def test_form_as_large_as_everything_is_not_taken_off() -> None:
    row = replace(BARE, form_cov_ee=SIGMA**2, form_cov_en=0.0, form_cov_nn=SIGMA**2)
    np.testing.assert_allclose(own_covariance(row), SIGMA**2 * np.eye(2))


def test_chart_of_a_campaign_signals_after_the_movement_sets_in() -> None:
    tilt, onset = campaign()
    rows = chart_rows(tilt)
    assert [row.epoch for row in rows] == [f"e{k:02d}" for k in range(2, 13)]
    assert {row.signal for row in rows if row.epoch_time < onset} == {"none"}
    assert rows[-1].signal == "alarm"
    assert rows[0].watch_limit == control_limit(167.0)
    assert rows[0].alarm_limit == control_limit(455.0)
    assert rows[-1].cusum == max(
        rows[-1].cusum_up_1, rows[-1].cusum_down_1, rows[-1].cusum_up_2, rows[-1].cusum_down_2
    )
