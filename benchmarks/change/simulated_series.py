"""Series of movements with known truth: noise of the epochs, a random walk, and whatever is to be found."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tasks.trend import LeanSeries


@dataclass(frozen=True, slots=True)
class Wander:
    """How epochs scatter: sigma of a component of an epoch, metres, and of the random walk, metres per root year."""

    noise_m: float
    walk_m: float

    @property
    def said(self) -> str:
        """Both in millimetres."""
        return f"{1000 * self.noise_m:g} | {1000 * self.walk_m:g}"


def irregular_times(
    rng: np.random.Generator, n_epochs: int, shortest: float = 0.5, longest: float = 1.0
) -> NDArray[np.float64]:
    """Epochs in years, half-yearly to yearly, from 0 on."""
    steps = rng.uniform(shortest, longest, n_epochs - 1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def simulated_series(
    rng: np.random.Generator, times: NDArray[np.float64], moved: NDArray[np.float64], wander: Wander
) -> LeanSeries:
    """Series whose true movements are ``moved`` (n, 2) and a random walk; correlated noise with the stated covariance."""
    n = len(times)
    factor = wander.noise_m * np.array([[1.0, 0.0], [0.4, 0.9]])
    steps = np.sqrt(np.diff(times, prepend=times[0]))[:, None] * rng.standard_normal((n, 2))
    walked = wander.walk_m * np.cumsum(steps, axis=0)
    noise = rng.standard_normal((n, 2)) @ factor.T
    return LeanSeries(times, moved + walked + noise, np.tile(factor @ factor.T, (n, 1, 1)))


def asked_of(command: str, about: str | None, arguments: Sequence[str], trials: int) -> argparse.Namespace:
    """Options that the commands on series have in common."""
    parser = argparse.ArgumentParser(
        prog=f"benchmarks.change {command}", description=about, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=trials)
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args(arguments)


def print_rows(head: str, rows: Sequence[str]) -> None:
    """A Markdown table from lines whose cells are parted by ``|``."""
    line: Callable[[str], str] = "| {} |".format
    print(line(head))
    print("|" + "---|" * (head.count("|") + 1))
    for row in rows:
        print(line(row))
    print(flush=True)
