"""Stages as tasks of Prefect: cached under their keys, submitted from the flow of an epoch, sent to workers by name."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from prefect import Task
from prefect.cache_policies import CachePolicy
from prefect.context import TagsContext, TaskRunContext
from prefect.futures import PrefectFuture

from flows.dask_cluster import told_of_cluster
from flows.stage_records import PLAIN_JSON
from storage.errors import InputError
from storage.places import workspace_at
from tasks.caching import Stage, set_aside_if_damaged, stage_key
from tasks.produced import Produced, produced_from_json


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


class StageTask(Task[..., Any]):
    """A cached task; to a worker it is sent by its name, and the worker runs the code that it has itself."""

    def __reduce__(self) -> tuple[Callable[[str, str, bool], "StageTask"], tuple[str, str, bool]]:
        """Name the module and the variable that hold its stage.

        Sent by value, its code would be a new function with every call, whose version must be found anew.
        """
        return task_named, (self.fn.__module__, self.fn.__qualname__, bool(self.refresh_cache))


@lru_cache(maxsize=256)
def task_named(module: str, name: str, anew: bool) -> StageTask:
    """Make the task of a stage that is known by the module and the variable that hold it."""
    return task_of(getattr(importlib.import_module(module), name), anew=anew)


@lru_cache(maxsize=256)
def task_of(stage: Stage, *, anew: bool = False) -> StageTask:
    """Make the task of a stage; with ``anew`` it is computed whatever is stored, and its record replaced."""
    return StageTask(
        stage.fn,
        name=stage.name,
        cache_policy=StageKey(stage=stage.name),
        persist_result=True,
        result_serializer=PLAIN_JSON,
        cache_result_in_memory=False,
        refresh_cache=True if anew else None,
    )


@dataclass(frozen=True, slots=True)
class _Submitted:
    """A stage that was submitted to the runner of a flow."""

    stage: str
    future: PrefectFuture[Any]

    def result(self) -> Produced:
        """Wait for it; where a cluster lost it, that is said."""
        try:
            return produced_from_json(self.future.result())
        except InputError:
            raise
        except Exception as fault:
            told = told_of_cluster(self.stage, fault)
            if told is fault:
                raise
            raise told from fault

    def was_cached(self) -> bool:
        """Whether it was on record."""
        return bool(self.future.state.name == "Cached")


@dataclass(frozen=True, slots=True)
class FlowStages:
    """Gives stages to the runner of the flow that is under way, which computes what is not on record."""

    def ask(self, stage: Stage, label: str, inputs: dict[str, Any], _key: str, *, anew: bool) -> _Submitted:
        """Ask for a stage; it runs beside others."""
        # for a stage that inherits the tags of its run the server is asked for a slot for every tag, before it begins
        with TagsContext(current_tags=set()):
            return _Submitted(label, task_of(stage, anew=anew).submit(**inputs))
