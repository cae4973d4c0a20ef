"""Prefect's Dask runner with one connection a run; imported only where the extra is installed."""

from typing import Any, ClassVar
from uuid import uuid4

from prefect_dask.client import PrefectDaskClient
from prefect_dask.task_runners import DaskTaskRunner

from storage.errors import InputError


class StageClient(PrefectDaskClient):
    """A connection that names a stage's call by the stage and chance, where Dask would hash all that goes with it."""

    def submit(self, func: Any, *args: Any, **kwargs: Any) -> Any:
        """Give a task to the cluster."""
        name = getattr(func, "name", "call").replace(" ", "_")
        return super().submit(func, *args, **{"key": f"{name}-{uuid4().hex}", **kwargs})  # type: ignore[no-untyped-call]


class SharedDaskTaskRunner(DaskTaskRunner):
    """Gives the stages of all epochs of a run to one client, that of its address."""

    clients: ClassVar[dict[str, StageClient]] = {}

    @property
    def client(self) -> StageClient:
        """The connection of this run."""
        return self.clients[str(self.address)]


def client_of(address: str, timeout_s: float) -> Any:
    """Connect to a scheduler.

    Raises
    ------
    InputError
        If it does not answer.
    """
    try:
        client = StageClient(address, timeout=timeout_s, set_as_default=False)  # type: ignore[no-untyped-call]
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
