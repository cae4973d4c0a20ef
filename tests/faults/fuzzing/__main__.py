"""``python -m tests.faults.fuzzing --cases 100000 --seed 8 --workers 2 --out FILE.json``, or ``--case N`` for one."""

import argparse
import json
import sys
import tempfile
import threading
import time
from pathlib import Path

from tests.faults.fuzzing.cases import case_of
from tests.faults.fuzzing.figures import Figures
from tests.faults.fuzzing.parent import Part, run_part
from tests.faults.fuzzing.verdict import judge


def main() -> int:
    """Run many cases, or one; 1 if there was a fault."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults.fuzzing")
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=8)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--case", type=int, help="run this one here, and keep its file")
    parser.add_argument("--keep", type=Path, help="folder for the file of --case")
    options = parser.parse_args()
    if options.case is not None:
        return _one(options.case, options.seed, options.keep or Path(tempfile.mkdtemp()))
    began = time.monotonic()
    figures = run(options.cases, options.seed, options.workers)
    content = {"seed": options.seed, "seconds": round(time.monotonic() - began, 1), **figures.as_json()}
    _say(*figures.lines())
    _say(f"{len(figures.faults)} faults in {figures.n_cases} cases, {content['seconds']} s")
    if options.out:
        options.out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return 1 if figures.faults else 0


def run(n_cases: int, run_seed: int, n_workers: int) -> Figures:
    """Run the cases from 0 on, shared out among children."""
    figures, lock, failed = Figures(), threading.Lock(), []

    def tell(answer: dict[str, object]) -> None:
        with lock:
            figures.add(answer)
            if answer.get("outcome") in {"finding", "crash", "hang"}:
                sys.stderr.write(json.dumps(answer) + "\n")
                sys.stderr.flush()

    def work(first: int) -> None:
        try:
            run_part(Part(first, n_cases, n_workers, run_seed), tell)
        except Exception as error:
            failed.append(error)

    workers = [threading.Thread(target=work, args=(first,)) for first in range(n_workers)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    if failed:
        raise failed[0]
    return figures


def _one(number: int, run_seed: int, folder: Path) -> int:
    case = case_of(number, run_seed)
    folder.mkdir(parents=True, exist_ok=True)
    _say(f"case {number} of seed {run_seed}: {case.seed.family} {case.seed.name}, {', '.join(case.deeds)}")
    _say(f"{case.request}\nfile: {folder}/case{case.seed.suffix}, {len(case.content)} bytes")
    verdict = judge(case, folder)
    _say(f"{verdict.outcome} {verdict.why}")
    return 1 if verdict.outcome == "finding" else 0


def _say(*lines: str) -> None:
    sys.stdout.writelines(f"{line}\n" for line in lines)


if __name__ == "__main__":
    raise SystemExit(main())
