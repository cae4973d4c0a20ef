"""Archives: everything comes back with the same answers, and nothing else comes in."""

import io
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from storage.backup import ArchiveRequest, CampaignFile, restore_archive, write_archive
from storage.backup.answers import answers_of
from storage.catalog import rebuild_catalog
from storage.errors import StorageError, UsageError
from storage.publish import publish_epoch
from storage.verify import verify_workspace_deeply
from storage.workspace import Workspace
from storage.writers import mark_of_this_process
from tests.storage.archives import asked, edited
from tests.storage.campaign import STRUCTURE, epoch_tables, fill
from tests.storage.stored_workspaces import LAST, unpacked


@pytest.fixture
def filled(ws: Workspace, tmp_path: Path) -> Workspace:
    """Two epochs, the second of which replaced an earlier result."""
    fill(ws, 2)
    publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1, (0.0074, -0.0051)))
    (tmp_path / "campaign.toml").write_text("schema_version = 1\n")
    (ws.root / "intake").mkdir()
    (ws.root / "intake" / "of-a-later-version.bin").write_bytes(b"\0\1")
    rebuild_catalog(ws)
    return ws


def written(ws: Workspace, tmp_path: Path, **more: object) -> tuple[Path, str]:
    out = tmp_path / "record.tar"
    return out, write_archive(ws, asked(tmp_path, **more), out).digest


def test_a_restored_archive_answers_every_view_as_before(filled: Workspace, tmp_path: Path) -> None:
    archive, digest = written(filled, tmp_path)
    restored = restore_archive(archive, tmp_path / "elsewhere", digest)
    assert restored.campaign_file.read_text() == "schema_version = 1\n"
    there = Workspace(restored.workspace)
    assert answers_of(there) == answers_of(filled)
    assert answers_of(there).views["versions"].rows == 1
    assert restored.views_compared == len(answers_of(filled).views)
    assert verify_workspace_deeply(there).faults == ()


def test_every_file_of_the_record_comes_along_byte_for_byte(filled: Workspace, tmp_path: Path) -> None:
    archive, _ = written(filled, tmp_path)
    place = restore_archive(archive, tmp_path / "elsewhere").workspace
    for folder in ("tables", "versions", "runs/settings", "intake"):
        before = {path.relative_to(filled.root): path.read_bytes() for path in _files(filled.root / folder)}
        assert before
        assert {path.relative_to(place): path.read_bytes() for path in _files(place / folder)} == before


def _files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file()]


def test_the_same_record_gives_the_same_bytes(filled: Workspace, tmp_path: Path) -> None:
    first, digest = written(filled, tmp_path)
    content = first.read_bytes()
    assert written(filled, tmp_path) == (first, digest)
    assert first.read_bytes() == content


def test_an_archive_of_a_restored_archive_is_the_same(filled: Workspace, tmp_path: Path) -> None:
    archive, digest = written(filled, tmp_path)
    restored = restore_archive(archive, tmp_path / "elsewhere")
    campaign = CampaignFile(restored.campaign_file, "campaign.toml")
    again = write_archive(Workspace(restored.workspace), ArchiveRequest(campaign), tmp_path / "again.tar")
    assert again.digest == digest
    assert (tmp_path / "again.tar").read_bytes() == archive.read_bytes()


def test_what_stages_made_comes_along_when_asked_for(filled: Workspace, tmp_path: Path) -> None:
    name = f"artifacts/ab/ab{'0' * 62}.npy"
    (filled.root / name).parent.mkdir(parents=True)
    (filled.root / name).write_bytes(b"points")
    (filled.artifacts / "verified.txt").write_text("of this machine\n")
    archive, _ = written(filled, tmp_path)
    assert not (restore_archive(archive, tmp_path / "a").workspace / name).exists()
    archive, _ = written(filled, tmp_path, cache=True)
    place = restore_archive(archive, tmp_path / "b").workspace
    assert (place / name).read_bytes() == b"points"
    assert not (place / "artifacts/verified.txt").exists()


def test_what_lies_in_a_store_elsewhere_is_not_promised(filled: Workspace, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"s3://bucket/prefix .*without --cache"):
        write_archive(
            Workspace(filled.root, "s3://bucket/prefix"), asked(tmp_path, cache=True), tmp_path / "a.tar"
        )
    assert not (tmp_path / "a.tar").exists()


def test_a_workspace_of_an_earlier_version_is_upgraded_before_and_comes_back(tmp_path: Path) -> None:
    from storage.upgrade import ready_workspace  # noqa: PLC0415

    ws = ready_workspace(unpacked(LAST, tmp_path))
    campaign = CampaignFile(ws.root / "campaign.toml", "campaign.toml")
    write_archive(ws, ArchiveRequest(campaign), tmp_path / "old.tar")
    restored = restore_archive(tmp_path / "old.tar", tmp_path / "elsewhere")
    assert answers_of(Workspace(restored.workspace)) == answers_of(ws)


