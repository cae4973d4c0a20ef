import numpy as np
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


@pytest.mark.parametrize(
    ("deviation_m", "limit_m", "word"),
    [
        # below three sigmas the error has two components: 2.75 sigmas on the side of the limit
        (0.000, 0.0274, "cannot tell"),
        (0.000, 0.0276, "pass"),
        (0.029, 0.0564, "cannot tell"),
        (0.030, 0.0501, "pass"),
        (0.040, 0.0130, "cannot tell"),
        (0.041, 0.0130, "fail"),
    ],
)
def test_guard_band_is_wider_where_the_length_has_no_direction(
    deviation_m: float, limit_m: float, word: str
) -> None:
    found = verdict(deviation_m, 0.010, 100.0, table_of_points([[100.0, limit_m]]))
    assert found.verdict == word
    assert ("k=2.75" in found.reason) == (min(deviation_m, limit_m) < 0.030)


@pytest.mark.parametrize("limit_sigmas", [0.0, 0.5, 1.0, 2.0, 2.9, 3.0, 4.0, 8.0, 30.0])
def test_each_wrong_word_comes_in_less_than_one_of_thirty(limit_sigmas: float) -> None:
    """A lean whose length is just the limit is called "fail", or just beyond it "pass", by the error of both components."""
    rng = np.random.default_rng(8)
    limit_m = max(limit_sigmas, 1e-6) * 0.001
    found_m = np.hypot(limit_m + 0.001 * rng.normal(size=10_000), 0.001 * rng.normal(size=10_000))
    table = table_of_points([[100.0, limit_m]])
    words = [verdict(float(length), 0.001, 100.0, table).verdict for length in found_m]
    # one tail at 2 sigma is 2.3 %; the length of a vector is a little longer than its component
    assert words.count("fail") / len(words) < 1.0 / 30.0
    assert words.count("pass") / len(words) < 1.0 / 30.0
