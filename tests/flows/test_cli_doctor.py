"""doctor: what a run needs of the machine."""

from pathlib import Path

import pytest

from flows import machine
from tests.flows.calls import call

EXPECTED = {
    "python",
    "prefect",
    "fastapi",
    "open3d",
    "cores",
    "memory",
    "disk",
    "write test",
    "bytecode",
    "time zones",
}


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Without the process that loads open3d, which takes seconds."""
    monkeypatch.setattr(machine, "LOAD_OPEN3D", "pass")
    return monkeypatch


def _finding(found: list[machine.Finding], name: str) -> machine.Finding:
    return next(finding for finding in found if finding.name == name)


def test_this_machine_is_fit(
    capsys: pytest.CaptureFixture[str], quick: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    quick.setattr(machine, "LEAST_MEMORY_GB", 0.1)
    called = call(capsys, "doctor", "--json", "--workspace", tmp_path / "not" / "there")
    assert called.code == 0, called.out
    assert {check["name"] for check in called.answer["checks"]} >= EXPECTED
    assert not (tmp_path / "not").exists()


@pytest.mark.parametrize(
    ("versions", "name", "todo"),
    [
        (
            {"fastapi": "0.165.0"},
            "fastapi",
            "prefect 3.8 needs fastapi >= 0.139, < 0.151; install 'fastapi>=0.139,<0.151'",
        ),
        ({"duckdb": None}, "duckdb", "run `make setup` or install from requirements.lock"),
        ({"open3d": "0.20.0", "open3d-cpu": "0.20.0"}, "open3d", "uninstall one of the two"),
        ({"open3d": None, "open3d-cpu": None}, "open3d", "the simulation and demo need it; run `make setup`"),
    ],
)
def test_wrong_package_is_a_problem_with_advice(
    quick: pytest.MonkeyPatch, versions: dict[str, str | None], name: str, todo: str
) -> None:
    installed = machine._version
    quick.setattr(machine, "_version", lambda package: versions.get(package, installed(package)))
    finding = _finding(machine.examine_machine(None), name)
    assert not finding.ok
    assert finding.todo.startswith(todo)


def test_open3d_that_does_not_load_names_the_library(quick: pytest.MonkeyPatch) -> None:
    quick.setattr(
        machine, "LOAD_OPEN3D", "raise ImportError('libusb-1.0.so.0: cannot open shared object file')"
    )
    finding = _finding(machine.examine_machine(None), "open3d")
    assert not finding.ok
    assert "does not load: ImportError: libusb-1.0.so.0" in finding.found
    assert "apt install libusb-1.0-0" in finding.todo


def test_problem_ends_with_3_and_is_marked(
    capsys: pytest.CaptureFixture[str], quick: pytest.MonkeyPatch
) -> None:
    quick.setattr(machine, "LEAST_DISK_GB", 1e9)
    called = call(capsys, "doctor")
    assert called.code == 3
    assert "PROBLEM disk: " in called.out
    assert "; free 1e+09 GB, or name another disk with --workspace" in called.out


def test_bytecode_that_is_not_written_is_a_hint_and_no_problem(quick: pytest.MonkeyPatch) -> None:
    quick.setattr("sys.dont_write_bytecode", True)
    finding = _finding(machine.examine_machine(None), "bytecode")
    assert finding.ok
    assert "unset PYTHONDONTWRITEBYTECODE" in finding.todo


def test_folder_that_cannot_be_written_is_a_problem(quick: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def refuse(**_options: object) -> None:
        raise PermissionError(13, "Permission denied")

    quick.setattr("tempfile.TemporaryDirectory", refuse)
    finding = _finding(machine.examine_machine(tmp_path), "write test")
    assert (finding.ok, finding.found) == (False, f"{tmp_path}: Permission denied")


def test_look_that_fails_is_a_finding(quick: pytest.MonkeyPatch) -> None:
    def fail(_place: Path) -> None:
        raise OSError("gone")

    quick.setattr("shutil.disk_usage", fail)
    assert any("OSError: gone" in finding.found for finding in machine.examine_machine(None))