@pytest.mark.slow
def test_every_flipped_bit_is_found(filled: Workspace, tmp_path: Path) -> None:
    archive, digest = written(filled, tmp_path)
    content = bytearray(archive.read_bytes())
    end = content.rindex(b"left_out")
    for at in range(37, end, end // 6):
        content[at] ^= 0x10
        archive.write_bytes(content)
        content[at] ^= 0x10
        try:
            restore_archive(archive, tmp_path / f"at-{at}", digest)
        except StorageError:
            assert not (tmp_path / f"at-{at}").exists()
        else:  # padding, or a field of a tar header that says nothing of the content
            there = Workspace(tmp_path / f"at-{at}" / "tiltwatch-data")
            assert answers_of(there) == answers_of(filled), at


def test_another_digest_is_refused(filled: Workspace, tmp_path: Path) -> None:
    archive, _ = written(filled, tmp_path)
    with pytest.raises(StorageError, match="it is another archive, or was changed"):
        restore_archive(archive, tmp_path / "elsewhere", "0" * 64)


def test_a_folder_in_use_is_left_alone_and_an_empty_one_is_taken(filled: Workspace, tmp_path: Path) -> None:
    archive, _ = written(filled, tmp_path)
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "mine").touch()
    with pytest.raises(StorageError, match="is there already"):
        restore_archive(archive, folder)
    (folder / "mine").unlink()
    assert restore_archive(archive, folder).campaign_file.is_file()


def test_answers_that_differ_are_told(filled: Workspace, tmp_path: Path) -> None:
    def lie(members: dict[str, bytes]) -> None:
        content = json.loads(members["manifest.json"])
        content["answers"]["views"]["tilt"]["sha256"] = "0" * 64
        members["manifest.json"] = json.dumps(content).encode()

    archive = edited(written(filled, tmp_path)[0], lie)
    with pytest.raises(StorageError, match="restored, view tilt gives"):
        restore_archive(archive, tmp_path / "elsewhere")


def test_a_file_that_cannot_be_read_stops_the_archive(filled: Workspace, tmp_path: Path) -> None:
    gone = CampaignFile(tmp_path / "gone.laz", "gone.laz")
    with pytest.raises(StorageError, match=r"cannot read .*gone\.laz"):
        write_archive(filled, asked(tmp_path, others=(gone,)), tmp_path / "a.tar")
    assert not (tmp_path / "a.tar").exists()


def test_folders_that_are_links_come_along(filled: Workspace, tmp_path: Path) -> None:
    for name in ("tables", "runs", "intake"):
        (filled.root / name).rename(tmp_path / f"moved-{name}")
        (filled.root / name).symlink_to(tmp_path / f"moved-{name}")
    archive, _ = written(filled, tmp_path)
    place = restore_archive(archive, tmp_path / "elsewhere").workspace
    for name in ("tables", "runs/settings", "intake"):
        there = {path.relative_to(place).as_posix() for path in _files(place / name)}
        assert there == {path.relative_to(filled.root).as_posix() for path in _files(filled.root / name)}
        assert there


@pytest.mark.parametrize(("to", "words"), [("nowhere", "leads nowhere"), ("ws", "leads in a circle")])
def test_a_link_that_cannot_be_followed_stops_the_archive(
    filled: Workspace, tmp_path: Path, to: str, words: str
) -> None:
    (filled.root / "versions" / "odd").symlink_to(tmp_path / to)
    with pytest.raises(StorageError, match=words):
        written(filled, tmp_path)
    assert not (tmp_path / "record.tar").exists()


def test_a_name_that_other_systems_take_for_another_stops_the_archive(
    filled: Workspace, tmp_path: Path
) -> None:
    (filled.root / "intake" / "aux.toml").touch()
    with pytest.raises(StorageError, match="would be another file on other systems"):
        written(filled, tmp_path)


def test_others_may_publish_while_an_archive_is_written(filled: Workspace, tmp_path: Path) -> None:
    before = answers_of(filled)

    class Slow(io.BytesIO):
        published = False

        def write(self, content: Any) -> int:
            if not self.published:
                self.published = True
                with ThreadPoolExecutor(1) as other:
                    tables = epoch_tables("e1", 1, (0.009, -0.0051))
                    other.submit(publish_epoch, filled, STRUCTURE, "e1", tables).result(timeout=60)
            return super().write(content)

    out = Slow()
    write_archive(filled, asked(tmp_path), out)
    assert out.published
    (tmp_path / "slow.tar").write_bytes(out.getvalue())
    restored = restore_archive(tmp_path / "slow.tar", tmp_path / "elsewhere")
    assert answers_of(Workspace(restored.workspace)) == before
    assert list(filled.tmp.iterdir()) == []


def test_what_a_killed_writer_or_restore_left_is_swept(filled: Workspace, tmp_path: Path) -> None:
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    mark = f"{mark_of_this_process().split('-')[0]}-{dead.pid}.{'0' * 32}.tmp"
    left = [filled.tmp / f"archive.{mark}", tmp_path / f".elsewhere.{mark}"]
    for folder in left:
        folder.mkdir(parents=True)
    archive, _ = written(filled, tmp_path)
    restore_archive(archive, tmp_path / "elsewhere")
    assert [folder for folder in left if folder.exists()] == []
