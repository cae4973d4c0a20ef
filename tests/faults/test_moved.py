"""A campaign is archived and restored on another path: the same answers, and nothing or everything is computed again."""

import tarfile
from pathlib import Path

import pytest

from storage.backup.answers import answers_of
from storage.verify import verify_workspace_deeply
from storage.workspace import Workspace
from tests.faults.sites import EPOCHS, Site
from tests.flows.calls import Called, call

NOT_OF_THE_RUN = {"epochs", "runs", "latest", "alarms"}
"""Views that name the run, or the moment of it."""


def archived(capsys: pytest.CaptureFixture[str], site: Site, *words: str) -> tuple[Path, Called]:
    out = site.folder.parent / "record.tar"
    told = call(
        capsys, "export", site.file, "archive", "--workspace", site.workspace, "--out", out, "--json", *words
    )
    assert told.code == 0, told.err
    return out, told


def restored(capsys: pytest.CaptureFixture[str], archive: Path, folder: Path, digest: str) -> Site:
    told = call(capsys, "restore", archive, "--to", folder, "--digest", digest, "--json")
    assert told.code == 0, told.err
    (folder / "tiltwatch-data").rename(folder / "ws")
    return Site(folder)


def test_with_scans_and_cache_nothing_is_computed_again(
    capsys: pytest.CaptureFixture[str], published: Site, tmp_path: Path
) -> None:
    archive, told = archived(capsys, published, "--scans", "--cache")
    assert told.answer["epochs"] == len(EPOCHS)
    assert told.answer["left_out"] == []
    there = restored(capsys, archive, tmp_path / "new place", told.answer["digest"])
    assert answers_of(Workspace(there.workspace)) == answers_of(Workspace(published.workspace))
    again = there.run("--json")
    assert again.code == 0, again.err
    assert again.answer["stages"]["computed"] == 0
    assert again.answer["stages"]["cached"] > 0
    assert verify_workspace_deeply(Workspace(there.workspace)).faults == ()


@pytest.mark.slow
def test_with_scans_alone_everything_is_computed_to_the_same_answers(
    capsys: pytest.CaptureFixture[str], published: Site, tmp_path: Path
) -> None:
    archive, told = archived(capsys, published, "--scans")
    there = restored(capsys, archive, tmp_path / "new place", told.answer["digest"])
    before = answers_of(Workspace(published.workspace)).views
    again = there.run("--json")
    assert again.code == 0, again.err
    assert again.answer["stages"]["computed"] > 0
    after = answers_of(Workspace(there.workspace)).views
    assert {view for view in before if before[view] != after[view]} <= NOT_OF_THE_RUN


def test_without_scans_the_record_is_read_and_stands_whatever_a_run_finds(
    capsys: pytest.CaptureFixture[str], published: Site, tmp_path: Path
) -> None:
    archive, told = archived(capsys, published)
    assert told.answer["left_out"] == ["the 10 scans are not in the archive; --scans adds them"]
    there = restored(capsys, archive, tmp_path / "new place", told.answer["digest"])
    status = call(capsys, "status", there.file, "--workspace", there.workspace, "--json")
    assert status.answer["epoch"] == EPOCHS[-1]
    again = there.run("--json")
    assert again.code == 3
    assert "stays published" in again.err
    assert there.states() == published.states()


def test_a_campaign_that_lies_within_its_workspace_is_not_taken_for_the_record(
    capsys: pytest.CaptureFixture[str], published: Site, tmp_path: Path
) -> None:
    """`tiltwatch demo` makes it so."""
    inside = published.workspace / "campaign"
    published.workspace.rename(tmp_path / "ws")
    published.folder.rename(tmp_path / "ws" / "campaign")
    (tmp_path / "campaign").mkdir()
    (tmp_path / "ws").rename(published.workspace)
    out = tmp_path / "record.tar"
    words = ("archive", "--workspace", published.workspace, "--out", out, "--json")
    told = call(capsys, "export", inside / "campaign.toml", *words)
    assert told.code == 0, told.err
    with tarfile.open(out) as tar:
        assert [name for name in tar.getnames() if name.endswith((".laz", "campaign.toml"))] == [
            "campaign/campaign.toml"
        ]
    told = call(capsys, "export", inside / "campaign.toml", *words, "--scans")
    there = restored(capsys, out, tmp_path / "new place", told.answer["digest"])
    assert there.scan("ST02").is_file()


def test_what_lies_outside_the_folder_is_named(
    capsys: pytest.CaptureFixture[str], published: Site, tmp_path: Path
) -> None:
    outside = tmp_path / "drive"
    outside.mkdir()
    scan = published.scan("ST02")
    scan.rename(outside / scan.name)
    text = published.text().replace('"2025-04/ST02.laz"', f'"{outside / scan.name}"')
    published.file.write_text(f'{text}\n[files]\nroots = ["{outside}"]\n', encoding="utf-8")
    published.scan("ST03").unlink()
    _, told = archived(capsys, published, "--scans")
    assert sorted(told.answer["left_out"]) == sorted(
        [
            f"{published.scan('ST03')} is not there and not in the archive",
            f"{outside / scan.name} lies outside the campaign's folder and is not in the archive; save it beside and "
            "name its new place in [files] roots",
        ]
    )
    assert f"warning: {outside / scan.name} lies outside" in told.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("archive", "--format", "csv"), "an archive is a tar"),
        (("archive", "--epoch", "2025-01"), "holds the whole record"),
        (("tilt", "--format", "csv", "--scans"), "--scans and --cache are for an archive"),
        (("tilt",), "tilt needs a --format"),
    ],
)
def test_words_that_make_no_sense_are_refused(
    capsys: pytest.CaptureFixture[str], published: Site, words: tuple[str, ...], told: str
) -> None:
    called = call(capsys, "export", published.file, *words, "--workspace", published.workspace)
    assert (called.code, told in called.err) == (2, True)


def test_no_archive_is_told(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    called = call(capsys, "restore", tmp_path / "none.tar")
    assert called.code == 3
    assert "name the archive that `tiltwatch export FILE archive` wrote" in called.err
