"""Eight processes on one workspace for a while; `python -m tests.faults.crowding` does the same for five minutes."""

from pathlib import Path

import duckdb
import pytest

from tests.faults.crowding.crowding import crowded
from tests.faults.crowding.reader import Reader


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_crowd_on_one_workspace_loses_nothing_and_meets_no_error(tmp_path: Path) -> None:
    told = crowded(tmp_path / "crowd", seconds=40.0, seed=8, epochs=1, points=40_000)
    assert told["findings"] == []
    assert {"run", "verify", "status", "alarms", "readings", "pages", "watch: taken"} <= told["calls"].keys()


def catalog_of(path: Path, epochs: dict[str, str], slices: int = 2) -> None:
    """Make a catalog with the columns that the reader looks at; each epoch of a run."""
    path.unlink(missing_ok=True)
    with duckdb.connect(str(path)) as connection:
        connection.execute("CREATE TABLE epochs (structure TEXT, epoch TEXT, run TEXT, n_stations INT)")
        for table in ("schemes", "slices", "tilt"):
            more = {"schemes": ", n_slices INT, state TEXT", "slices": ", slice_index INT", "tilt": ""}[table]
            connection.execute(
                f"CREATE TABLE {table} (structure TEXT, epoch TEXT, scheme TEXT, method TEXT{more})"
            )
        connection.execute("CREATE TABLE stations (structure TEXT, epoch TEXT, station TEXT)")
        connection.execute("CREATE TABLE coverage (structure TEXT, epoch TEXT)")
        connection.execute("CREATE TABLE runs (run TEXT, epoch TEXT, stage TEXT)")
        connection.execute("CREATE TABLE versions (epoch TEXT, version TEXT)")
        connection.execute("CREATE TABLE alarm_events (event TEXT, alarm TEXT, action TEXT)")
        for epoch, run in epochs.items():
            connection.execute("INSERT INTO epochs VALUES ('s', ?, ?, 0)", [epoch, run])
            connection.execute("INSERT INTO schemes VALUES ('s', ?, 'A', 'paper', 2, 'ok')", [epoch])
            connection.execute("INSERT INTO tilt VALUES ('s', ?, 'A', 'paper')", [epoch])
            for index in range(slices):
                connection.execute("INSERT INTO slices VALUES ('s', ?, 'A', 'paper', ?)", [epoch, index])


def test_the_reader_of_the_crowd_finds_nothing_wrong_with_whole_epochs_that_are_replaced(
    tmp_path: Path,
) -> None:
    reader, catalog = Reader(), tmp_path / "catalog.duckdb"
    for epochs in ({"e1": "a"}, {"e1": "b"}, {"e1": "b", "e2": "b"}):
        catalog_of(catalog, epochs)
        reader.read(catalog)
    assert (reader.readings, reader.findings) == (3, [])
    assert reader.shown == {"e1": ["a", "b"], "e2": ["b"]}


@pytest.mark.parametrize(
    ("then", "found"),
    [
        ({"e2": "b"}, "epochs gone"),
        ({"e1": "a", "e2": "b"}, "e1 goes back from b to a"),
    ],
)
def test_the_reader_of_the_crowd_finds_epochs_that_go_or_go_back(
    tmp_path: Path, then: dict[str, str], found: str
) -> None:
    reader, catalog = Reader(), tmp_path / "catalog.duckdb"
    for epochs in ({"e1": "a"}, {"e1": "b"}, then):
        catalog_of(catalog, epochs)
        reader.read(catalog)
    assert [found in line for line in reader.findings] == [True], reader.findings


def test_the_reader_of_the_crowd_finds_an_epoch_that_is_not_whole_and_a_catalog_that_cannot_be_read(
    tmp_path: Path,
) -> None:
    reader, catalog = Reader(), tmp_path / "catalog.duckdb"
    catalog_of(catalog, {"e1": "a"}, slices=1)
    reader.read(catalog)
    catalog.write_bytes(b"no catalog")
    reader.read(catalog)
    assert "slices that are not as many as their scheme says" in reader.findings[0]
    assert "Exception" in reader.findings[1] or "Error" in reader.findings[1]
