"""What the rules find: the limit by its guard band, a movement by its test, a date by its band, the rest by the clock."""

from dataclasses import replace
from datetime import timedelta

import pytest
from scipy.stats import chi2

from tasks.alarms import RULES, Change, Finding, PendingEpoch, Record
from tests.unit.alarms.records import START, change, chart, deviation, epoch, record, time_of, trend


def last(kind: str, looked_at: Record, **keys: object) -> Finding | None:
    return RULES[kind].rule(**keys).points(looked_at)[-1].finding


def test_every_kind_of_the_grammar_is_there() -> None:
    assert sorted(RULES) == [
        "cusum",
        "late-station",
        "limit",
        "missed-campaign",
        "moved",
        "quality",
        "rate",
        "share-of-limit",
    ]
    assert all(len(kind.advice) > 20 for kind in RULES.values())


@pytest.mark.parametrize(
    ("verdict", "at_least", "broken"),
    [
        ("pass", "fail", False),
        ("cannot tell", "fail", False),
        ("fail", "fail", True),
        ("pass", "cannot tell", False),
        ("cannot tell", "cannot tell", True),
        ("fail", "cannot tell", True),
    ],
)
def test_limit_follows_the_verdict(verdict: str, at_least: str, broken: bool) -> None:
    looked_at = record(epoch(0, deviation=deviation(0.1, verdict=verdict)))
    found = last("limit", looked_at, at_least=at_least, clear_ratio=0.9)
    assert (found.broken, found.value, found.limit_value, found.unit) == (broken, 0.1, 0.1, "m")


@pytest.mark.parametrize(
    ("metres", "at_least", "eased"),
    [
        (0.0939, "fail", True),
        (0.0941, "fail", False),
        (0.0859, "cannot tell", True),
        (0.0861, "cannot tell", False),
    ],
)
def test_limit_eases_when_the_end_of_the_band_is_back_below_the_share(
    metres: float, at_least: str, eased: bool
) -> None:
    found = last("limit", record(epoch(0, deviation=deviation(metres))), at_least=at_least, clear_ratio=0.9)
    assert found.eased is eased


def test_limit_without_a_sigma_never_eases_and_without_a_limit_tells_nothing() -> None:
    unknown = record(epoch(0, deviation=deviation(0.001, None, "cannot tell")))
    assert not last("limit", unknown, at_least="fail", clear_ratio=0.9).eased
    assert last("limit", record(epoch(0)), at_least="fail", clear_ratio=0.9) is None
    assert last("limit", record(epoch(0, deviation=None)), at_least="fail", clear_ratio=0.9) is None


@pytest.mark.parametrize(
    ("metres", "broken", "eased"), [(0.0801, True, False), (0.0799, False, False), (0.0719, False, True)]
)
def test_share_of_limit_takes_the_deviation_itself(metres: float, broken: bool, eased: bool) -> None:
    looked_at = record(epoch(0, deviation=deviation(metres, None)))
    found = last("share-of-limit", looked_at, share=0.8, clear_ratio=0.9)
    assert (found.broken, found.eased, found.limit_value) == (broken, eased, pytest.approx(0.08))


def moved(looked_at: Record, **keys: object) -> Finding | None:
    return last(
        "moved", looked_at, **{"p": 0.01, "quantity": "lean", "confirm": False, "clear_ratio": 0.9, **keys}
    )


def at_sigmas(size_m: float, sigma_m: float, towards: tuple[float, float] = (1.0, 0.0)) -> Change:
    """A change of the same sigma in all directions, with the exact probability of two degrees of freedom."""
    statistic = (size_m / sigma_m) ** 2
    return change(size_m, float(chi2.sf(statistic, 2)), statistic, towards)


def test_moved_states_the_size_that_would_just_be_significant() -> None:
    found = moved(record(epoch(0), epoch(1, changes={"lean": at_sigmas(0.02, 0.002)})))
    assert found.broken
    assert found.limit_value == pytest.approx(0.002 * chi2.isf(0.01, 2) ** 0.5)
    just = at_sigmas(found.limit_value * 0.999, 0.002)
    assert not moved(record(epoch(0), epoch(1, changes={"lean": just}))).broken


@pytest.mark.parametrize(("p", "broken"), [(0.05, True), (0.01, False)])
def test_moved_counts_from_its_own_probability_on(p: float, broken: bool) -> None:
    looked_at = record(epoch(0), epoch(1, changes={"lean": change(0.01, 0.02, 7.8)}))
    assert moved(looked_at, p=p).broken is broken


def test_moved_looks_at_the_quantity_that_it_names() -> None:
    changes = {"lean": at_sigmas(0.001, 0.002), "base": at_sigmas(0.03, 0.002)}
    looked_at = record(epoch(0), epoch(1, changes=changes))
    assert moved(looked_at, quantity="base").broken
    assert not moved(looked_at, quantity="lean").broken
    assert moved(looked_at, quantity="bending") is None


