"""The real command line on a campaign that has grown old."""

import json
import subprocess
import sys
import time
from collections.abc import Sequence

from tests.faults.long_life.life import Life
from tests.faults.long_life.measures import point_of
from tests.flows.calls import ROOT


def real_runs(life: Life) -> list[dict[str, object]]:
    """One run that finds one epoch more, two that find nothing new, and a look at everything."""
    told = [
        _called(life, "one epoch more", "run", "--only-new"),
        _called(life, "nothing new", "run", "--only-new"),
        _called(life, "nothing new, once more", "run", "--only-new"),
        _called(life, "status", "status"),
        _called(life, "verify --deep", "verify", "--deep"),
    ]
    for each in told:
        # what the newest state is, is not the question
        each["exit_code"] = (
            0 if each["what"] == "status" and each["exit_code"] in (4, 5, 6) else each["exit_code"]
        )
    return told


def _called(life: Life, what: str, command: str, *words: str) -> dict[str, object]:
    asked: Sequence[str] = [
        sys.executable, "-m", "flows.cli", "-q", command, str(life.campaign.folder / "campaign.toml"), *words,
        "--workspace", str(life.workspace.root), "--json",
    ]  # fmt: skip
    began = time.perf_counter()
    process = subprocess.Popen(asked, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    out, err = process.communicate()
    seconds = time.perf_counter() - began
    sizes = point_of(life.workspace, len(life.campaign.epochs), {}).bytes
    answer = json.loads(out) if out.startswith("{") else {}
    return {
        "what": what,
        "exit_code": process.returncode,
        "seconds": seconds,
        "told": err[-2000:],
        "stages": answer.get("stages"),
        "bytes": sizes,
    }
