"""Many independent trials, spread over processes; trial k of a case is the same whatever the number of processes."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

T = TypeVar("T")

CHUNK = 4


def run_trials(trial: Callable[[int], T], n: int, processes: int) -> list[T]:
    """Results of trials 0 to n - 1, in their order."""
    if processes <= 1:
        return [trial(number) for number in range(n)]
    with ProcessPoolExecutor(processes, get_context("forkserver"), initializer=_one_thread) as pool:
        return list(pool.map(trial, range(n), chunksize=CHUNK))


def rng_of(seed: int, *which: int) -> np.random.Generator:
    """Generator of one trial of one case."""
    return np.random.default_rng([seed, *which])


def _one_thread() -> None:
    threadpool_limits(limits=1)
