"""Prefect's Dask runner for many small stages: one connection a run, and little to send and set up for each.

``prefect-dask`` sends the settings and the flow with every task, and a worker makes two clients of the server for each:
0.2 s of processor time, more than most stages take. Here they are made once a flow, and kept by the worker.
Imported only where the extra is installed.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, ClassVar, Final
from uuid import UUID, uuid4

from distributed import Client, get_worker
from distributed.protocol.pickle import dumps, loads
from prefect import Task
from prefect.client.schemas.objects import State
from prefect.context import (
    ContextModel,
    FlowRunContext,
    SettingsContext,
    SyncClientContext,
    serialize_context,
)
from prefect.events.clients import NullEventsClient
from prefect.events.worker import EventsWorker
from prefect.task_engine import run_task_sync
from prefect_dask.task_runners import DaskTaskRunner, PrefectDaskFuture

from flows.prefect_home import users_server
from storage.errors import InputError
from tasks.geometry.side_by_side import keep_to_threads


class SharedDaskTaskRunner(DaskTaskRunner):
    """Gives the stages of all epochs of a run to one client, that of its address."""

    clients: ClassVar[dict[str, Client]] = {}

    @property
    def client(self) -> Client:  # type: ignore[override]
        """The connection of this run."""
        return self.clients[str(self.address)]

    def submit(self, task: Task[..., Any], parameters: dict[str, Any], *_how: Any, **_more: Any) -> Any:
        """Give a stage to the cluster; it waits for no other, since it is asked for when its inputs are there."""
        task_run_id = uuid4()
        name = task.name.replace(" ", "_")
        future = self.client.submit(
            run_on_worker,
            task,
            parameters,
            task_run_id,
            _context_of_flow(),
            users_server() is None,
            key=f"{name}-{task_run_id.hex}",
            pure=False,
        )
        return PrefectDaskFuture(wrapped_future=future, task_run_id=task_run_id)


def client_of(address: str, timeout_s: float) -> Any:
    """Connect to a scheduler.

    Raises
    ------
    InputError
        If it does not answer.
    """
    try:
        client = Client(address, timeout=timeout_s, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as fault:
        raise InputError(
            f"[execution] address: no Dask scheduler answers at {address} ({fault}); start one with `dask scheduler`, or "
            "check host, port and firewall"
        ) from fault
    SharedDaskTaskRunner.clients[address] = client
    return client


def runner_of(address: str) -> SharedDaskTaskRunner:
    """Make the runner of an address that was connected to."""
    return SharedDaskTaskRunner(address=address)


def run_on_worker(
    task: Task[..., Any], parameters: dict[str, Any], task_run_id: UUID, context: bytes, quiet: bool
) -> State[Any]:
    """Run a stage on this worker, as a part of the flow that asked for it; gives its final state.

    With ``quiet`` the server is told no events (flows/quiet_engine).
    """
    EventsWorker.set_client_override(NullEventsClient if quiet else None)
    keep_to_threads(get_worker().state.nthreads)
    with _ready_for(context) as known:
        state: State[Any] = run_task_sync(  # type: ignore[assignment]
            task, task_run_id=task_run_id, parameters=parameters, return_type="state", context=known
        )
    return state


_KEPT: Final = threading.local()
"""Settings and connection to the server that this thread of a worker made for a flow."""


@contextmanager
def _ready_for(context: bytes) -> Iterator[dict[str, Any]]:
    """Enter the settings of a flow and a connection to its server, both kept from stage to stage; give the rest."""
    known = dict(_unpacked(context))
    settings = known.pop("settings_context")
    if getattr(_KEPT, "made_from", None) != settings:
        _KEPT.settings, _KEPT.made_from = SettingsContext(**settings), settings
        with _KEPT.settings:
            _KEPT.connection = SyncClientContext()
            # it ends with the worker
            _KEPT.connection.client.__enter__()
    with _KEPT.settings, _entered(_KEPT.connection):
        yield known


@contextmanager
def _entered(connection: SyncClientContext) -> Iterator[None]:
    """Let Prefect find a connection here; its own way in would close it on the way out."""
    ContextModel.__enter__(connection)
    try:
        yield
    finally:
        ContextModel.__exit__(connection)


@lru_cache(maxsize=64)
def _unpacked(context: bytes) -> dict[str, Any]:
    unpacked: dict[str, Any] = loads(context)  # type: ignore[no-untyped-call]
    return unpacked


def _context_of_flow() -> bytes:
    """What a worker must know of the flow that is under way here; made once a flow."""
    flow = FlowRunContext.get()
    if flow is None or flow.flow_run is None:
        raise RuntimeError("a stage was submitted outside a flow")
    return _packed(flow.flow_run.id)


@lru_cache(maxsize=64)
def _packed(_flow_run: UUID) -> bytes:
    packed: bytes = dumps(serialize_context())  # type: ignore[no-untyped-call]
    return packed