def test_the_reference_epoch_and_an_untested_change_tell_nothing() -> None:
    assert moved(record(epoch(0))) is None
    untested = replace(at_sigmas(0.02, 0.002), statistic=None, p_value=None)
    assert moved(record(epoch(0), epoch(1, changes={"lean": untested}))) is None


def test_no_change_at_all_eases() -> None:
    found = moved(record(epoch(0), epoch(1, changes={"lean": at_sigmas(0.0, 0.002)})))
    assert (found.broken, found.eased) == (False, True)


def confirmed(**later: object) -> Finding | None:
    first = epoch(1, changes={"lean": at_sigmas(0.02, 0.002)})
    return moved(record(epoch(0), first, epoch(2, **later)), confirm=True)


def test_a_movement_is_confirmed_by_the_epoch_before_it() -> None:
    found = confirmed(changes={"lean": at_sigmas(0.02, 0.002)})
    assert found.broken
    assert "confirmed by the epoch before" in found.what


def test_a_movement_into_another_direction_confirms_nothing() -> None:
    found = confirmed(changes={"lean": at_sigmas(0.02, 0.002, (-1.0, 0.0))})
    assert (found.broken, found.eased) == (False, False)
    assert found.what.endswith("not confirmed yet")


def test_the_first_epoch_that_moved_is_not_confirmed_yet() -> None:
    looked_at = record(epoch(0), epoch(1, changes={"lean": at_sigmas(0.02, 0.002)}))
    assert not moved(looked_at, confirm=True).broken


def test_a_movement_is_confirmed_by_the_control_of_the_same_epoch() -> None:
    both = {"changes": {"lean": at_sigmas(0.02, 0.002)}, "control_changes": {"lean": at_sigmas(0.02, 0.003)}}
    found = moved(record(epoch(0), epoch(1, **both)), confirm=True)
    assert found.broken
    assert "confirmed by the control" in found.what
    weak = {**both, "control_changes": {"lean": at_sigmas(0.02, 0.02)}}
    assert not moved(record(epoch(0), epoch(1, **weak)), confirm=True).broken


EPOCHS = [epoch(n) for n in range(6)]


def rate(**known: object) -> Finding | None:
    keys = {"mm_per_year": None, "limit_within_years": None, "clear_ratio": 0.9}
    limits = {key: known.pop(key) for key in list(known) if key in keys}
    return last("rate", record(*EPOCHS, rates=trend(**known)), **{**keys, **limits})


@pytest.mark.parametrize(
    ("limit", "broken", "eased"), [(4.9, True, False), (5.1, False, False), (5.6, False, True)]
)
def test_rate_is_broken_where_the_guard_band_is_above_it(limit: float, broken: bool, eased: bool) -> None:
    found = rate(mm_per_year=limit)  # 6.0 ± 1.0 mm a year
    assert (found.broken, found.eased) == (broken, eased)
    assert (found.value, found.limit_value) == (0.006, pytest.approx(limit / 1e3))


def test_a_rate_without_a_sigma_tells_nothing() -> None:
    assert rate(mm_per_year=1.0, rate_sigma_m_per_year=None) is None


@pytest.mark.parametrize(
    ("years", "broken", "eased"), [(3.1, True, False), (2.9, False, False), (2.6, False, True)]
)
def test_a_limit_is_near_by_the_early_end_of_its_band(years: float, broken: bool, eased: bool) -> None:
    found = rate(limit_within_years=years)  # three years of 365 days
    assert (found.broken, found.eased, found.falls) == (broken, eased, True)
    assert found.value == pytest.approx(3 * 365 / 365.25)


def test_a_limit_is_not_near_where_no_rate_leads_to_it() -> None:
    for known in ({"rate_significant": False}, {"limit_earliest_at": None}):
        found = rate(limit_within_years=5.0, **known)
        assert (found.broken, found.eased, found.value) == (False, True, 100.0)


def test_of_the_epochs_before_the_last_a_trend_tells_nothing() -> None:
    rule = RULES["rate"].rule(mm_per_year=1.0, limit_within_years=None, clear_ratio=0.9)
    points = rule.points(record(*EPOCHS, rates=trend()))
    assert [point.finding is None for point in points] == [True] * 5 + [False]
    assert rule.points(record(*EPOCHS)) == []


@pytest.mark.parametrize(
    ("cusum", "signal", "broken"),
    [(3.9, "watch", False), (4.0, "watch", True), (4.9, "alarm", False), (5.0, "alarm", True)],
)
def test_cusum_counts_from_its_limit_on(cusum: float, signal: str, broken: bool) -> None:
    found = last("cusum", record(epoch(0, chart=chart(cusum))), signal=signal, clear_ratio=0.9)
    assert found.broken is broken
    assert last("cusum", record(epoch(0)), signal=signal, clear_ratio=0.9) is None


