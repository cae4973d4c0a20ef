"""infra/systemd and infra/compose.yaml: read, and held against what there is; nothing of them is started here."""

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from flows.application import COMMANDS, application

ROOT = Path(__file__).resolve().parents[2]
UNITS = sorted((ROOT / "infra" / "systemd").iterdir())
SERVICES = [unit for unit in UNITS if unit.suffix == ".service"]
PROGRAMS = "/opt/tiltwatch/.venv/bin/"
COMPOSE = yaml.safe_load((ROOT / "infra" / "compose.yaml").read_text(encoding="utf-8"))
OURS = sorted(set(COMPOSE["services"]) - {"postgres"})


def section(unit: Path, name: str) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    here = ""
    for line in unit.read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            here = line.strip("[]")
        elif here == name and "=" in line and not line.startswith("#"):
            key, value = line.split("=", 1)
            found.setdefault(key, []).append(value)
    return found


def assert_tiltwatch_understands(words: list[str]) -> None:
    assert words[0] in COMMANDS
    application(words[0]).parse_args(words, exit_on_error=False, print_error=False)


@pytest.mark.parametrize("unit", SERVICES, ids=lambda unit: unit.name)
def test_every_program_of_a_unit_is_installed_and_understands_its_words(unit: Path) -> None:
    service = section(unit, "Service")
    for line in [*service["ExecStart"], *service.get("ExecStartPre", [])]:
        program, *words = shlex.split(line.lstrip("-").replace("%i", "chimney-01"))
        assert program.startswith(PROGRAMS)
        assert (Path(sys.executable).parent / program.removeprefix(PROGRAMS)).exists()
        if program.endswith("/tiltwatch"):
            assert_tiltwatch_understands(words)


@pytest.mark.parametrize("unit", SERVICES, ids=lambda unit: unit.name)
def test_a_service_is_not_root_may_write_nothing_but_its_own_and_holds_no_secret(unit: Path) -> None:
    service = section(unit, "Service")
    assert service["User"] == ["tiltwatch"]
    assert (service["ProtectSystem"], service["NoNewPrivileges"]) == (["strict"], ["yes"])
    assert service["EnvironmentFile"][0].startswith("/etc/tiltwatch/")
    assert not re.search(r"(?i)(auth_string|password)", " ".join(service["Environment"]))


def test_the_timer_is_hourly_and_has_a_service_of_its_name() -> None:
    (timer,) = [unit for unit in UNITS if unit.suffix == ".timer"]
    assert section(timer, "Timer")["OnCalendar"] == ["hourly"]
    assert timer.with_suffix(".service") in SERVICES


def test_systemd_finds_nothing_wrong_with_the_units(tmp_path: Path) -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("no systemd-analyze here (Debian: apt-get install systemd)")
    # systemd takes a space for the end of a path
    here = f"{Path(sys.executable).parent}/".replace(" ", "\\x20")
    places = []
    for unit in UNITS:
        places.append(tmp_path / unit.name.replace("@", "@chimney-01"))
        text = unit.read_text(encoding="utf-8").replace(PROGRAMS, here)
        places[-1].write_text(text, encoding="utf-8")
    told = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", "--recursive-errors=no", *map(str, places)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (told.returncode, told.stderr) == (0, "")


@pytest.mark.parametrize("name", OURS)
def test_a_container_of_ours_is_made_of_the_containerfile_and_understands_its_words(name: str) -> None:
    service = COMPOSE["services"][name]
    place = (ROOT / "infra" / service["build"]["context"]).resolve()
    assert (place / service["build"]["dockerfile"]).is_file()
    program = service.get("entrypoint", ["tiltwatch"])[0]
    if program == "tiltwatch" and "command" in service:
        assert_tiltwatch_understands(service["command"])
    elif program == "sh":
        for words in re.findall(r"tiltwatch ([^;]+);", service["command"][0]):
            assert_tiltwatch_understands(shlex.split(words))
    else:
        assert program in {"prefect", "tiltwatch"}


def test_what_containers_wait_for_is_healthy_only_when_asked_and_secrets_come_from_outside() -> None:
    for service in COMPOSE["services"].values():
        for waited_for in service.get("depends_on", {}):
            assert "healthcheck" in COMPOSE["services"][waited_for]
    text = (ROOT / "infra" / "compose.yaml").read_text(encoding="utf-8")
    example = (ROOT / "infra" / "compose.env.example").read_text(encoding="utf-8")
    named = set(re.findall(r"(?<!\$)\$\{(\w+)", text))
    assert named == set(re.findall(r"^(\w+)=", example, flags=re.MULTILINE))
    assert not re.search(r"^(POSTGRES_PASSWORD|TILTWATCH_SECRET)=.", example, flags=re.MULTILINE)


def test_nothing_of_compose_is_reached_from_outside_this_machine() -> None:
    ports = [port for service in COMPOSE["services"].values() for port in service.get("ports", [])]
    assert ports
    assert all(port.startswith("127.0.0.1:") for port in ports)


def test_server_of_units_and_of_compose_keeps_its_leases_over_a_kill() -> None:
    name = "PREFECT_SERVER_CONCURRENCY_LEASE_STORAGE"
    module = "prefect.server.concurrency.lease_storage.filesystem"
    assert COMPOSE["services"]["server"]["environment"][name] == module
    (unit,) = [unit for unit in SERVICES if "server" in unit.name]
    assert f"{name}={module}" in section(unit, "Service")["Environment"]
