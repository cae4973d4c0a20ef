"""A campaign from a generator that shares nothing with ours: truth by its own account, scored by its own script."""

import json
import subprocess
import sys

import numpy as np
import pytest

from flows.ledger import StageEvent
from flows.run_campaign import RunRequest, run_campaign
from storage.records import TiltRow
from storage.views import change_rows, tilt_rows
from storage.workspace import Workspace
from tasks.conventions import ARCSEC_RAD
from tests.shared import SHARED, needs_shared

CAMPAIGN = SHARED / "data" / "campaign"
EPOCHS = ("e1", "e2")
STRUCTURE = "chimney-sim"
BEST = [("A", "robust"), ("S", "surface")]

pytestmark = [needs_shared, pytest.mark.usefixtures("prefect_api")]


def ignore(_event: StageEvent) -> None:
    """Listen to no stage."""


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> Workspace:
    folder = tmp_path_factory.mktemp("foreign")
    outcome = run_campaign(RunRequest(CAMPAIGN / "campaign.toml", folder / "ws"), ignore)
    assert [epoch.state for epoch in outcome.epochs] == ["ok", "ok"]
    return Workspace(outcome.workspace)


def row_of(workspace: Workspace, epoch: str, scheme: str, method: str) -> TiltRow:
    (row,) = (r for r in tilt_rows(workspace, STRUCTURE, epoch) if (r.scheme, r.method) == (scheme, method))
    return row


def truth_of(epoch: str) -> np.ndarray:
    return np.array(json.loads((CAMPAIGN / epoch / "truth.json").read_text())["lean_fit"])


@pytest.mark.parametrize("epoch", EPOCHS)
@pytest.mark.parametrize(("scheme", "method"), [*((scheme, "robust") for scheme in "ABCD"), ("S", "surface")])
def test_lean_reaches_the_floor_that_the_levels_leave(
    workspace: Workspace, epoch: str, scheme: str, method: str
) -> None:
    row = row_of(workspace, epoch, scheme, method)
    error = np.hypot(*(np.array([row.lean_east, row.lean_north]) - truth_of(epoch))) / ARCSEC_RAD
    # true poses leave 0.8" and 2.2": what the level errors of 2.9" on eight stations do to the truth itself
    assert error < 3.0


def chi2_of(row: TiltRow) -> float:
    difference = np.array([row.lean_east, row.lean_north]) - truth_of(row.epoch)
    covariance = np.array([[row.lean_cov_ee, row.lean_cov_en], [row.lean_cov_en, row.lean_cov_nn]], float)
    return float(difference @ np.linalg.solve(covariance, difference))


@pytest.mark.parametrize("epoch", EPOCHS)
def test_truth_lies_in_the_stated_region(workspace: Workspace, epoch: str) -> None:
    assert chi2_of(row_of(workspace, epoch, "A", "robust")) < 5.991


@pytest.mark.parametrize(("scheme", "method"), BEST)
def test_truth_of_both_epochs_lies_in_the_stated_region(
    workspace: Workspace, scheme: str, method: str
) -> None:
    # of e2 alone the levels leave 2.2", which is 2.1 of the sigmas that they are stated with; 95 % of 4 degrees of freedom
    assert sum(chi2_of(row_of(workspace, epoch, scheme, method)) for epoch in EPOCHS) < 9.488


@pytest.mark.parametrize(("scheme", "method"), BEST)
def test_the_movement_of_16_arc_seconds_is_found_and_significant(
    workspace: Workspace, scheme: str, method: str
) -> None:
    (change,) = (r for r in change_rows(workspace, STRUCTURE) if (r.scheme, r.method) == (scheme, method))
    wanted = truth_of("e2") - truth_of("e1")
    found = np.array([change.d_lean_east, change.d_lean_north], float)
    assert np.hypot(*(found - wanted)) / ARCSEC_RAD < 4.0
    assert change.significant


@pytest.mark.parametrize(
    "command",
    [["score_against_truth.py", *(str(CAMPAIGN / epoch) for epoch in EPOCHS)], ["check_workspace.py"]],
    ids=["score", "contract"],
)
def test_scripts_of_others_read_the_workspace(workspace: Workspace, command: list[str]) -> None:
    script, *arguments = command
    call = [sys.executable, str(SHARED / "tools" / script), str(workspace.root), *arguments]
    done = subprocess.run(call, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stdout
    assert "A robust" in done.stdout or "contract kept" in done.stdout
