import pytest
from hypothesis import given
from hypothesis import strategies as st

from storage.errors import ShapeError
from tasks.limits import allowable, table_named, table_of_points, verdict

QUOTED = table_named("gb50078-concrete-quoted")
ROUND = table_of_points([[100.0, 0.100]])


@pytest.mark.parametrize(
    ("deviation_m", "word"),
    [
        (0.0799, "pass"),
        (0.0801, "cannot tell"),
        (0.100, "cannot tell"),
        (0.1199, "cannot tell"),
        (0.1201, "fail"),
        (1.0, "fail"),
    ],
)
def test_guard_band_is_two_sigmas_on_either_side(deviation_m: float, word: str) -> None:
    assert verdict(deviation_m, 0.010, 100.0, ROUND).verdict == word


def test_a_deviation_of_zero_sigma_at_the_limit_keeps_it() -> None:
    assert verdict(0.100, 0.0, 100.0, ROUND).verdict == "pass"


@pytest.mark.parametrize("deviation_m", [0.0, 0.100, 17 * 0.0605])
def test_a_deviation_without_sigma_cannot_be_judged_however_far_it_is_from_the_limit(
    deviation_m: float,
) -> None:
    found = verdict(deviation_m, None, 102.0, QUOTED)
    assert found.verdict == "cannot tell"
    assert found.allowable_m == pytest.approx(0.0605)
    assert "of unknown uncertainty" in found.reason


@given(st.floats(0.0, 1.0), st.floats(0.0, 0.1), st.floats(0.0, 0.1))
def test_more_uncertainty_never_turns_pass_into_fail_or_doubt_into_certainty(
    d: float, s: float, more: float
) -> None:
    before, after = (verdict(d, sigma, 100.0, ROUND).verdict for sigma in (s, s + more))
    assert after in {before, "cannot tell"}


def test_reason_names_figures_limit_kind_and_standing() -> None:
    assert verdict(1.0373, 0.0035, 102.0, QUOTED).reason == (
        "1037.3 ± 7.0 mm (k=2) against 60.5 mm at 102 m "
        "(gb50078-concrete-quoted, a construction limit, not verified against the document)"
    )


def test_no_table_is_no_limit() -> None:
    found = verdict(1.0, 0.001, 102.0, None)
    assert (found.verdict, found.reason, found.allowable_m) == (
        "no limit",
        "the campaign file names no limit",
        None,
    )


def test_a_height_outside_the_table_is_no_limit_with_the_tables_own_reason() -> None:
    found = verdict(1.0, 0.001, 80.0, QUOTED)
    assert (found.verdict, found.allowable_m) == ("no limit", None)
    assert found.reason == (
        "gb50078-concrete-quoted: the table holds from 100 m to 120 m; the height is 80 m (construction limit)"
    )


def test_allowable_of_a_verdict_is_that_of_the_table() -> None:
    assert verdict(0.1, 0.01, 105.0, QUOTED).allowable_m == allowable(QUOTED, 105.0)


@pytest.mark.parametrize(("deviation_m", "sigma_m"), [(-0.1, 0.01), (0.1, -0.01), (float("nan"), 0.01)])
def test_negative_or_missing_numbers_are_refused(deviation_m: float, sigma_m: float) -> None:
    with pytest.raises(ShapeError, match="not negative"):
        verdict(deviation_m, sigma_m, 102.0, QUOTED)
