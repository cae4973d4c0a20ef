"""Archives that others spoiled or made: refused, and nothing is left of them."""

import json
import tarfile
from pathlib import Path

import pytest

from storage.backup import restore_archive, write_archive
from storage.catalog import rebuild_catalog
from storage.errors import StorageError
from storage.workspace import open_workspace
from tests.storage.archives import Edit, asked, edited
from tests.storage.campaign import fill


@pytest.fixture(scope="module")
def archived(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """An archive of one epoch, for those that spoil it."""
    folder = tmp_path_factory.mktemp("archived")
    ws = open_workspace(folder / "ws")
    fill(ws, 1)
    (folder / "campaign.toml").write_text("schema_version = 1\n")
    rebuild_catalog(ws)
    write_archive(ws, asked(folder), folder / "record.tar")
    return (folder / "record.tar").read_bytes()


@pytest.fixture
def archive(archived: bytes, tmp_path: Path) -> Path:
    """A copy of it."""
    path = tmp_path / "record.tar"
    path.write_bytes(archived)
    return path


@pytest.mark.parametrize("cut", [0.0, 0.3, 0.999])
def test_an_archive_that_was_cut_short_leaves_nothing(archive: Path, tmp_path: Path, cut: float) -> None:
    content = archive.read_bytes()
    # behind the manifest a tar is filled up with zeros, which nobody misses
    end = content.rindex(b"left_out")
    archive.write_bytes(content[: int(cut * end)])
    with pytest.raises(StorageError, match=r"record\.tar.*use another copy"):
        restore_archive(archive, tmp_path / "elsewhere")
    assert [path.name for path in tmp_path.iterdir() if path.is_dir()] == []


def _lie_about(members: dict[str, bytes]) -> None:
    name = next(name for name in members if name.startswith("workspace/tables/tilt"))
    members[name] = members[next(name for name in members if name.startswith("workspace/tables/slices"))]


def _add(name: str) -> Edit:
    def edit(members: dict[str, bytes]) -> None:
        manifest = members.pop("manifest.json")
        members[name] = b"x"
        members["manifest.json"] = manifest

    return edit


def _newer(members: dict[str, bytes]) -> None:
    content = json.loads(members["manifest.json"])
    members["manifest.json"] = json.dumps({**content, "tiltwatch_archive": 2}).encode()


def _campaign_elsewhere(members: dict[str, bytes]) -> None:
    content = json.loads(members["manifest.json"])
    members["manifest.json"] = json.dumps({**content, "campaign": "/etc/hostname"}).encode()


def _without_campaign(members: dict[str, bytes]) -> None:
    content = json.loads(members["manifest.json"])
    del members["campaign/campaign.toml"], content["files"]["campaign/campaign.toml"]
    members["manifest.json"] = json.dumps(content).encode()


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (_lie_about, "holds damaged 'workspace/tables/tilt"),
        (lambda members: members.pop("workspace/workspace.json"), "lacks 'workspace/workspace.json'"),
        (_add("workspace/more"), "holds besides 'workspace/more'"),
        (_add("../outside"), "would lie elsewhere"),
        (_add("/etc/outside"), "would lie elsewhere"),
        (_add("campaign/../../outside"), "would lie elsewhere"),
        (_add("campaign\\..\\outside"), "would lie elsewhere"),
        (_add("workspace/C:outside"), "would lie elsewhere"),
        (_add("other/outside"), "would lie elsewhere"),
        (_add("workspace/nul.txt"), "would lie elsewhere"),
        (_add("workspace/outside."), "would lie elsewhere"),
        (_add("workspace/publish-journal.json"), "no part of a record"),
        (_add("workspace/catalog.duckdb"), "no part of a record"),
        (_add("workspace/prefect/profiles.toml"), "no part of a record"),
        (_add("workspace/runs/active/r1.json"), "no part of a record"),
        (_add("campaign/CAMPAIGN.toml"), "twice"),
        (lambda members: members.update({"manifest.json": b"[1]"}), "manifest.json is damaged"),
        (lambda members: members.update({"manifest.json": b"[" * 100_000}), "manifest.json is damaged"),
        (_newer, "written by a newer tiltwatch"),
        (_campaign_elsewhere, "holds no campaign file with a workspace"),
        (_without_campaign, "holds no campaign file with a workspace"),
    ],
)
def test_a_hostile_archive_is_refused_and_leaves_nothing(
    archive: Path, tmp_path: Path, edit: Edit, words: str
) -> None:
    hostile = edited(archive, edit)
    with pytest.raises(StorageError) as told:
        restore_archive(hostile, tmp_path / "elsewhere")
    assert words in str(told.value)
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_dir()) == []
    assert not (tmp_path.parent / "outside").exists()


@pytest.mark.parametrize(
    "kind", [tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.CHRTYPE, tarfile.FIFOTYPE, tarfile.DIRTYPE]
)
def test_links_devices_and_folders_are_refused(archive: Path, tmp_path: Path, kind: bytes) -> None:
    hostile = edited(archive, _add("workspace/odd"), {"workspace/odd": kind})
    with pytest.raises(StorageError, match="which is no plain file"):
        restore_archive(hostile, tmp_path / "elsewhere")
