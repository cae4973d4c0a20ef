"""Join a Dask cluster: reach its scheduler, see that its workers fit, and give its stages to it.

Prefect's own runner would open a connection for every epoch; here a run has one, so that closing it ends every
epoch that waits for a stage.
"""
# ruff: noqa: PLC0415 (prefect-dask is an extra: it is imported when a campaign asks for it)

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

from prefect.task_runners import TaskRunner

from flows.worker_check import Needed, examine_worker, judge_workers
from storage.errors import InputError, TiltwatchError, UsageError

CONNECT_S: Final = 8.0
"""So long the scheduler is tried to be reached."""

WORKERS_S: Final = 30.0
"""So long the first worker is waited for: a cluster may have been started just now."""

EXAMINE_S: Final = 120.0
"""So long the workers may take to import and look: the first import takes seconds, more on a loaded machine."""


class ClusterError(TiltwatchError):
    """The cluster lost a stage; nothing is wrong with the input, and the next run goes on where this one stopped."""


@dataclass(frozen=True, slots=True)
class Cluster:
    """A cluster that was joined: how many stages it runs at once, and what gives them to it."""

    threads: int
    runner: TaskRunner[Any]


@contextmanager
def joined_cluster(address: str, needed: Needed) -> Iterator[Cluster]:
    """Join the cluster of a scheduler as long as the block lasts.

    Raises
    ------
    UsageError
        If prefect-dask is not installed.
    InputError
        If the scheduler does not answer, has no workers, or a worker does not fit.
    """
    _require_extra()
    from flows.dask_runner import client_of, runner_of

    client = client_of(address, CONNECT_S)
    try:
        threads = _threads(address, client)
        judge_workers(_examined(client, needed))
        yield Cluster(threads, runner_of(address))
    finally:
        client.close(timeout=CONNECT_S)


def told_of_cluster(stage: str, fault: Exception) -> Exception:
    """Say what a fault of the cluster means for a stage; any other fault is given back as it is."""
    kinds = {kind.__name__ for kind in type(fault).__mro__ if kind.__module__.startswith("distributed")}
    if "KilledWorker" in kinds:
        return ClusterError(
            f"{stage}: every worker that took it died, most often for want of memory; give the workers more "
            "(--memory-limit, docs/scale.md), and run again"
        )
    if kinds:
        return ClusterError(f"{stage}: the cluster was lost ({fault}); start it and run again")
    return fault


def _require_extra() -> None:
    try:
        import distributed  # noqa: F401
        import prefect_dask  # noqa: F401
    except ImportError as fault:
        raise UsageError(
            'engine = "dask" needs the extra "dask" of tiltwatch: install prefect-dask>=0.3.7 here and on every worker'
        ) from fault


def _threads(address: str, client: Any) -> int:
    deadline = time.monotonic() + WORKERS_S
    while not (threads := client.nthreads()):
        if time.monotonic() > deadline:
            raise InputError(
                f"[execution] address: the scheduler {address} has no workers; start some with `dask worker {address} "
                "--nthreads 1` in the same environment"
            )
        time.sleep(0.5)
    return sum(threads.values())


def _examined(client: Any, needed: Needed) -> dict[str, Any]:
    """What every worker says of itself, or the exception where it cannot."""
    try:
        found: dict[str, Any] = client.run(examine_worker, needed, on_error="return")
    except Exception as fault:
        return {"(any)": fault}
    return found
