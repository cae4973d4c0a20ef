"""Processor seconds of this process and of all that it started, by what they are."""

from collections import Counter
from typing import Final

import psutil

KINDS: Final = {
    "multiprocessing": "workers",
    "prefect": "Prefect server",
    " worker ": "keepers of the workers",
    " scheduler ": "Dask scheduler",
    "weed": "S3 server",
}
"""A word of a command line, and whose it is; the first that fits counts."""


def processor_seconds() -> Counter[str]:
    """Seconds of processor time so far, user and system."""
    here = psutil.Process()
    seconds: Counter[str] = Counter()
    for process in [here, *here.children(recursive=True)]:
        try:
            times, command = process.cpu_times(), " ".join(process.cmdline())
        except psutil.Error:
            continue
        whose = "this process" if process.pid == here.pid else _whose(command)
        seconds[whose] += times.user + times.system
    return seconds


def _whose(command: str) -> str:
    return next((kind for word, kind in KINDS.items() if word in command), "others")
