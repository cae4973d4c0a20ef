"""What makes a pure function a cached stage: the key, the record, the cost, the refusal of bad input.

The key of a stage is its name, the code it reaches and its inputs by digest.

Prefect calls a task cached when a result record lies under the task's key. Its own policies either
forget the task (INPUTS alone collides between tasks), forget the code below the task (TASK_SOURCE), or
trust a record whose artifacts are damaged. This policy does none of it (docs/decisions/0003).
"""

import hashlib
import importlib
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, Final

from prefect import Task
from prefect.cache_policies import CachePolicy
from prefect.context import TaskRunContext
from prefect.serializers import JSONSerializer

from storage.artifacts import is_whole
from storage.errors import InputError
from storage.places import store_of, workspace_at
from storage.workspace import Workspace
from tasks.code_version import code_version
from tasks.geometry.failure import FitFailure
from tasks.produced import Cost, Json, Outcome, Produced, record_result

WHERE: Final = ("workspace", "path")
"""Arguments that say where things lie, not what they are: they do not count in a key."""


@dataclass
class StageKey(CachePolicy):
    """Key = stage, code version, inputs without places; a record with damaged artifacts is set aside."""

    stage: str = ""

    def compute_key(
        self,
        task_ctx: TaskRunContext,
        inputs: dict[str, Any],
        flow_parameters: dict[str, Any],  # noqa: ARG002 - the signature is Prefect's
        **kwargs: Any,  # noqa: ARG002
    ) -> str:
        """Compute the key and make sure that no damaged record lies under it."""
        key = stage_key(self.stage, task_ctx.task.fn, inputs)
        set_aside_if_damaged(workspace_at(inputs["workspace"]), key)
        return key


def stage_key(stage: str, function: Callable[..., object], inputs: dict[str, Any]) -> str:
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


def set_aside_if_damaged(workspace: Workspace, key: str) -> None:
    """Rename the record under ``key`` to .bad if it is torn, or if one of its artifacts is not whole."""
    store = store_of(workspace)
    record = store.get(record_name(key))
    if record is not None and not _is_sound(workspace, record):
        store.put(f"{record_name(key)}.bad", record)
        store.remove(record_name(key))


def record_name(key: str) -> str:
    """What the store calls the record under a key."""
    return f"records/{key}"


def _is_sound(workspace: Workspace, record: bytes) -> bool:
    try:
        produced = record_result(record)
    except ValueError:
        return False
    return all(is_whole(workspace, ref) for ref in produced.artifacts.values())


StageBody = Callable[..., Outcome | FitFailure]


class Stage(Task[..., Any]):
    """A cached task; to a worker it is sent by its name, and the worker runs the code that it has itself."""

    def __reduce__(self) -> tuple[Callable[[str, str, bool], "Stage"], tuple[str, str, bool]]:
        """Name the module and the variable that hold it.

        Sent by value, its code would be a new function with every call, whose version must be found anew.
        """
        return stage_named, (self.fn.__module__, self.fn.__qualname__, bool(self.refresh_cache))


def stage_named(module: str, name: str, refresh: bool) -> Stage:
    """Find a stage by the module and the variable that hold it."""
    found: Stage = getattr(importlib.import_module(module), name)
    return anew(found) if refresh else found


def anew(stage: Task[..., Any]) -> Stage:
    """Make the same stage, but computed whatever is stored; its record is replaced."""
    return _made(stage.fn, stage.name, refresh_cache=True)


def stage(name: str) -> Callable[[StageBody], Stage]:
    """Make a cached Prefect task of a function on plain JSON arguments.

    Bad input and data that cannot be fitted become a refusal in the record: they are results, and are
    cached as such. Anything else that is raised is a fault and fails the task; so does a refusal behind which
    the system is, because it is not to be cached.
    """

    def decorate(body: StageBody) -> Stage:
        @wraps(body)
        def run(*args: Any, **kwargs: Any) -> dict[str, Json]:
            return _carry_out(body, *args, **kwargs).to_json()

        return _made(run, name)

    return decorate


def _made(run: Callable[..., Any], name: str, *, refresh_cache: bool | None = None) -> Stage:
    return Stage(
        run,
        name=name,
        cache_policy=StageKey(stage=name),
        persist_result=True,
        # no object hooks: a record may hold plain JSON and nothing that is imported on reading
        result_serializer=JSONSerializer(object_encoder=None, object_decoder=None),
        cache_result_in_memory=False,
        refresh_cache=refresh_cache,
    )


def _carry_out(body: StageBody, *args: Any, **kwargs: Any) -> Produced:
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


def identity_of(called: Task[..., Any], inputs: dict[str, Any]) -> Identity:
    """Tell the key and the code version of a stage for these inputs, without running it."""
    return Identity(stage_key(called.name, called.fn, inputs), code_version(called.fn))
