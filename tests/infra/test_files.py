"""infra/prefect.yaml and the scripts of set-up, read without a server."""

import subprocess
from importlib import import_module
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
DEPLOYMENTS = yaml.safe_load((ROOT / "infra" / "prefect.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("deployment", DEPLOYMENTS["deployments"], ids=lambda found: found["name"])
def test_deployment_names_a_flow_by_module_and_parameters_that_it_has(deployment: dict) -> None:
    module, name = deployment["entrypoint"].rsplit(".", 1)
    # here and not above: Prefect reads its settings when it is imported, and other tests set them later
    flow = getattr(import_module(module), name)
    assert type(flow).__name__ == "Flow"
    assert set(deployment["parameters"]) <= set(flow.parameters.properties)
    assert set(flow.parameters.required) <= set(deployment["parameters"])


@pytest.mark.parametrize("deployment", DEPLOYMENTS["deployments"], ids=lambda found: found["name"])
def test_every_schedule_has_a_time_zone_that_exists(deployment: dict) -> None:
    assert deployment["schedules"]
    for schedule in deployment["schedules"]:
        assert ZoneInfo(schedule["timezone"]).key == schedule["timezone"]


def test_nothing_is_pulled_so_no_folder_is_written_into_the_deployment() -> None:
    assert DEPLOYMENTS["pull"] == []


def test_set_up_is_a_script_that_a_plain_shell_reads() -> None:
    read = subprocess.run(["sh", "-n", ROOT / "infra" / "install.sh"], capture_output=True, check=False)
    assert read.stderr == b""


def test_lock_holds_hashes_and_no_address() -> None:
    lines = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if "://" in line] == []
    pinned = [line for line in lines if line[:1].isalnum()]
    assert len(pinned) > 100
    assert [line for line in pinned if not line.endswith("\\")] == []
