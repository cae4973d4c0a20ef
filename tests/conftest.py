"""Settings of all tests, made before NumPy and Prefect are imported, and the server that flows share."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

# the stages run side by side; more threads below them only wait for each other on two cores
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
os.environ.setdefault("PREFECT_SERVER_ANALYTICS_ENABLED", "false")
os.environ.setdefault("DO_NOT_TRACK", "1")
# a server that a test's run starts ends with the process that started it
os.environ.setdefault("TILTWATCH_KEEP_SERVER_S", "0")

import pytest
from hypothesis import settings

from tests.prefect_server import prefect_server
from tests.s3_server import S3Endpoint, s3_server

# the same examples in every run, and none that is wrong because the machine was busy
settings.register_profile("tests", deadline=None, derandomize=True)
settings.load_profile("tests")


@pytest.fixture(scope="session")
def prefect_api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """URL of a Prefect server that lives as long as the tests; in the environment, for processes too."""
    home: Path = tmp_path_factory.mktemp("prefect")
    with prefect_server(home) as url:
        settings = {"PREFECT_API_URL": url, "PREFECT_HOME": str(home), "PREFECT_LOGGING_LEVEL": "CRITICAL"}
        before = {name: os.environ.get(name) for name in settings}
        os.environ.update(settings)
        _let_prefect_read_settings()
        yield url
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value


def _let_prefect_read_settings() -> None:
    """Prefect reads its settings when it is imported, which a test module may have done while it was collected."""
    if "prefect" in sys.modules:
        from prefect.context import refresh_global_settings_context  # noqa: PLC0415 (slow to import)

        refresh_global_settings_context()


@pytest.fixture(scope="session")
def s3_endpoint(tmp_path_factory: pytest.TempPathFactory) -> Iterator[S3Endpoint]:
    """An S3 server that lives as long as the tests."""
    with s3_server(tmp_path_factory.mktemp("s3")) as endpoint:
        yield endpoint
