"""The server on PostgreSQL with a secret; worker, server and database killed in the middle of a campaign."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from storage.parquet import read_rows
from storage.records import TABLES, StageRunRow
from storage.tables import EPOCH_TABLES, files_of
from storage.workspace import Workspace
from tests.infra.production import ENDED, Production, asked_stages, ledger, production, wait_until
from tests.infra.services import SECRET, status_of

SCHEDULE = '\n[schedule]\ncron = "30 6 1 * *"\ntimezone = "Europe/Berlin"\nretries = 5\nretry_delay_s = 5.0\n'
WHEN = "2025-01 registration"
"""Asked for in the middle of the first epoch: what was computed before it must not be computed again."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Production]:
    with production(tmp_path_factory.mktemp("production"), epochs=2) as found:
        with found.campaign.open("a") as file:
            file.write(SCHEDULE)
        yield found


@pytest.mark.slow
def test_server_on_postgresql_lets_nobody_in_without_the_secret(site: Production) -> None:
    version = f"{site.api}/admin/version"
    assert [status_of(version, secret) for secret in (None, "admin:wrong", SECRET)] == [401, 401, 200]
    told = site.call("deploy", site.campaign, secret=None)
    assert told.code == 2
    assert "wants a secret: set PREFECT_API_AUTH_STRING" in told.err


@pytest.mark.slow
def test_a_campaign_is_deployed_to_it_with_its_schedule(site: Production) -> None:
    site.deploy(site.folder / "first")
    deployment = site.deployment()
    assert deployment["parameters"] == {
        "campaign_file": str(site.campaign),
        "workspace": str(site.folder / "first"),
    }
    (schedule,) = deployment["schedules"]
    assert (schedule["schedule"]["cron"], schedule["schedule"]["timezone"]) == ("30 6 1 * *", "Europe/Berlin")


@pytest.fixture(scope="module")
def undisturbed(site: Production) -> Path:
    """The workspace of a run that nothing happened to."""
    workspace = site.folder / "undisturbed"
    site.deploy(workspace)
    site.worker.start()
    site.begin(schemes=["A"])
    finish(site, workspace)
    return workspace


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("victim", ["worker", "worker and its runs", "server", "database"])
def test_after_a_kill_in_the_middle_the_campaign_ends_with_the_same_rows(
    site: Production, undisturbed: Path, victim: str
) -> None:
    workspace = site.folder / victim.replace(" ", "-")
    site.deploy(workspace)
    site.begin(schemes=["A"])
    wait_until(f"{WHEN} is under way", lambda: WHEN in asked_stages(workspace))
    service = {"server": site.server, "database": site.database}.get(victim, site.worker)
    service.kill(with_children=victim == "worker and its runs")
    service.start()
    finish(site, workspace)
    found, expected = rows_of(workspace), rows_of(undisturbed)
    assert [table for table in expected if found[table] != expected[table]] == []
    assert set(site.states_of(workspace).values()) <= ENDED
    assert_nothing_was_computed_twice(ledger(workspace), ledger(undisturbed))
    told = site.call("verify", site.campaign, "--workspace", workspace)
    assert told.code == 0, told.err


def assert_nothing_was_computed_twice(rows: list[StageRunRow], undisturbed: list[StageRunRow]) -> None:
    computed = Counter(
        (row.epoch, row.stage) for row in rows if (row.state, row.outcome) == ("computed", "ok")
    )
    assert set(computed.values()) == {1}
    # a stage that was finished at the moment of the kill is in the cache, and in the ledger as cut short
    cut = {(row.epoch, row.stage) for row in rows if row.outcome == "failed"}
    assert {(row.epoch, row.stage) for row in undisturbed} <= computed.keys() | cut


def finish(site: Production, workspace: Path) -> None:
    """What the hourly timer does, until a run of the deployment has ended well and no other is under way."""

    def done() -> bool:
        told = site.call("recover", site.campaign, "--again", "--workspace", workspace)
        assert told.code == 0, told.err
        states = [run["state_type"] for run in site.runs_of(workspace) if run["deployment_id"]]
        return "COMPLETED" in states and set(states) <= {*ENDED}

    try:
        wait_until("a run of the campaign has ended well", done, limit_s=400.0)
    except AssertionError as fault:
        raise AssertionError(f"{fault}; {site.states_of(workspace)}\n{site.worker.messages()}") from fault


def rows_of(workspace: Path) -> dict[str, list[object]]:
    """All published rows of all epochs; which run published it does not count."""
    place = Workspace(workspace)
    found: dict[str, list[object]] = {
        table: [row for path in files_of(place, table) for row in read_rows(path, table, TABLES[table])]
        for table in EPOCH_TABLES
    }
    found["epochs"] = [replace(row, run="") for row in found["epochs"]]  # type: ignore[type-var]
    return found
