"""Which terms a trend has: as many as the epochs can tell apart, and why."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.trend.series import LeanSeries

RATE_EPOCHS: Final = 3
"""Below, a line goes through whatever was measured and nothing can contradict it."""

RATE_DAYS: Final = 1.0
"""Between first and last epoch; within a day a structure was measured once, in parts or repeatedly."""

DAYS_A_YEAR: Final = 365.25
"""All years are as long, leap years too: a rate per year is one per so many days."""

WALK_EPOCHS: Final = 6
"""Below, the random walk cannot be told from the rate: so few epochs allow for any walk, and no rate is ever found."""

SEASON_EPOCHS: Final = 8
"""Twice the unknowns of a component with season."""

SEASON_YEARS: Final = 1.5
"""Within one year a swing and a rate look alike."""

SEASON_GAP: Final = 0.42
"""Largest part of the year (five months) without any epoch; half-yearly epochs at two phases cannot tell a sine."""

TEMPERATURE_EPOCHS: Final = 6
TEMPERATURE_RANGE: Final = 5.0
"""Kelvin between coldest and warmest epoch, below which the movement by temperature is not worth an unknown."""

TEMPERATURE_APART: Final = 1.0
"""Kelvin that temperatures are off a line over time, root mean square; below, they cannot be told from the rate."""

SEASON_INFLATION: Final = 5.0
"""Largest variance inflation of temperature by the season beside it; above, they are the same thing measured twice."""


@dataclass(frozen=True, slots=True)
class Terms:
    """The terms of a trend and why these.

    ``reason`` is for the user: clauses joined by semicolons.
    """

    rate: bool
    season: bool
    temperature: bool
    random_walk: bool
    reason: str

    @property
    def model(self) -> str:
        """The terms in words, as ``rate + season + random walk``; ``level`` where there is no rate."""
        named = {
            "rate": self.rate,
            "season": self.season,
            "temperature": self.temperature,
            "random walk": self.random_walk,
        }
        return " + ".join(name for name, there in named.items() if there) or "level"


def choose_terms(series: LeanSeries) -> Terms:
    """Choose the terms by how many epochs there are and how they are spread over the years and their phases.

    Epochs at the same instant count once.
    """
    n, span = series.n_times, series.span
    if n < RATE_EPOCHS:
        return Terms(
            False, False, False, False, f"no rate: {_counted(n)} over {span:.2f} years, needs {RATE_EPOCHS}"
        )
    if span * DAYS_A_YEAR < RATE_DAYS:
        why = f"no rate: {_counted(n)} within {86_400.0 * DAYS_A_YEAR * span:.3g} s, needs {RATE_DAYS:g} day"
        return Terms(False, False, False, False, why)
    temperature, why_temperature = _temperature(series)
    season, why_season = _season(series, temperature)
    walk = n >= WALK_EPOCHS
    why_walk = (
        "random walk estimated" if walk else f"random walk taken as none: {n} epochs, needs {WALK_EPOCHS}"
    )
    reason = "; ".join([f"rate: {_counted(n)} over {span:.2f} years", why_season, why_temperature, why_walk])
    return Terms(True, season, temperature, walk, reason)


def design_columns(series: LeanSeries, terms: Terms) -> NDArray[np.float64]:
    """Columns (n, p) of one component: level at the last epoch, rate, cosine and sine of the year, temperature.

    Times count from the last epoch and temperatures from their mean, so that the level is the movement at the last epoch
    in the mean of a year and at the mean temperature.
    """
    t = series.times
    columns = [np.ones_like(t)]
    if terms.rate:
        columns.append(t - t[-1])
    if terms.season:
        columns += [np.cos(2 * np.pi * t), np.sin(2 * np.pi * t)]
    if terms.temperature and series.temperatures is not None:
        columns.append(series.temperatures - series.temperatures.mean())
    return np.column_stack(columns)


def _counted(n: int) -> str:
    return f"{n} epoch{'' if n == 1 else 's'}"


def _temperature(series: LeanSeries) -> tuple[bool, str]:
    if series.temperatures is None:
        return False, "no temperature: not given at every epoch"
    n, kelvin = series.n_times, float(np.ptp(series.temperatures))
    if n < TEMPERATURE_EPOCHS:
        return False, f"no temperature: {n} epochs, needs {TEMPERATURE_EPOCHS}"
    if kelvin < TEMPERATURE_RANGE:
        return False, f"no temperature: it differs by {kelvin:.1f} K, needs {TEMPERATURE_RANGE:g}"
    if _unexplained(series.temperatures, _line(series.times)) < n * TEMPERATURE_APART**2:
        return False, "no temperature: it only goes with time"
    return True, f"temperature: given, differs by {kelvin:.1f} K"


def _season(series: LeanSeries, temperature: bool) -> tuple[bool, str]:
    needed = SEASON_EPOCHS + (2 if temperature else 0)
    gap = largest_phase_gap(series.times)
    if series.n_times < needed:
        return False, f"no season: {series.n_times} epochs, needs {needed}"
    if series.span < SEASON_YEARS:
        return False, f"no season: {series.span:.2f} years, needs {SEASON_YEARS:g}"
    if gap > SEASON_GAP:
        return False, f"no season: {12 * gap:.1f} months of the year without an epoch, at most 5"
    if (
        temperature
        and series.temperatures is not None
        and _inflation(series.times, series.temperatures) > SEASON_INFLATION
    ):
        return False, "no season: the temperature tells it already"
    return True, f"season: at most {12 * gap:.1f} months of the year without an epoch"


def largest_phase_gap(times: NDArray[np.float64]) -> float:
    """Largest part of the year in which no epoch of any year falls, 0 to 1."""
    phases = np.sort(np.mod(times, 1.0))
    return float(np.diff(np.append(phases, phases[0] + 1.0)).max())


def _inflation(times: NDArray[np.float64], temperatures: NDArray[np.float64]) -> float:
    """By how much the season beside it inflates the variance of the movement by temperature."""
    line = _line(times)
    year = np.column_stack([line, np.cos(2 * np.pi * times), np.sin(2 * np.pi * times)])
    alone, beside = (_unexplained(temperatures, columns) for columns in (line, year))
    return alone / beside if beside > 0.0 else np.inf


def _line(times: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.column_stack([np.ones_like(times), times - times[-1]])


def _unexplained(values: NDArray[np.float64], columns: NDArray[np.float64]) -> float:
    left = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(left @ left)
