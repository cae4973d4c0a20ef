"""Medians in place, compiled: for many small sets within one loop."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled


@compiled
def split(values: NDArray[np.float64], low: int, high: int) -> tuple[int, int]:
    """Move the smaller ones of values low to high before the larger ones.

    Those up to the second index are not larger, those from the first index on not smaller than any between them.
    """
    middle = (low + high) // 2
    if values[middle] < values[low]:
        values[middle], values[low] = values[low], values[middle]
    if values[high] < values[low]:
        values[high], values[low] = values[low], values[high]
    if values[high] < values[middle]:
        values[high], values[middle] = values[middle], values[high]
    pivot = values[middle]
    i, j = low, high
    while i <= j:
        while values[i] < pivot:
            i += 1
        while pivot < values[j]:
            j -= 1
        if i <= j:
            values[i], values[j] = values[j], values[i]
            i += 1
            j -= 1
    return i, j


@compiled
def select(values: NDArray[np.float64], place: int) -> float:
    """The value that would stand at a place if values (n,) were sorted; smaller ones are moved before it, larger behind."""
    low, high = 0, len(values) - 1
    while low < high:
        i, j = split(values, low, high)
        if place <= j:
            high = j
        elif place >= i:
            low = i
        else:
            break
    found: float = values[place]
    return found


@compiled
def median_in_place(values: NDArray[np.float64]) -> float:
    """Median of finite values (n,), n > 0, which change places."""
    half = len(values) // 2
    upper = select(values, half)
    if len(values) % 2:
        return upper
    lower: float = values[0]
    for i in range(1, half):
        lower = max(lower, values[i])
    return 0.5 * (lower + upper)
