"""Prefixes on the S3 server of the tests, each for one test."""

from pathlib import Path
from uuid import uuid4

import pytest

from tests.s3_server import S3Endpoint

BUCKET = "tiltwatch-tests"


def use_endpoint(endpoint: S3Endpoint, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the environment name the server, and a cache that is empty."""
    for name, value in {**endpoint.environment, "TILTWATCH_CACHE": str(cache)}.items():
        monkeypatch.setenv(name, value)


def new_place(endpoint: S3Endpoint) -> str:
    """Give a prefix that nothing lies under."""
    return f"{endpoint.make_bucket(BUCKET)}/{uuid4().hex}"
