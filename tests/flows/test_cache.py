"""What is computed again, and what is not: the cache table of the main job, on a small simulated campaign."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from storage.artifacts import ArtifactRef, artifact_path
from storage.workspace import Workspace
from tests.flows.campaigns import computed_stages, replace_text, rows, run, small_campaign, stage_rows

ROOT = Path(__file__).resolve().parents[2]
EPOCH = "2025-01"

pytestmark = pytest.mark.usefixtures("prefect_api")


@pytest.fixture(scope="module")
def processed(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> Path:
    """A campaign with an own scheme G, and its workspace after one run."""
    folder = tmp_path_factory.mktemp("campaign")
    campaign = small_campaign(folder)
    with campaign.open("a", encoding="utf-8") as file:
        file.write("\n[schemes.G]\ninterval_m = 2.5\n")
    first = run(campaign, folder / "ws")
    assert first.cached == 0
    assert computed_stages(first) >= {
        "ingest ST01",
        "registration",
        "preprocessing",
        "coverage",
        "slicing G/robust",
        "evaluation",
    }
    return folder


@pytest.fixture
def copied(processed: Path, tmp_path: Path) -> Path:
    """A copy of campaign and workspace at another place, which must not matter."""
    shutil.copytree(processed, tmp_path / "campaign")
    return tmp_path / "campaign"


def artifact_of(folder: Path, stage: str, name: str) -> Path:
    workspace = Workspace(folder / "ws")
    (record,) = workspace.records.glob(f"{stage}-*")
    produced = json.loads(json.loads(record.read_text())["result"])
    return artifact_path(workspace, ArtifactRef.from_json(produced["artifacts"][name]))


def flip_a_byte(path: Path, position: int) -> None:
    content = bytearray(path.read_bytes())
    content[position] ^= 0xFF
    path.write_bytes(content)


def test_a_second_run_computes_nothing_wherever_the_workspace_lies(copied: Path) -> None:
    again = run(copied / "campaign.toml", copied / "ws")
    assert computed_stages(again) == set()
    assert again.computed == 0
    assert again.cached > 20
    assert {row.state for row in stage_rows(again)} == {"cached"}


def test_another_interval_of_one_scheme_recomputes_that_scheme_only(copied: Path) -> None:
    replace_text(copied / "campaign.toml", "interval_m = 2.5", "interval_m = 2.0")
    again = run(copied / "campaign.toml", copied / "ws")
    assert computed_stages(again) == {
        "slicing G/paper",
        "slicing G/robust",
        "axis G/paper",
        "axis G/robust",
        "evaluation",
    }


def test_a_changed_comment_in_the_campaign_file_recomputes_nothing(copied: Path) -> None:
    with (copied / "campaign.toml").open("a", encoding="utf-8") as file:
        file.write("\n# looked at by the surveyor\n")
    assert run(copied / "campaign.toml", copied / "ws").computed == 0


def test_another_limit_recomputes_the_evaluation_only(copied: Path) -> None:
    replace_text(
        copied / "campaign.toml",
        'table = "gb50078-concrete-quoted"',
        "verticality_m = [[90.0, 0.5], [110.0, 0.6]]",
    )
    assert computed_stages(run(copied / "campaign.toml", copied / "ws")) == {"evaluation"}


def test_one_changed_byte_of_one_scan_recomputes_what_depends_on_it(copied: Path) -> None:
    scan = copied / EPOCH / "ST02.laz"
    # the system identifier of the header: other bytes, the same points
    flip_a_byte(scan, 30)
    computed = computed_stages(run(copied / "campaign.toml", copied / "ws"))
    assert "ingest ST02" in computed
    assert "ingest ST01" not in computed
    # its points are the same, so nothing that rests on them is computed again
    assert "registration" not in computed


def test_other_points_of_one_scan_recompute_all_that_rests_on_them(copied: Path) -> None:
    shutil.copy(copied / EPOCH / "ST03.laz", copied / "spare.laz")
    shutil.copy(copied / EPOCH / "ST01.laz", copied / EPOCH / "ST03.laz")
    shutil.copy(copied / "spare.laz", copied / EPOCH / "ST01.laz")
    computed = computed_stages(run(copied / "campaign.toml", copied / "ws"))
    # both scans are known by their bytes, but as other stations
    assert computed >= {"registration", "preprocessing", "slicing A/paper", "axis A/robust", "evaluation"}
    assert not {stage for stage in computed if stage.startswith("ingest")}


@pytest.mark.parametrize(
    ("stage", "name"),
    [
        ("preprocessing", "points"),
        ("registration", "registration"),
        ("coverage", "coverage"),
        ("evaluation", "tilt"),
    ],
)
def test_a_flipped_byte_in_a_stored_artifact_recomputes_that_artifact_only(
    copied: Path, stage: str, name: str
) -> None:
    artifact = artifact_of(copied, stage, name)
    before = artifact.read_bytes()
    flip_a_byte(artifact, len(before) // 2)
    assert computed_stages(run(copied / "campaign.toml", copied / "ws")) == {stage}
    assert artifact.read_bytes() == before


def test_a_lost_artifact_and_a_torn_record_are_made_anew(copied: Path) -> None:
    artifact_of(copied, "preprocessing", "model").unlink()
    (record,) = (copied / "ws" / "records").glob("registration-*")
    record.write_bytes(record.read_bytes()[:50])
    assert computed_stages(run(copied / "campaign.toml", copied / "ws")) == {"registration", "preprocessing"}


def test_results_after_healing_are_the_same(copied: Path) -> None:
    before = rows(copied / "ws", "tilt", EPOCH)
    shutil.rmtree(copied / "ws" / "records")
    again = run(copied / "campaign.toml", copied / "ws")
    assert again.cached == 0
    assert rows(copied / "ws", "tilt", EPOCH) == before


RUN_ELSEWHERE = """
import sys
from pathlib import Path
from flows.run_campaign import RunRequest, run_campaign
outcome = run_campaign(RunRequest(Path(sys.argv[1]), Path(sys.argv[2])), lambda event: None)
print(outcome.run, outcome.computed)
"""


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    copy = tmp_path_factory.mktemp("checkout")
    for package in ("flows", "tasks", "storage"):
        shutil.copytree(ROOT / package, copy / package, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


def run_with(checkout: Path, folder: Path) -> int:
    """Stages that a run with the code of another checkout computes."""
    command = [sys.executable, "-c", RUN_ELSEWHERE, str(folder / "campaign.toml"), str(folder / "ws")]
    done = subprocess.run(command, cwd=checkout, capture_output=True, text=True, check=False, timeout=240)
    assert done.returncode == 0, done.stderr[-3000:]
    return int(done.stdout.split()[-1])


@pytest.mark.slow
def test_a_changed_helper_below_a_stage_recomputes_it_and_a_changed_comment_does_not(
    copied: Path, checkout: Path
) -> None:
    helper = checkout / "tasks" / "geometry" / "robust.py"
    replace_text(helper, "def mad_sigma(", "# a remark\ndef mad_sigma(")
    assert run_with(checkout, copied) == 0
    replace_text(helper, "TUKEY_1D: Final = 4.685", "TUKEY_1D: Final = 4.7")
    assert run_with(checkout, copied) > 0
