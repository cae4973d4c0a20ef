"""The rules of the house that a machine can hold: sizes, names, one direction of imports, nothing of this machine."""

import ast
import importlib.util
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("flows", "tasks", "storage", "dashboard")
SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
ALL_PYTHON = sorted({*SOURCES, *(ROOT / "tests").rglob("*.py"), *(ROOT / "docs").glob("*.py")})
FORBIDDEN_NAMES = re.compile(r"^_?(utils?|helpers?|commons?|managers?|misc)$")


def functions(path: Path) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    body = function.body[1:] if ast.get_docstring(function) and len(function.body) > 1 else function.body
    return (body[-1].end_lineno or 0) - body[0].lineno + 1


def test_no_function_is_longer_than_forty_lines() -> None:
    long = {
        f"{path.relative_to(ROOT)}:{f.lineno} {f.name}": body_lines(f)
        for path in SOURCES
        for f in functions(path)
        if body_lines(f) > 40
    }
    assert long == {}


def test_no_file_is_longer_than_350_lines() -> None:
    long = {str(p.relative_to(ROOT)): n for p in ALL_PYTHON if (n := len(p.read_text().splitlines())) > 350}
    assert long == {}


def test_the_median_function_is_short() -> None:
    sizes = sorted(body_lines(f) for path in SOURCES for f in functions(path))
    assert sizes[len(sizes) // 2] <= 8


def test_nothing_is_called_utils() -> None:
    bad = [p for p in SOURCES if any(FORBIDDEN_NAMES.match(part) for part in (p.stem, *p.parts))]
    assert bad == []


@pytest.mark.parametrize("package", PACKAGES)
def test_generic_names_resolve_inside_the_checkout(package: str) -> None:
    assert Path(importlib.import_module(package).__file__ or "").is_relative_to(ROOT / package)


def test_only_ingest_and_compositions_open_files() -> None:
    """A stage is pure: it opens no file, reads no clock, prints nothing, draws no unseeded number."""
    impure = re.compile(
        r"\bopen\(|\.read_text\(|\.write_|\bprint\(|time\.time\(|datetime\.now\(|np\.random\.rand"
    )
    stages = [
        p for p in SOURCES if p.parent.parent.name == "tasks" and p.parent.name not in ("ingest", "settings")
    ]
    found = [
        f"{p.relative_to(ROOT)}: {m.group()}"
        for p in stages
        for m in impure.finditer(p.read_text(encoding="utf-8"))
    ]
    assert len(stages) > 40
    assert found == []


def test_a_broken_import_rule_is_named_by_the_linter(tmp_path: Path) -> None:
    """The linter is not only there: it finds a stage that imports another one, and names the line."""
    for package in PACKAGES:
        (tmp_path / package).symlink_to(ROOT / package)
    tasks = tmp_path / "tasks"
    tasks.unlink()
    tasks.mkdir()
    for path in (ROOT / "tasks").iterdir():
        if path.name != "axis":
            (tasks / path.name).symlink_to(path)
    (tasks / "axis").mkdir()
    for path in (ROOT / "tasks" / "axis").glob("*.py"):
        (tasks / "axis" / path.name).write_bytes(path.read_bytes())
    with (tasks / "axis" / "irls.py").open("a") as file:
        file.write("\nfrom tasks.contours import fit_contour\n")
    (tmp_path / "pyproject.toml").write_bytes((ROOT / "pyproject.toml").read_bytes())
    lint = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [lint, "--no-cache"], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode != 0
    assert "tasks.axis.irls -> tasks.contours" in done.stdout


def tracked_files() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if listed.returncode != 0:
        pytest.skip("not a git checkout: nothing says which files belong to it")
    return [ROOT / name for name in listed.stdout.splitlines()]


def test_the_lock_file_has_hashes_and_no_addresses() -> None:
    text = (ROOT / "requirements.lock").read_text()
    assert not re.search(r"https?://|file:|index-url|find-links", text)
    pinned = re.findall(r"^([a-z0-9][\w.-]*)==", text, re.MULTILINE)
    assert len(pinned) > 100
    assert text.count("--hash=sha256:") >= len(pinned)


def test_every_dependency_is_in_the_lock_file() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = {
        re.split(r"[<>=;\[ ]", line)[0].lower()
        for line in [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    }
    locked = {
        name.lower() for name in re.findall(r"^([\w.-]+)==", (ROOT / "requirements.lock").read_text(), re.M)
    }
    assert wanted - locked == set()


def test_fastapi_is_capped_where_prefect_breaks() -> None:
    match = re.search(r"^fastapi==0\.(\d+)\.", (ROOT / "requirements.lock").read_text(), re.MULTILINE)
    assert match is not None
    assert 139 <= int(match.group(1)) < 151


def test_nothing_committed_names_a_path_of_this_machine() -> None:
    places = [str(ROOT), str(ROOT.parent) + "/", str(Path.home()) + "/"]
    found = [
        f"{path.relative_to(ROOT)}: {place}"
        for path in tracked_files()
        if path.is_file() and path.suffix not in {".png"}
        for place in places
        if place.encode() in path.read_bytes()
    ]
    assert found == []


def test_pages_made_from_the_code_are_up_to_date() -> None:
    pages = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
    assert pages is not None
    assert pages.loader is not None
    generate = importlib.util.module_from_spec(pages)
    pages.loader.exec_module(generate)
    hint = "run .venv/bin/python docs/generate.py"
    assert (ROOT / "docs" / "data-dictionary.md").read_text(encoding="utf-8") == generate.data_dictionary(), (
        hint
    )
    assert (ROOT / "docs" / "variants.md").read_text(encoding="utf-8") == generate.variants(), hint


def test_links_between_pages_lead_somewhere() -> None:
    pages = [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "infra").glob("*.md"),
    ]
    broken = [
        f"{page.relative_to(ROOT)}: {target}"
        for page in pages
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
        if "://" not in target and not (page.parent / target).exists()
    ]
    assert broken == []
