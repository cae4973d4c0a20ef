"""A watch of a prefix on a real S3 server."""

import json
from pathlib import Path
from uuid import uuid4

import pytest
from pyarrow import fs

from storage.s3_inbox import s3_files
from tasks.settings.intake import read_intakes
from tests.flows.calls import call
from tests.flows.watched_sites import Site
from tests.s3_server import S3Endpoint


def upload(site: Site, bucket: str, *names: str) -> None:
    for name in names:
        with s3_files().open_output_stream(f"{bucket}/silo/{name}") as out:
            out.write((site.inbox / name).read_bytes())


def objects(bucket: str) -> list[str]:
    infos = s3_files().get_file_info(fs.FileSelector(bucket, recursive=True))
    return sorted(info.path.removeprefix(f"{bucket}/") for info in infos if info.type == fs.FileType.File)


def test_stations_on_s3_are_taken_in_when_their_sidecar_is_there(
    s3_endpoint: S3Endpoint,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for name, value in s3_endpoint.environment.items():
        monkeypatch.setenv(name, value)
    bucket = f"watch-{uuid4().hex[:12]}"
    s3_endpoint.make_bucket(bucket)
    site = Site(tmp_path)
    site.send("ST01")
    words = ("watch", site.file, "--inbox", f"s3://{bucket}/silo", "--once", "--json", "--interval-s", "0.1")

    def events(*more: str) -> list[str]:
        called = call(capsys, *words, *more)
        assert called.code == 0, called
        return [json.loads(line)["event"] for line in called.out.splitlines()]

    upload(site, bucket, "ST01.csv")
    assert events() == ["started", "waiting", "stopped"]
    upload(site, bucket, "ST01.toml")
    assert events() == ["started", "taken", "preview", "stopped"]
    assert objects(bucket) == ["silo/ST01.csv", "silo/ST01.toml"]
    assert events() == ["started", "stopped"], "what was fetched is remembered"
    site.send("ST02", 90.0)
    upload(site, bucket, "ST02.csv", "ST02.toml")
    assert events("--move") == ["started", "taken", "preview", "stopped"]
    assert objects(bucket) == [
        "silo/ST01.csv", "silo/ST01.toml", "silo/taken/ST02.csv", "silo/taken/ST02.toml",
    ]  # fmt: skip
    (intake,) = read_intakes(site.folder / "tiltwatch-data", "silo")
    assert intake.arrived == ("ST01", "ST02")


def test_a_store_that_does_not_answer_is_told_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, value in {
        "AWS_ENDPOINT_URL": "http://127.0.0.1:9",
        "AWS_ACCESS_KEY_ID": "x",
        "AWS_SECRET_ACCESS_KEY": "x",
        "AWS_MAX_ATTEMPTS": "1",
    }.items():
        monkeypatch.setenv(name, value)
    called = call(capsys, "watch", Site(tmp_path).file, "--inbox", "s3://bucket", "--once", "--json")
    told = [json.loads(line) for line in called.out.splitlines()]
    assert [event["event"] for event in told] == ["started", "error", "stopped"]
    assert called.code == 3
    assert "check AWS_ENDPOINT_URL" in told[1]["reason"]
