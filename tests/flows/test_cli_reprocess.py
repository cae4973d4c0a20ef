"""All epochs again in one command: what the change reaches is computed, the old results stay, the difference is told."""

import shutil
from pathlib import Path

import pytest

from flows.run_campaign import RunRequest, run_campaign
from storage.records import TiltRow
from storage.versions import archived_epochs
from storage.views import tilt_rows, version_rows, version_tilt_rows
from storage.workspace import Workspace
from tests.flows.calls import Called, call
from tests.flows.campaigns import STRUCTURE, computed_stages, ignore, replace_text, run, small_campaign

EPOCH = "2025-01"
OWN_SCHEME = "\n[schemes.G]\ninterval_m = 2.5\n"

pytestmark = pytest.mark.usefixtures("prefect_api")


@pytest.fixture(scope="module")
def processed(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> Path:
    """A campaign whose own scheme counts, and its workspace after one run."""
    folder = tmp_path_factory.mktemp("campaign")
    campaign = small_campaign(folder, points=15_000)
    replace_text(campaign, 'primary = ["S", "surface"]', 'primary = ["G", "robust"]')
    campaign.write_text(campaign.read_text(encoding="utf-8") + OWN_SCHEME, encoding="utf-8")
    run(campaign, folder / "ws")
    return folder


@pytest.fixture
def copied(processed: Path, tmp_path: Path) -> Path:
    shutil.copytree(processed, tmp_path / "campaign")
    return tmp_path / "campaign"


def reprocess(capsys: pytest.CaptureFixture[str], folder: Path, *words: object) -> Called:
    return call(capsys, "reprocess", folder / "campaign.toml", "--workspace", folder / "ws", *words)


def place(folder: Path) -> Workspace:
    return Workspace(folder / "ws")


def published(folder: Path) -> list[TiltRow]:
    return tilt_rows(place(folder), STRUCTURE)


def bare(rows: list[TiltRow]) -> list[tuple[object, ...]]:
    """Rows without the name of a version."""
    return [tuple(getattr(row, name) for name in TiltRow.__slots__) for row in rows]


def test_another_method_keeps_the_old_results_and_tells_the_difference(
    capsys: pytest.CaptureFixture[str], copied: Path
) -> None:
    before = published(copied)
    replace_text(copied / "campaign.toml", "interval_m = 2.5", "interval_m = 2.0")
    called = reprocess(capsys, copied, "--label", "every-2.5-m")
    assert called.code == 0, called.err
    assert "G/robust now against version every-2.5-m" in called.out
    assert "1 of 1 epochs kept as version every-2.5-m" in called.err
    # G/paper changed with it; what was not touched is the same to the last bit
    assert f"other schemes and methods: 1 changed, {len(before) - 2} unchanged, 0 gone, 0 new" in called.out
    kept = version_tilt_rows(place(copied), STRUCTURE, "every-2.5-m")
    assert bare(list(kept)) == bare(before)
    now = {(row.scheme, row.method): row.n_slices for row in published(copied)}
    assert now["G", "robust"] > {(row.scheme, row.method): row.n_slices for row in kept}["G", "robust"]


def test_the_answer_for_programs_has_every_change(capsys: pytest.CaptureFixture[str], copied: Path) -> None:
    replace_text(copied / "campaign.toml", "interval_m = 2.5", "interval_m = 2.0")
    answer = reprocess(capsys, copied, "--json").answer
    assert answer["ok"]
    assert answer["version"].startswith("before-")
    changed = {(row["scheme"], row["method"]) for row in answer["changes"] if row["outcome"] == "changed"}
    assert changed == {("G", "paper"), ("G", "robust")}
    assert all(row["d_top_m"] > 0.0 for row in answer["changes"] if row["outcome"] == "changed")


@pytest.mark.slow
def test_the_same_name_goes_on_after_an_interruption(
    capsys: pytest.CaptureFixture[str], copied: Path
) -> None:
    """The first call is one that was killed after the epoch was published; the second must not keep the new as old."""
    before = published(copied)
    replace_text(copied / "campaign.toml", "interval_m = 2.5", "interval_m = 2.0")
    reprocess(capsys, copied, "--label", "old")
    again = reprocess(capsys, copied, "--label", "old", "--json").answer
    assert again["stages"]["computed"] == 0
    assert bare(list(version_tilt_rows(place(copied), STRUCTURE, "old"))) == bare(before)
    assert len(list(archived_epochs(place(copied)))) == 1
    assert {row["outcome"] for row in again["changes"]} == {"changed", "unchanged"}


def test_a_run_with_other_settings_keeps_what_it_replaces(copied: Path) -> None:
    before = published(copied)
    replace_text(copied / "campaign.toml", "interval_m = 2.5", "interval_m = 2.0")
    outcome = run(copied / "campaign.toml", copied / "ws")
    (row,) = version_rows(place(copied), STRUCTURE)
    assert row.version == f"before-{outcome.run}"
    assert bare(list(version_tilt_rows(place(copied), STRUCTURE, row.version))) == bare(before)


def test_forced_everything_is_computed_once_and_gives_the_same(copied: Path) -> None:
    before = published(copied)
    request = RunRequest(copied / "campaign.toml", copied / "ws", anew=True)
    outcome = run_campaign(request, ignore)
    assert outcome.cached == 0
    assert {"ingest ST01", "registration", "axis G/robust"} <= computed_stages(outcome)
    assert published(copied) == before
    assert version_rows(place(copied), STRUCTURE) == []


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--label", "a/b"], "'a/b' of a version (--label) cannot be a file name"),
        (["--epoch", "2031-01"], "unknown epoch '2031-01'; known: 2025-01"),
    ],
)
def test_wrong_words_are_wrong_usage_and_nothing_is_done(
    capsys: pytest.CaptureFixture[str], copied: Path, words: list[str], message: str
) -> None:
    called = reprocess(capsys, copied, *words)
    assert called.code == 2
    assert message in called.err
    assert list(archived_epochs(place(copied))) == []


def test_without_a_workspace_it_says_what_to_do(capsys: pytest.CaptureFixture[str], copied: Path) -> None:
    called = call(capsys, "reprocess", copied / "campaign.toml", "--workspace", copied / "none")
    assert called.code in (1, 3)
    assert "process the campaign first" in called.err
