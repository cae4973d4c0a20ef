"""The command line starts quickly, names its commands and tells wrong usage."""

import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from flows.application import COMMANDS
from flows.version import VERSION
from tests.flows.calls import ROOT, call, call_process
from tests.flows.stored_campaign import publish, stored_campaign

HEAVY = {"prefect", "numpy", "open3d", "pydantic", "duckdb", "pyarrow", "scipy", "laspy"}

CONTRACT = [
    "demo",
    "init",
    "check",
    "schema",
    "plan",
    "run",
    "status",
    "compare",
    "export",
    "doctor",
    "verify",
]


def test_version_is_that_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    assert project["project"]["version"] == VERSION


def test_version_is_told_by_the_process() -> None:
    called = call_process("--version")
    assert (called.code, called.out, called.err) == (0, f"tiltwatch {VERSION}\n", "")


@pytest.mark.parametrize(
    "words", [["--version"], ["--help"], ["run", "--help"], ["status", "--help"], ["nonsense"]]
)
def test_start_loads_nothing_heavy(words: list[str]) -> None:
    code = f"import sys; from flows.cli import main; main({words}); print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert HEAVY & set(done.stderr.splitlines()[-1].split()) == set()


def test_version_does_not_even_load_the_parser() -> None:
    code = "import sys; from flows.cli import main; main(['--version']); print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert "cyclopts" not in done.stderr.split()


@pytest.mark.parametrize(
    "words",
    [
        ["status"],
        ["compare", "e2", "e1"],
        pytest.param(["compare-schemes", "e2"], marks=pytest.mark.slow),
        pytest.param(["alarms"], marks=pytest.mark.slow),
        pytest.param(["limits"], marks=pytest.mark.slow),
        ["verify"],
        pytest.param(["export", "tilt"], marks=pytest.mark.slow),
        ["run", "--epoch", "not there"],
    ],
    ids=lambda words: words[0],
)
def test_prefect_is_for_runs_alone(tmp_path: Path, words: list[str]) -> None:
    stored = stored_campaign(tmp_path)
    for number, epoch in enumerate(("e1", "e2")):
        publish(stored, epoch, number)
    name, *rest = words
    code = "import sys; from flows.cli import main; main(sys.argv[1:]); print('prefect' in sys.modules)"
    whole = [name, str(stored.file), *rest, "-q"]
    done = subprocess.run(
        [sys.executable, "-c", code, *whole], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert done.stdout.splitlines()[-1] == "False"
    assert "traceback" not in done.stderr.lower(), done.stderr


def test_a_bad_campaign_file_is_refused_before_prefect_is_loaded(tmp_path: Path) -> None:
    file = tmp_path / "campaign.toml"
    file.write_text("[structure]\n")
    words = ["run", str(file)]
    code = f"import sys; from flows.cli import main; print(main({words})); print('prefect' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.splitlines() == ["3", "False"]
    first, second = done.stderr.splitlines()[:2]
    assert first.startswith("tiltwatch ")
    assert "reading" in first
    assert second.startswith("error: ")


@pytest.mark.parametrize("name", CONTRACT)
def test_help_names_every_command_of_the_contract(capsys: pytest.CaptureFixture[str], name: str) -> None:
    called = call(capsys, "--help")
    assert called.code == 0
    assert f"│ {name} " in called.out


@pytest.mark.parametrize("name", COMMANDS)
def test_short_help_is_the_first_line_of_the_command(name: str) -> None:
    module = name.replace("-", "_")
    command = getattr(importlib.import_module(f"flows.commands.{module}"), module)
    assert command.__doc__.splitlines()[0] == COMMANDS[name]


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_every_command_is_shown(capsys: pytest.CaptureFixture[str], name: str) -> None:
    called = call(capsys, name, "--help")
    assert called.code == 0
    assert f"Usage: tiltwatch {name}" in called.out


def test_help_of_status_tells_its_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    out = call(capsys, "status", "--help").out
    assert all(f"Exit code {code}" in out for code in (0, 4, 5, 6))


def test_unknown_command_names_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    called = call(capsys, "chekc")
    assert called.code == 2
    assert called.err.startswith('error: Unknown command "chekc". Did you mean "check"?')
    assert called.err.endswith("`tiltwatch --help` shows what there is\n")


def test_unknown_option_names_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    called = call(capsys, "check", "x.toml", "--jsn")
    assert (called.code, called.out) == (2, "")
    assert (
        called.err
        == "error: Unknown option: --jsn. Did you mean --json? `tiltwatch check --help` shows what there is\n"
    )


def test_missing_word_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    called = call(capsys, "compare", "x.toml", "e2")
    assert called.code == 2
    assert "parameter REFERENCE requires an argument" in called.err


def test_wrong_choice_of_fail_on_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    called = call(capsys, "run", "x.toml", "--fail-on", "fire")
    assert called.code == 2
    assert "quality" in called.err


def test_wrong_usage_answers_programs_too(capsys: pytest.CaptureFixture[str]) -> None:
    called = call(capsys, "check", "--json")
    assert called.answer["ok"] is False
    assert called.answer["exit_code"] == 2
