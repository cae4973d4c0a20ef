"""A campaign on a real Dask cluster: the same results as here, whatever happens to a worker."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from flows.dask_cluster import ClusterError, told_of_cluster
from flows.ledger import StageEvent
from flows.outcome import RunOutcome
from flows.run_campaign import RunRequest, run_campaign
from flows.worker_check import judge_workers, version_of_stages
from storage.errors import InputError, StorageError, UsageError
from storage.folder_store import FolderStore
from storage.parquet import read_rows
from storage.places import store_at
from storage.records import EpochRow
from storage.tables import EPOCH_TABLES, table_path
from storage.workspace import Workspace
from tests.dask_cluster import DaskCluster, dask_cluster
from tests.flows.campaigns import STRUCTURE, ignore, rows, small_campaign, stage_rows
from tests.s3_server import S3Endpoint
from tests.storage.s3_places import new_place

EPOCHS = ("2025-01", "2025-04")
FIRST = EPOCHS[:1]
SCHEME = ("B",)

pytestmark = pytest.mark.usefixtures("prefect_api")


@pytest.fixture(scope="module")
def cluster(
    tmp_path_factory: pytest.TempPathFactory, s3_endpoint: S3Endpoint, prefect_api: str
) -> Iterator[DaskCluster]:
    """Two workers that know the S3 server and have a cache of their own."""
    folder = tmp_path_factory.mktemp("cluster")
    environment = {**s3_endpoint.environment, "TILTWATCH_CACHE": str(folder / "cache")}
    with dask_cluster(folder, 2, environment) as running:
        yield running


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_campaign(tmp_path_factory.mktemp("campaign"), epochs=2, points=20_000)


@pytest.fixture(autouse=True)
def this_machine(s3_endpoint: S3Endpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {**s3_endpoint.environment, "TILTWATCH_CACHE": str(tmp_path / "cache")}.items():
        monkeypatch.setenv(name, value)


def on(simulated: Path, name: str, *execution: str) -> Path:
    """The campaign with a table [execution], beside its scans."""
    path = simulated.with_name(f"{name}.toml")
    path.write_text("\n".join([simulated.read_text(), "[execution]", *execution, ""]))
    return path


def on_cluster(simulated: Path, cluster: DaskCluster, name: str, *more: str) -> Path:
    return on(simulated, name, 'engine = "dask"', f'address = "{cluster.address}"', *more)


def run(
    campaign: Path,
    workspace: Path,
    schemes: tuple[str, ...] = (),
    epochs: tuple[str, ...] = EPOCHS,
    listener: Callable[[StageEvent], None] = ignore,
) -> RunOutcome:
    outcome = run_campaign(RunRequest(campaign, workspace, epochs, schemes), listener)
    assert [(epoch.epoch, epoch.state, epoch.fault) for epoch in outcome.epochs] == [
        (name, "ok", None) for name in epochs
    ], outcome
    return outcome


def assert_same_tables(one: Path, other: Path, epochs: tuple[str, ...] = EPOCHS) -> None:
    """Bit for bit, but for the name of the run and the digest of the campaign file."""
    for epoch in epochs:
        paths = [
            [table_path(Workspace(ws), table, STRUCTURE, epoch) for ws in (one, other)]
            for table in EPOCH_TABLES
        ]
        for mine, theirs in paths:
            if mine.parent.parent.name == "epochs":
                first, second = (
                    [replace(row, run="", campaign_digest="") for row in read_rows(path, "epochs", EpochRow)]
                    for path in (mine, theirs)
                )
                assert first == second
            else:
                assert mine.read_bytes() == theirs.read_bytes(), f"{mine} differs"


def test_workers_give_the_same_rows_as_this_process_by_a_store_on_s3(
    simulated: Path, cluster: DaskCluster, s3_endpoint: S3Endpoint, tmp_path: Path
) -> None:
    place = new_place(s3_endpoint)
    campaign = on_cluster(simulated, cluster, "s3", f'store = "{place}"')
    first = run(campaign, tmp_path / "there", SCHEME, FIRST)
    assert first.cached == 0
    assert list((tmp_path / "there" / "artifacts").iterdir()) == [], "everything is in the store"
    assert list((tmp_path / "there" / "records").iterdir()) == []
    assert len(list(store_at(place).names("records"))) == first.computed

    here = run(simulated, tmp_path / "here", SCHEME, FIRST)
    assert here.computed == first.computed
    assert_same_tables(tmp_path / "there", tmp_path / "here", FIRST)
    assert set(FolderStore(tmp_path / "here").names("artifacts")) - {"artifacts/verified.txt"} <= set(
        store_at(place).names("artifacts")
    )

    again = run(campaign, tmp_path / "elsewhere", SCHEME, FIRST)
    assert (again.computed, again.cached) == (0, first.computed), "another publisher finds all in the store"
    assert_same_tables(tmp_path / "elsewhere", tmp_path / "here", FIRST)


@pytest.mark.slow
def test_every_scheme_on_workers_with_a_shared_folder_gives_the_same_rows(
    simulated: Path, cluster: DaskCluster, tmp_path: Path
) -> None:
    there = run(on_cluster(simulated, cluster, "folder"), tmp_path / "there")
    here = run(simulated, tmp_path / "here")
    assert_same_tables(tmp_path / "there", tmp_path / "here")
    names = {row.cache_key for row in stage_rows(there)}
    assert names == {row.cache_key for row in stage_rows(here)}


@pytest.mark.slow
def test_a_store_on_s3_serves_threads_of_this_process_too(
    simulated: Path, s3_endpoint: S3Endpoint, tmp_path: Path
) -> None:
    campaign = on(simulated, "local-s3", f'store = "{new_place(s3_endpoint)}"')
    run(campaign, tmp_path / "there", SCHEME)
    run(simulated, tmp_path / "here", SCHEME)
    assert_same_tables(tmp_path / "there", tmp_path / "here")


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_only_its_task(
    simulated: Path, cluster: DaskCluster, tmp_path: Path
) -> None:
    killed: list[str] = []
    processes = cluster.worker_processes()

    def kill_whoever_registers() -> None:
        deadline = time.monotonic() + 60.0
        while not killed and time.monotonic() < deadline:
            for address, calls in cluster.busy_workers().items():
                if any(call.startswith("registration") for call in calls):
                    os.kill(processes[address], signal.SIGKILL)
                    killed.append(address)
                    return

    killer = threading.Thread(target=kill_whoever_registers)

    def listen(event: StageEvent) -> None:
        if event.stage == "registration" and event.state == "started" and not killer.ident:
            killer.start()

    outcome = run(on_cluster(simulated, cluster, "killed"), tmp_path / "there", SCHEME, listener=listen)
    killer.join()
    assert killed, "no worker was caught at a registration"
    done = [(row.epoch, row.stage) for row in stage_rows(outcome)]
    assert len(done) == len(set(done)), "nothing is doubled"
    assert {row.outcome for row in stage_rows(outcome)} <= {"ok", "refused"}
    run(simulated, tmp_path / "here", SCHEME)
    assert_same_tables(tmp_path / "there", tmp_path / "here")
    assert rows(tmp_path / "there", "tilt", EPOCHS[0])


@pytest.mark.slow
def test_a_store_that_a_worker_cannot_use_stops_the_run_before_any_stage(
    simulated: Path,
    cluster: DaskCluster,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    s3_endpoint: S3Endpoint,
) -> None:
    folder = tmp_path / "cluster"
    with (
        dask_cluster(folder, 1, {**s3_endpoint.environment, "AWS_SECRET_ACCESS_KEY": "wrong"}) as other,
        pytest.raises(InputError, match=r"worker tcp://.*AWS_SECRET_ACCESS_KEY"),
    ):
        run_campaign(
            RunRequest(
                on_cluster(simulated, other, "keys", f'store = "{new_place(s3_endpoint)}"'), tmp_path / "ws"
            ),
            ignore,
        )


def test_a_scheduler_that_does_not_answer_is_told(
    simulated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flows.dask_cluster.CONNECT_S", 1.0)
    campaign = on(simulated, "nobody", 'engine = "dask"', 'address = "tcp://127.0.0.1:1"')
    with pytest.raises(
        InputError, match=r"no Dask scheduler answers at tcp://127.0.0.1:1 .*`dask scheduler`"
    ):
        run_campaign(RunRequest(campaign, tmp_path / "ws"), ignore)


def test_a_store_that_does_not_answer_stops_the_run_before_any_stage(
    simulated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:1")
    with pytest.raises(StorageError, match="cannot use s3://bucket/x"):
        run_campaign(RunRequest(on(simulated, "away", 'store = "s3://bucket/x"'), tmp_path / "ws"), ignore)


def test_without_the_extra_it_is_named(
    simulated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "prefect_dask", None)
    campaign = on(simulated, "no-extra", 'engine = "dask"', 'address = "tcp://127.0.0.1:1"')
    with pytest.raises(UsageError, match='needs the extra "dask" of tiltwatch: install prefect-dask'):
        run_campaign(RunRequest(campaign, tmp_path / "ws"), ignore)


def test_workers_with_other_code_or_without_what_they_need_are_refused_by_name() -> None:
    here = version_of_stages()
    judge_workers({"tcp://a:1": (here, ())})
    found = {
        "tcp://a:1": (here, ()),
        "tcp://b:2": ("0" * 64, ()),
        "tcp://c:3": ModuleNotFoundError("No module named 'flows'"),
        "tcp://d:4": (here, ("does not see /data/campaign.toml",)),
    }
    with pytest.raises(InputError) as refused:
        judge_workers(found)
    told = str(refused.value).splitlines()
    assert [line.split()[1].rstrip(":") for line in told] == ["tcp://b:2", "tcp://c:3", "tcp://d:4"]
    assert "install the same tiltwatch" in told[0]
    assert "cannot run tiltwatch (ModuleNotFoundError: No module named 'flows')" in told[1]


def test_a_stage_that_every_worker_died_of_tells_of_memory_and_may_be_tried_again() -> None:
    from distributed.scheduler import KilledWorker  # noqa: PLC0415 (slow to import)

    told = told_of_cluster("registration", KilledWorker("registration-1", None, 3))
    assert isinstance(told, ClusterError)
    assert "registration: every worker that took it died" in str(told)
    other = ValueError("x")
    assert told_of_cluster("registration", other) is other
