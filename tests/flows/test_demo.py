"""The demo as its user meets it: command line, tables, found against true, a workspace that keeps the contract."""

import json
import subprocess
import sys
from pathlib import Path

import duckdb
import pytest

from tests.flows.calls import Called, call_process
from tests.shared import SHARED, needs_shared

SIZE = ("--epochs", 3, "--stations", 4, "--points", 100_000)

pytestmark = pytest.mark.usefixtures("prefect_api")


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("demo") / "ws"


@pytest.fixture(scope="module")
def told(workspace: Path, prefect_api: str) -> Called:
    return call_process("demo", "--workspace", workspace, *SIZE)


def test_demo_ends_well_and_prints_the_tables_of_the_paper(told: Called) -> None:
    assert told.code == 0, told.err
    for title in (
        "Table 1. Fit of the axis",
        "Table 2. Tilt",
        "Table 3. Against the control",
        "Slicing workload",
    ):
        assert title in told.out


def test_demo_prints_found_against_true_for_every_scheme_and_method(told: Called) -> None:
    found = told.out.partition("Lean, found against true")[2].partition("Movement of the top")[0]
    for scheme in "ABCDE":
        for method in ("paper", "robust"):
            assert f" {scheme}        {method}" in found
    assert " F        paper" in told.out
    assert " S        surface" in found


def test_known_movement_is_found_within_its_sigma(told: Called, workspace: Path) -> None:
    again = call_process("demo", "--workspace", workspace, *SIZE, "--json")
    answer = json.loads(again.out)
    assert answer["stages"]["computed"] == 0
    for axis in (("A", "robust"), ("S", "surface")):
        moved = [m for m in answer["found"]["changes"] if (m["scheme"], m["method"]) == axis]
        assert [m["epoch"] for m in moved] == ["2025-04", "2025-07"]
        for movement in moved:
            # four stations: sigma is 1.1 mm; true are 4 and 8 mm
            assert movement["error_top_m"] < 0.004


@needs_shared
def test_workspace_of_the_demo_keeps_the_contract(told: Called, workspace: Path) -> None:
    script = SHARED / "tools" / "check_workspace.py"
    done = subprocess.run(
        [sys.executable, script, workspace], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stdout
    assert "contract kept: epochs 3, stations 12" in done.stdout


def test_scheme_a_has_the_101_slices_of_the_paper(told: Called, workspace: Path) -> None:
    with duckdb.connect(str(workspace / "catalog.duckdb"), read_only=True) as catalog:
        counts = catalog.execute(
            "select scheme, any_value(n_slices) from schemes where method = 'paper' group by 1 order by 1"
        ).fetchall()
    assert counts == [("A", 101), ("B", 21), ("C", 11), ("D", 6), ("E", 2), ("F", 2)]
