"""How numbers are written."""

import math
from datetime import UTC, datetime, timedelta

import pytest

from dashboard import numbers


def test_what_does_not_exist_is_never_written_as_a_number() -> None:
    written = [
        numbers.number(None),
        numbers.number(math.nan),
        numbers.count(None),
        numbers.mm(None),
        numbers.signed_mm(None),
        numbers.mm_with_u(None, None),
        numbers.degrees(None),
        numbers.dms(None),
        numbers.probability(None),
        numbers.day(None),
        numbers.minute(None),
    ]
    assert set(written) == {numbers.MISSING}


def test_an_unknown_uncertainty_is_shown_as_unknown_beside_its_value() -> None:
    assert numbers.mm_with_u(0.0605, None) == "60.5 ± -- mm"


@pytest.mark.parametrize(
    ("value_m", "sigma_m", "text"),
    [
        (1.0374, 0.0035, "1037.4 ± 7.0 mm"),
        (1.0374, 0.035, "1037 ± 70 mm"),
        (0.0021, 0.00004, "2.10 ± 0.08 mm"),
        (-0.0021, 0.001, "\u22122.1 ± 2.0 mm"),
    ],
)
def test_a_value_has_the_decimals_of_its_uncertainty(value_m: float, sigma_m: float, text: str) -> None:
    assert numbers.mm_with_u(value_m, sigma_m) == text


@pytest.mark.parametrize(
    ("value_deg", "digits", "text"),
    [
        (0.5828, 1, "0°34′58.1″"),
        (90.42083333, 0, "90°25′15″"),
        (-1.5, 1, "\u22121°30′00.0″"),
        (0.99999999, 1, "1°00′00.0″"),
        (-0.0000001, 1, "0°00′00.0″"),
    ],
)
def test_degrees_minutes_and_seconds_carry_over_and_keep_the_sign(
    value_deg: float, digits: int, text: str
) -> None:
    assert numbers.dms(value_deg, digits) == text


def test_a_change_says_its_direction() -> None:
    assert (numbers.signed_mm(0.0021), numbers.signed_mm(-0.0021)) == ("+2.1 mm", "\u22122.1 mm")


def test_nothing_is_written_as_minus_zero() -> None:
    assert numbers.number(-0.001) == "0.0"


def test_an_epoch_that_lies_in_the_future_is_called_so() -> None:
    now = datetime(2026, 1, 1, tzinfo=UTC)
    assert numbers.age(now + timedelta(hours=1), now) == "in the future of this machine's clock"
    assert numbers.age(now - timedelta(days=1), now) == "24 hours ago"
    assert numbers.age(now - timedelta(days=1461), now) == "4.0 years ago"


def test_a_long_text_is_cut_at_a_word() -> None:
    assert numbers.brief("one two three", 9) == "one two …"
    assert numbers.brief("one two", 9) == "one two"


def test_a_probability_is_written_with_its_name() -> None:
    assert [numbers.p_value(value) for value in (0.031, 1e-9, None)] == ["p = 0.031", "p < 0.0001", "p = --"]
