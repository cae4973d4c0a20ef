"""The whole of it: a site, the crowd on it for a while, and the judgement."""

import random
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from tests.faults.crowding.crowd import Crowd, keep_doing
from tests.faults.crowding.judging import judge
from tests.faults.crowding.long_lived import reading, showing, watching
from tests.faults.crowding.members import MEMBERS
from tests.faults.crowding.site import made_site


def crowded(folder: Path, seconds: float, seed: int, epochs: int, points: int) -> dict[str, Any]:
    """Crowd a workspace; gives what was called how often, how long the longest call took, and what is wrong."""
    crowd = Crowd(made_site(folder, epochs, points, seed))
    # so that there is something to read
    crowd.call("run", crowd.site.file, "--json")
    with ExitStack() as long_lived:
        shown = long_lived.enter_context(reading(crowd))
        long_lived.enter_context(showing(crowd, seconds))
        long_lived.enter_context(watching(crowd, seconds / (2 * epochs + 1)))
        members = [
            threading.Thread(target=keep_doing, args=(crowd, member, random.Random(seed + number)))
            for number, member in enumerate(MEMBERS)
        ]
        for thread in members:
            thread.start()
        crowd.end.wait(seconds)
        crowd.end.set()
        for thread in members:
            thread.join()
    judge(crowd, shown)
    return {
        "calls": dict(sorted(crowd.calls.items())),
        "longest_call_s": {name: round(took, 1) for name, took in sorted(crowd.seconds.items())},
        "runs": len(crowd.runs),
        "deeds": len(crowd.deeds),
        "findings": crowd.findings,
    }
