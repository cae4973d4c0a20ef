"""What makes a pure function a cached stage: the key, the record, the cost, the refusal of bad input.

The key of a stage is its name, the code it reaches and its inputs by digest.

Prefect calls a task cached when a result record lies under the task's key. Its own policies either
forget the task (INPUTS alone collides between tasks), forget the code below the task (TASK_SOURCE), or
trust a record whose artifacts are damaged. This key does none of it (docs/decisions/0003).
"""

import hashlib
import json
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import wraps
from typing import Any, Final

from storage.artifacts import is_whole
from storage.errors import InputError
from storage.places import store_of
from storage.workspace import Workspace
from tasks.code_version import code_version
from tasks.geometry.failure import FitFailure
from tasks.geometry.side_by_side import one_blas_thread
from tasks.produced import Cost, Json, Outcome, Produced, record_result

WHERE: Final = ("workspace", "path")
"""Arguments that say where things lie, not what they are: they do not count in a key."""


def stage_key(stage: str, function: Callable[..., object], inputs: Mapping[str, Any]) -> str:
    """Key under which the outcome of ``function`` on ``inputs`` is kept.

    Raises
    ------
    TypeError
        If an input is not plain JSON: an array or an object has no stable text.
    """
    what = {name: value for name, value in inputs.items() if name not in WHERE}
    content = {"stage": stage, "code": code_version(function), "inputs": what}
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return f"{stage}-{hashlib.sha256(canonical.encode()).hexdigest()}"


def on_record(workspace: Workspace, key: str) -> Produced | None:
    """What was produced under a key; None where there is no record, or it or one of its artifacts is not whole."""
    record = store_of(workspace).get(record_name(key))
    return None if record is None else _sound(workspace, key, record)


def set_aside_if_damaged(workspace: Workspace, key: str) -> None:
    """Rename the record under ``key`` to .bad if it is torn, or if one of its artifacts is not whole."""
    store = store_of(workspace)
    record = store.get(record_name(key))
    if record is not None and _sound(workspace, key, record) is None:
        store.put(f"{record_name(key)}.bad", record)
        store.remove(record_name(key))


def record_name(key: str) -> str:
    """What the store calls the record under a key."""
    return f"records/{key}"


def _sound(workspace: Workspace, key: str, record: bytes) -> Produced | None:
    try:
        produced = record_result(record, key)
    except ValueError:
        return None
    return produced if all(is_whole(workspace, ref) for ref in produced.artifacts.values()) else None


StageBody = Callable[..., Outcome | FitFailure]


@dataclass(frozen=True, slots=True)
class Stage:
    """A cached stage: its name, and what carries it out on plain JSON arguments and gives plain JSON.

    Whether and where that is done is for flows; Prefect's task of a stage is made there.
    """

    name: str
    fn: Callable[..., dict[str, Json]]


def stage(name: str) -> Callable[[StageBody], Stage]:
    """Make a cached stage of a function on plain JSON arguments.

    Bad input and data that cannot be fitted become a refusal in the record: they are results, and are
    cached as such. Anything else that is raised is a fault and fails the stage; so does a refusal behind which
    the system is, because it is not to be cached.
    """

    def decorate(body: StageBody) -> Stage:
        @wraps(body)
        def run(*args: Any, **kwargs: Any) -> dict[str, Json]:
            return _carry_out(body, *args, **kwargs).to_json()

        return Stage(name, run)

    return decorate


def _carry_out(body: StageBody, *args: Any, **kwargs: Any) -> Produced:
    one_blas_thread()
    started = time.perf_counter()
    try:
        outcome = body(*args, **kwargs)
    except InputError as fault:
        outcome = FitFailure(str(lasting(fault)))
    seconds = time.perf_counter() - started
    if isinstance(outcome, FitFailure):
        return Produced(Cost(seconds, None, peak_rss_mb()), refusal=outcome.reason)
    cost = Cost(seconds, outcome.points, peak_rss_mb())
    return Produced(cost, outcome.artifacts, outcome.facts)


def lasting(fault: InputError) -> InputError:
    """Give back a refusal that lies in the input itself and may be cached.

    Raises
    ------
    InputError
        The refusal itself where the system is behind it (no memory, a drive that was away): next time it may be gone.
    """
    if isinstance(fault.__cause__, OSError | MemoryError):
        raise fault
    return fault


def peak_rss_mb() -> float | None:
    """Largest memory of this process so far, MB; None on systems that do not count it (Windows)."""
    try:
        import resource  # noqa: PLC0415 - not there on Windows
    except ImportError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # kilobytes on Linux, bytes on macOS
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6


@dataclass(frozen=True, slots=True)
class Identity:
    """What a call of a stage is known by: its cache key and the version of its code."""

    cache_key: str
    code_version: str


def identity_of(called: Stage, inputs: Mapping[str, Any]) -> Identity:
    """Tell the key and the code version of a stage for these inputs, without running it."""
    return Identity(stage_key(called.name, called.fn, inputs), code_version(called.fn))
