"""A workflow server that answers no longer in the middle of a run: said as what it is, and the next run goes on."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import httpx
import psutil
import pytest

from flows.server_check import ServerLostError, loss_told
from flows.workflow_server import read_record
from tests.faults.full_site import command
from tests.faults.sites import Site
from tests.flows.calls import ROOT
from tests.flows.campaigns import small_campaign

IMPATIENT = {"PREFECT_API_REQUEST_TIMEOUT": "3", "PREFECT_CLIENT_MAX_RETRIES": "1"}
"""Instead of a minute, six times over."""


def test_a_server_that_answers_no_longer_is_no_fault_of_the_program() -> None:
    with (
        pytest.raises(
            ServerLostError, match=r"answers no longer \(ReadTimeout: too late\).* run again"
        ) as told,
        loss_told(),
    ):
        raise httpx.ReadTimeout("too late")
    assert told.value.exit_code == 3
    with pytest.raises(ZeroDivisionError), loss_told():
        raise ZeroDivisionError


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows stops no process")
def test_a_server_stopped_in_the_middle_of_a_run_is_told_and_the_next_run_has_another(tmp_path: Path) -> None:
    small_campaign(tmp_path, epochs=1, stations=3)
    site = Site(tmp_path)
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("PREFECT_")}
    run = subprocess.Popen(
        [sys.executable, "-m", "flows.cli", "-v", "run", site.file, "--workspace", site.workspace],
        cwd=ROOT,
        env={**inherited, **IMPATIENT, "PYTHONPATH": str(ROOT), "TILTWATCH_KEEP_SERVER_S": "0"},
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )
    assert run.stderr is not None
    limit = threading.Timer(300, run.kill)
    limit.start()
    server, told = None, ""
    try:
        for line in run.stderr:
            told += line
            if server is None and " ingest " in line:
                (home,) = (site.workspace / "prefect").glob("*/server.json")
                record = read_record(home.parent)
                assert record is not None
                server = psutil.Process(record.pid)
                server.send_signal(signal.SIGSTOP)
        assert run.wait() == 3, told
        assert "error: the workflow server answers no longer" in told
        again = command(site, "run")
        assert again.code == 0, again.err
    finally:
        limit.cancel()
        run.kill()
        run.communicate()
        if server is not None:
            server.kill()
