import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.trend import LeanSeries, choose_terms


def series(times: NDArray[np.float64], temperatures: NDArray[np.float64] | None = None) -> LeanSeries:
    n = len(times)
    return LeanSeries(times, np.zeros((n, 2)), np.tile(1e-6 * np.eye(2), (n, 1, 1)), temperatures)


QUARTERLY = np.arange(16) / 4.0 + 0.03


@pytest.mark.parametrize(
    ("times", "model"),
    [
        (np.arange(1) * 1.0, "level"),
        (np.arange(2) * 1.0, "level"),
        (np.zeros(5), "level"),
        (np.arange(3) * 1.0, "rate"),
        (np.arange(5) * 1.0, "rate"),
        (np.arange(6) * 1.0, "rate + random walk"),
        (QUARTERLY, "rate + season + random walk"),
        (QUARTERLY[:7], "rate + random walk"),
    ],
)
def test_terms_are_as_many_as_the_epochs_can_tell_apart(times: NDArray[np.float64], model: str) -> None:
    assert choose_terms(series(times)).model == model


def test_epochs_at_two_phases_of_the_year_tell_no_season() -> None:
    chosen = choose_terms(series(np.arange(20) / 2.0))
    assert not chosen.season
    assert "6.0 months of the year without an epoch" in chosen.reason


def test_a_season_within_one_year_is_not_asked_for() -> None:
    assert "no season: 1.10 years" in choose_terms(series(np.linspace(0.0, 1.1, 12))).reason


def test_temperature_takes_the_place_of_a_season_that_it_follows() -> None:
    chosen = choose_terms(series(QUARTERLY, 10.0 + 12.0 * np.cos(2 * np.pi * QUARTERLY)))
    assert chosen.model == "rate + temperature + random walk"
    assert "the temperature tells it already" in chosen.reason


def test_temperature_and_season_stand_beside_each_other_where_they_differ() -> None:
    rng = np.random.default_rng(1)
    chosen = choose_terms(series(QUARTERLY, rng.uniform(0.0, 25.0, len(QUARTERLY))))
    assert chosen.model == "rate + season + temperature + random walk"


def test_a_temperature_that_hardly_differs_is_left_out() -> None:
    chosen = choose_terms(series(QUARTERLY, np.linspace(14.0, 17.0, len(QUARTERLY))))
    assert "no temperature: it differs by 3.0 K" in chosen.reason


def test_a_temperature_that_only_goes_with_time_is_left_out() -> None:
    chosen = choose_terms(series(QUARTERLY, 5.0 + 6.0 * QUARTERLY))
    assert "no temperature: it only goes with time" in chosen.reason


def test_epochs_of_one_instant_count_once() -> None:
    assert choose_terms(series(np.repeat([0.0, 1.0], 6))).model == "level"
    assert choose_terms(series(np.repeat([0.0, 1.0, 2.0], 4))).model == "rate"
