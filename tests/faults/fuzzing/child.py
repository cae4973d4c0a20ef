"""The child that runs cases one after the other; it tells each before it begins and after it ended."""

import json
import resource
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path

from tests.faults.fuzzing.cases import WEIGHTS, Case, case_of
from tests.faults.fuzzing.seeds import seeds
from tests.faults.fuzzing.verdict import Verdict, judge

MOST_BYTES = 1 << 30
"""Above what the process has when all readers were used once."""


MEMORY = Path("/dev/shm")  # noqa: S108 - a folder of its own is made in it

MOST_CASES = 10_000
"""Of one child; then another takes over, and what the first has grown by is told."""


def main() -> None:
    """Run the cases START, START + STEP, ... below STOP of a run; arguments START STOP STEP SEED."""
    start, stop, step, run_seed = (int(text) for text in sys.argv[1:5])
    warnings.simplefilter("error")
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as name:
        folder = Path(name)
        _use_all_readers(folder)
        most = _memory("VmSize") + MOST_BYTES
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        base = _memory("VmRSS")
        _tell({"ready": base})
        for answered, number in enumerate(range(start, stop, step)):
            if answered == MOST_CASES:
                _tell({"again": number, "grown": _memory("VmRSS") - base})
                return
            _tell({"begins": number})
            _tell(_answer(number, run_seed, folder))


def _use_all_readers(folder: Path) -> None:
    for family in WEIGHTS:
        for seed in seeds()[family]:
            judge(Case(-1, seed, seed.content, case_of(0, 0).request, ()), folder)


def _answer(number: int, run_seed: int, folder: Path) -> dict[str, object]:
    case = case_of(number, run_seed)
    base = _memory("VmRSS")
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    began, used = time.perf_counter(), time.process_time()
    try:
        verdict = judge(case, folder)
    except Exception:
        verdict = Verdict("finding", traceback.format_exc(limit=-6)[-1500:])
    peak = max(0, _memory("VmHWM") - base)
    if peak > MOST_BYTES:
        verdict = Verdict("finding", f"took {peak >> 20} MiB")
    return {
        "case": number,
        "family": case.family,
        "seed": case.seed.name,
        "deeds": case.deeds,
        "outcome": verdict.outcome,
        "why": verdict.why,
        "seconds": round(time.perf_counter() - began, 4),
        "cpu": round(time.process_time() - used, 4),
        "peak": peak,
    }


def _memory(name: str) -> int:
    """A figure of this process alone, in bytes."""
    words = Path("/proc/self/status").read_text(encoding="ascii").split()
    return int(words[words.index(f"{name}:") + 1]) * 1024


def _tell(answer: dict[str, object]) -> None:
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
