r"""Ours, the paper's method and other packages on the same clouds: error of the lean vector, and seconds.

    .venv/bin/python -m benchmarks.accuracy peers [--replicates 15] [--points 400000]

A cone of 100 m, radius 5 to 3 m, lean 10 permille, white radial noise of 15 mm; the ladder holds 10 % of the points, 30
degrees wide, 0.2 to 1.2 m outside. Who works on slices gets the same 100 of them, 5 cm thick. Figures are the root mean
square of the length of the error vector, arc seconds.

dendromatics asks for older versions of packages that we use, so it is installed beside them, for this command alone:

    .venv/bin/python -m pip install --target build/peers --no-deps dendromatics==0.7.0 joblib==1.6.0 \
        scikit-learn==1.7.2 CSF-3DFin==2.0.1 pgeof==0.3.4 circle-fit==0.2.1 pyransac3d==0.7.0
    PYTHONPATH=build/peers .venv/bin/python -m benchmarks.accuracy peers
"""

import argparse
import re
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from benchmarks.accuracy.markdown import print_table
from benchmarks.accuracy.peer_clouds import CASES, draw_cloud
from benchmarks.accuracy.peer_methods import Cloud, Lean, NoLeanError, methods
from benchmarks.accuracy.sliced_shaft import LEAN
from benchmarks.accuracy.trials import rng_of
from tasks.conventions import ARCSEC_RAD

SLOW = "pyransac3d"
SLOW_REPLICATES = 3
WORTHLESS_ARCSEC = 3600.0


@dataclass(slots=True)
class Run:
    """What a method made of one kind of cloud: lengths of its errors and its seconds, replicate by replicate."""

    errors: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)


def main(arguments: Sequence[str]) -> None:
    """Run everybody on every cloud and print one row a method."""
    asked = _asked(arguments)
    wanted = {
        name: method for name, method in methods().items() if re.search(asked.methods, name) is not None
    }
    runs: dict[tuple[str, str], Run] = defaultdict(Run)
    for number, (title, case) in enumerate(CASES.items()):
        for replicate in range(asked.replicates):
            cloud = draw_cloud(case, asked.points, rng_of(asked.seed, number, replicate))
            for name, method in wanted.items():
                if method is not None and (SLOW not in name or replicate < SLOW_REPLICATES):
                    _run(runs[name, title], method, cloud)
    print(f"{asked.replicates} clouds of {asked.points} points each\n")
    rows = [_row(name, method is not None, runs) for name, method in wanted.items()]
    print_table(["method", *(f'{title} (")' for title in CASES), "seconds a run", "failed"], rows)


def _asked(arguments: Sequence[str]) -> argparse.Namespace:
    wanted = argparse.ArgumentParser(prog="peers", description=__doc__)
    wanted.add_argument("--replicates", type=int, default=15)
    wanted.add_argument("--points", type=int, default=400_000)
    wanted.add_argument("--seed", type=int, default=1)
    wanted.add_argument("--methods", default="", help="pattern of the names of the methods")
    return wanted.parse_args(arguments)


def _run(run: Run, method: Callable[[Cloud], Lean], cloud_m: Cloud) -> None:
    started = perf_counter()
    try:
        lean = method(cloud_m)
    except NoLeanError as none:
        run.failed.append(str(none))
    else:
        run.errors.append(float(np.hypot(*(lean - LEAN))) / ARCSEC_RAD)
    run.seconds.append(perf_counter() - started)


def _row(name: str, installed: bool, runs: dict[tuple[str, str], Run]) -> list[str]:
    if not installed:
        return [name, *("not installed" for _ in CASES), "-", "-"]
    own = [runs[name, title] for title in CASES]
    errors = [_rms(run.errors) for run in own]
    seconds = np.mean([second for run in own for second in run.seconds])
    failed = [reason for run in own for reason in run.failed]
    return [name, *errors, f"{seconds:.2f}", f"{len(failed)}: {failed[0]}" if failed else "0"]


def _rms(errors: Sequence[float]) -> str:
    if not errors:
        return "-"
    rms = float(np.sqrt(np.mean(np.square(errors))))
    return f"{rms:.2f}" if rms < WORTHLESS_ARCSEC else "over a degree"
