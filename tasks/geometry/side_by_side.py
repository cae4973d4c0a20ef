"""Do independent pieces of work side by side, with the same result as one after the other."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Final, TypeVar

from threadpoolctl import threadpool_limits

T = TypeVar("T")
R = TypeVar("R")

THREADS: Final = 4
"""At most; no more than there are cores, since each holds what it works on."""

_allowed = min(THREADS, os.cpu_count() or 1)


def side_by_side(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """Results of a function for all items, in their order."""
    one_blas_thread()
    several = list(items)
    if _allowed == 1 or len(several) <= 1:
        return [function(item) for item in several]
    with ThreadPoolExecutor(min(_allowed, len(several))) as pool:
        return list(pool.map(function, several))


def keep_to_threads(count: int) -> None:
    """Let this process work in no more threads from now on: where it has one core and others have the rest."""
    global _allowed  # noqa: PLW0603 - of the process, as the limit of BLAS is
    _allowed = max(1, min(count, THREADS))


@cache
def one_blas_thread() -> None:
    """Let BLAS work in the thread that calls it, from now on.

    The matrices here are tall and narrow: threads of BLAS below threads of ours wait for each other, on a busy machine for
    longer than they work; and the order of their sums, so the last bits of a result, would depend on the machine.
    """
    threadpool_limits(limits=1, user_api="blas")
