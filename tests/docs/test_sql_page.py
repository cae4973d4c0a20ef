"""Every block of docs/sql.md runs as it stands on a workspace, and finds something where it says so."""

import re
import subprocess
import sys
from pathlib import Path

import duckdb
import pytest

from tests.docs.sql_workspace import sql_workspace
from tests.flows.campaigns import run, small_campaign

PAGE = Path(__file__).resolve().parents[2] / "docs" / "sql.md"
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
QUERIES = [text for kind, text in BLOCKS if kind == "sql"]
PROGRAMS = [text for kind, text in BLOCKS if kind == "python"]
MAY_BE_EMPTY = "-- may be empty"


def title(text: str) -> str:
    """First words of a block, for the names of tests."""
    return " ".join(text.replace(MAY_BE_EMPTY, "").split())[:50]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which ``tiltwatch-data`` lies; tests here only read it."""
    place: Path = tmp_path_factory.mktemp("sql")
    sql_workspace(place)
    return place


def answered(folder: Path, query: str, monkeypatch: pytest.MonkeyPatch) -> list[tuple[object, ...]]:
    # what Grafana puts in the place of its macro
    plain = re.sub(r"\$__timeFilter\((\w+)\)", r"\1 BETWEEN '2000-01-01' AND '2100-01-01'", query)
    monkeypatch.chdir(folder)
    with duckdb.connect("tiltwatch-data/catalog.duckdb", read_only=True) as catalog:
        return list(catalog.sql(plain).fetchall())


def test_the_page_has_queries_and_programs() -> None:
    assert len(QUERIES) >= 20
    assert len(PROGRAMS) >= 5


@pytest.mark.parametrize("query", QUERIES, ids=title)
def test_each_query_finds_rows(folder: Path, query: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert answered(folder, query, monkeypatch) or MAY_BE_EMPTY in query


@pytest.mark.parametrize("program", PROGRAMS, ids=title)
def test_each_program_runs_and_prints(folder: Path, program: str) -> None:
    if "polars" in program:
        pytest.importorskip("polars", reason="polars is large, and only this page speaks of it")
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False, timeout=120
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.strip()


def test_the_newest_state_names_every_structure_with_its_primary_axis(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = answered(folder, next(query for query in QUERIES if "primary_axis" in query), monkeypatch)
    assert [(row[0], row[1]) for row in rows] == [("chimney-01", "e2"), ("tower-02", "e2")]
    assert all(row[5] is not None for row in rows)


@pytest.mark.slow
def test_each_query_finds_rows_in_a_workspace_that_was_run(
    tmp_path: Path, prefect_api: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert prefect_api
    file = small_campaign(tmp_path / "campaign", epochs=2)
    run(file, tmp_path / "tiltwatch-data")
    empty = [
        title(query)
        for query in QUERIES
        if not answered(tmp_path, query, monkeypatch) and MAY_BE_EMPTY not in query
    ]
    assert empty == []
