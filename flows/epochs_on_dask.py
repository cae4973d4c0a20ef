"""The epochs of a campaign on a Dask cluster: several at once, their stages on its workers, published from here."""

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from contextvars import copy_context
from pathlib import Path
from typing import Final

from prefect.client.orchestration import get_client
from prefect.settings import PREFECT_API_URL, temporary_settings

from flows.catalog_follower import CatalogFollower
from flows.dask_cluster import Cluster, joined_cluster
from flows.epochs_loop import EpochFlow, EpochsRequest, process_epoch
from flows.ledger import RunLedger, StageEvent, current_ledger
from flows.monitor_epoch import monitor_epoch
from flows.outcome import EpochOutcome
from flows.stage_records import keep_records
from flows.worker_check import needed_of
from storage.workspace import Workspace
from tasks.settings import Campaign

MOST_EPOCHS: Final = 32
"""Unless more are asked for: each is a thread of this process."""


def process_on_dask(request: EpochsRequest, campaign: Campaign, place: Workspace) -> list[EpochOutcome]:
    """Process epochs on the cluster of the campaign; needs the ledger of a run in ``current_ledger``.

    Stages read and write the store. Tables, ledger and catalog are written by this process alone.

    Raises
    ------
    UsageError
        If prefect-dask is not installed.
    InputError
        If the scheduler does not answer, has no workers, or a worker does not fit.
    """
    address = str(campaign.execution.address)
    with get_client(sync_client=True) as client:
        api_url = str(client.api_url).rstrip("/")
    needed = needed_of(place.place, api_url, Path(request.campaign_file), campaign.execution.memory_gb)
    # a worker must not start a server of its own, as a run does that is given none
    with joined_cluster(address, needed) as cluster, temporary_settings({PREFECT_API_URL: api_url}):
        return _process_on(cluster, request, campaign, place)


def _process_on(
    cluster: Cluster, request: EpochsRequest, campaign: Campaign, place: Workspace
) -> list[EpochOutcome]:
    ledger = current_ledger.get()
    ledger.listener = _one_at_a_time(ledger.listener)
    catalog = CatalogFollower(place)
    made: EpochFlow = monitor_epoch.with_options(persist_result=False, task_runner=cluster.runner)
    epoch_flow = keep_records(made, place)
    outcomes: dict[str, EpochOutcome] = {}
    at_once = campaign.execution.epochs_at_once or min(2 * cluster.threads + 2, MOST_EPOCHS)
    for together in _groups(campaign, request.epochs):
        with _threads(at_once) as pool:
            asked = [
                pool.submit(copy_context().run, process_epoch, epoch_flow, request, epoch)
                for epoch in together
            ]
            for outcome in _as_they_end(asked, ledger):
                outcomes[outcome.epoch] = outcome
                catalog.follow()
    return [outcomes[epoch] for epoch in request.epochs]


def _groups(campaign: Campaign, epochs: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Which epochs may run together: where all need the reference epoch's stages, it or the first comes alone."""
    if not campaign.registration.stable or len(epochs) < 2:
        yield tuple(epochs)
        return
    reference = campaign.reference_epoch.id
    first = reference if reference in epochs else epochs[0]
    yield (first,)
    yield tuple(epoch for epoch in epochs if epoch != first)


@contextmanager
def _threads(at_once: int) -> Iterator[ThreadPoolExecutor]:
    """Threads for epochs; where the run is interrupted, those that have not begun never do, and nobody waits."""
    pool = ThreadPoolExecutor(at_once, thread_name_prefix="epoch")
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def _as_they_end(asked: Sequence[Future[EpochOutcome]], ledger: RunLedger) -> Iterator[EpochOutcome]:
    for future in as_completed(asked):
        outcome = future.result()
        ledger.ended(outcome)
        yield outcome


def _one_at_a_time(listener: Callable[[StageEvent], None]) -> Callable[[StageEvent], None]:
    """Let the epochs, which run in threads, tell a listener that knows nothing of threads."""
    lock = threading.Lock()

    def tell(event: StageEvent) -> None:
        with lock:
            listener(event)

    return tell
