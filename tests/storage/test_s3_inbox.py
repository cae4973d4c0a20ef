"""A prefix on a real S3 server as an inbox."""

from collections.abc import Iterator
from pathlib import Path
from uuid import uuid4

import pytest
from pyarrow import fs

from storage.errors import StorageError, UsageError
from storage.inbox import look_into
from storage.s3_inbox import S3Inbox, S3Place, parse_s3_url, s3_files
from tests.s3_server import S3Endpoint


@pytest.fixture
def bucket(s3_endpoint: S3Endpoint, monkeypatch: pytest.MonkeyPatch) -> str:
    """A new bucket; the environment leads to its server."""
    for name, value in s3_endpoint.environment.items():
        monkeypatch.setenv(name, value)
    name = f"inbox-{uuid4().hex[:12]}"
    s3_endpoint.make_bucket(name)
    return name


def put(path: str, content: bytes) -> None:
    with s3_files().open_output_stream(path) as out:
        out.write(content)


def objects(bucket: str) -> set[str]:
    infos = s3_files().get_file_info(fs.FileSelector(bucket, recursive=True))
    return {info.path.removeprefix(f"{bucket}/") for info in infos if info.type == fs.FileType.File}


def names(folder: Path) -> Iterator[str]:
    return (file.name for file in look_into(folder) if not file.path.name.startswith("."))


def test_objects_are_fetched_once_and_left_in_place(bucket: str, tmp_path: Path) -> None:
    content = bytes(range(256)) * 40_000
    put(f"{bucket}/site/2026-03/ST01.laz", content)
    put(f"{bucket}/elsewhere/ST09.laz", b"x")
    inbox = S3Inbox(S3Place(bucket, "site"), tmp_path, s3_files())
    assert inbox.fetch().names == ("2026-03/ST01.laz",)
    assert (tmp_path / "2026-03" / "ST01.laz").read_bytes() == content
    (tmp_path / "2026-03" / "ST01.laz").unlink()  # taken in
    again = S3Inbox(S3Place(bucket, "site"), tmp_path, s3_files())
    assert again.fetch().names == ()
    put(f"{bucket}/site/2026-03/ST01.toml", b"late")
    assert again.fetch().names == ("2026-03/ST01.toml",)
    assert list(names(tmp_path)) == ["2026-03/ST01.toml"]
    assert "site/2026-03/ST01.laz" in objects(bucket)


def test_an_object_that_was_replaced_is_fetched_again(bucket: str, tmp_path: Path) -> None:
    inbox = S3Inbox(S3Place(bucket, ""), tmp_path, s3_files())
    put(f"{bucket}/ST01.toml", b"wrong")
    inbox.fetch()
    put(f"{bucket}/ST01.toml", b"right now")
    assert inbox.fetch().names == ("ST01.toml",)
    assert (tmp_path / "ST01.toml").read_bytes() == b"right now"


def test_an_object_that_was_taken_in_can_be_moved_aside(bucket: str, tmp_path: Path) -> None:
    put(f"{bucket}/site/ST01.laz", b"points")
    inbox = S3Inbox(S3Place(bucket, "site"), tmp_path, s3_files())
    inbox.fetch()
    inbox.set_aside("ST01.laz")
    assert objects(bucket) == {"site/taken/ST01.laz"}
    assert inbox.fetch().names == ()


@pytest.mark.parametrize("name", ["..\\evil.laz", "C:evil.laz", "a|b.laz"])
def test_an_object_whose_name_leads_elsewhere_stays_where_it_is(tmp_path: Path, name: str) -> None:
    """A folder stands for the store here: it takes any name."""
    store, folder = tmp_path / "bucket" / "site", tmp_path / "inbox"
    store.mkdir(parents=True)
    for one in (name, "ST01.laz"):
        (store / one).write_bytes(b"points")
    fetched = S3Inbox(S3Place(str(store.parent), "site"), folder, fs.LocalFileSystem()).fetch()
    assert fetched.names == ("ST01.laz",)
    assert "cannot be the name of a file here" in fetched.faults[0]
    assert list(names(folder)) == ["ST01.laz"]


def test_an_empty_prefix_is_an_empty_inbox_and_no_bucket_is_a_mistake(bucket: str, tmp_path: Path) -> None:
    assert S3Inbox(S3Place(bucket, "nothing/here"), tmp_path, s3_files()).fetch().names == ()
    with pytest.raises(StorageError, match="no bucket 'absent-bucket'"):
        S3Inbox(S3Place("absent-bucket", ""), tmp_path, s3_files()).fetch()


def test_a_wrong_secret_is_said_with_what_to_check(
    bucket: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "wrong")
    with pytest.raises(StorageError, match="check AWS_ENDPOINT_URL, AWS_ACCESS_KEY_ID"):
        S3Inbox(S3Place(bucket, ""), tmp_path, s3_files()).fetch()


@pytest.mark.parametrize(
    ("url", "place"), [("s3://b", S3Place("b", "")), ("s3://b/a/c/", S3Place("b", "a/c"))]
)
def test_urls_are_taken_apart(url: str, place: S3Place) -> None:
    assert parse_s3_url(url) == place


def test_a_url_without_a_bucket_is_refused() -> None:
    with pytest.raises(UsageError, match="needed s3://BUCKET/PREFIX"):
        parse_s3_url("s3:///prefix")