def quality(known: dict[str, object], **keys: object) -> Finding | None:
    nothing = {"state": None, "sigma_mm": None, "coverage_deg": None, "stations": None, "clear_ratio": 0.9}
    return last("quality", record(epoch(0, **known)), **{**nothing, **keys})


@pytest.mark.parametrize(
    ("known", "keys", "broken"),
    [
        ({"state": "degraded", "reason": "ST02: no such file"}, {"state": "degraded"}, True),
        ({"state": "degraded"}, {"state": "failed"}, False),
        ({"state": "failed", "deviation": None}, {"state": "degraded"}, True),
        ({"deviation": None}, {"state": "failed"}, True),
        ({}, {"state": "degraded"}, False),
        ({"deviation": deviation(0.0, 0.0031)}, {"sigma_mm": 3.0}, True),
        ({"deviation": deviation(0.0, 0.0029)}, {"sigma_mm": 3.0}, False),
        ({"coverage_deg": 269.0}, {"coverage_deg": 270.0}, True),
        ({"coverage_deg": 271.0}, {"coverage_deg": 270.0}, False),
        ({"n_stations_used": 3}, {"stations": 4}, True),
        ({"n_stations_used": 4}, {"stations": 4}, False),
    ],
)
def test_quality_is_broken_by_what_is_worse_than_allowed(
    known: dict[str, object], keys: dict[str, object], broken: bool
) -> None:
    assert quality(known, **keys).broken is broken


def test_full_coverage_always_eases() -> None:
    assert quality({"coverage_deg": 360.0}, coverage_deg=350.0).eased


def test_quality_says_why() -> None:
    found = quality({"state": "degraded", "reason": "ST02: no such file"}, state="degraded")
    assert found.what == "the epoch is degraded: ST02: no such file"


def test_quality_of_what_is_not_known_tells_nothing() -> None:
    assert quality({"coverage_deg": None}, coverage_deg=270.0) is None
    assert quality({"deviation": None}, sigma_mm=3.0) is None


@pytest.mark.parametrize(("days", "broken"), [(37.0, False), (37.1, True)])
def test_a_campaign_is_missed_by_the_clock(days: float, broken: bool) -> None:
    looked_at = record(epoch(0), now=START + timedelta(days=days))
    found = last("missed-campaign", looked_at, interval_days=30.0, grace_days=7.0)
    assert (found.broken, found.eased, found.unit) == (broken, not broken, "d")


def test_an_epoch_dated_years_ahead_keeps_no_missed_campaign_quiet() -> None:
    now = time_of(0) + timedelta(days=38)
    rule = RULES["missed-campaign"].rule(interval_days=30.0, grace_days=7.0)
    (point,) = rule.points(record(epoch(0), epoch(40), now=now))
    assert (point.place, point.finding.broken) == ("e0", True)
    assert rule.points(record(epoch(40), now=now)) == []
    (point,) = rule.points(record(epoch(0), now=START - timedelta(hours=3)))
    assert "is dated ahead of this machine's clock" in point.finding.what


def test_a_failed_epoch_is_no_campaign() -> None:
    looked_at = record(epoch(0), epoch(1, state="failed"), now=time_of(1) + timedelta(days=1))
    (point,) = RULES["missed-campaign"].rule(interval_days=300.0, grace_days=0.0).points(looked_at)
    assert point.finding.broken
    assert (point.place, point.epoch) == ("e0", None)
    assert RULES["missed-campaign"].rule(interval_days=1.0, grace_days=0.0).points(record()) == []


def late(hours: float, *missing: str) -> Finding:
    pending = PendingEpoch(epoch="e9", first_arrival=START, missing=missing)
    looked_at = record(epoch(0), now=START + timedelta(hours=hours), pending=(pending,))
    return last("late-station", looked_at, hours=6.0)


def test_a_station_is_late_by_the_clock() -> None:
    assert not late(5.9, "ST03").broken
    found = late(6.5, "ST03", "ST04")
    assert found.broken
    assert found.what.startswith("ST03, ST04 missing 6.5 hours after the first station of e9 arrived")
    assert late(100.0).eased


def test_a_station_is_late_too_where_the_clock_was_set_back_since_the_first_arrived() -> None:
    assert not late(-5.9, "ST03").broken
    found = late(-87_660.0, "ST03")
    assert found.broken
    assert found.what.startswith(
        "ST03 missing by a clock that says 87660.0 hours before the first station of e9"
    )


def test_a_processed_epoch_waits_for_nothing() -> None:
    rule = RULES["late-station"].rule(hours=6.0)
    (point,) = rule.points(record(epoch(0), pending=None))
    assert (point.epoch, point.finding.eased) == ("e0", True)
