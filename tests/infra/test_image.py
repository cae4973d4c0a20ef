"""infra/Containerfile: what can be shown of it where no container engine runs."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CONTAINERFILE = ROOT / "infra" / "Containerfile"
IN_EVERY_DEBIAN = "apt"
"""A package of every Debian image; what it needs is there too (libc6, libstdc++6, libgcc-s1)."""
NOT_ON_EVERY_MACHINE = {"libusb-1.0.so.0": "libusb-1.0-0"}
"""Libraries that machines with a display have without their package being asked for, and bare ones lack."""


def instructions() -> list[tuple[str, str]]:
    """Instructions of the Containerfile and their words, comments and line ends taken out."""
    text = re.sub(r"^#.*\n", "", CONTAINERFILE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    lines = re.sub(r"\\\n\s*", " ", text).splitlines()
    return [(line.split(maxsplit=1)[0], line.split(maxsplit=1)[1]) for line in lines if line.strip()]


def words_of(name: str) -> list[str]:
    return [words for instruction, words in instructions() if instruction == name]


def installed_by_apt() -> set[str]:
    (words,) = [run for run in words_of("RUN") if "apt-get install" in run]
    listed = words.split("--no-install-recommends")[1].split("&&")[0]
    return set(listed.split())


def test_only_the_base_image_is_named_and_no_address() -> None:
    assert words_of("FROM") == ["python:3.11-slim-bookworm"]
    text = CONTAINERFILE.read_text(encoding="utf-8")
    assert not re.search(r"://|index-url|find-links|trusted-host", text)


def test_what_is_copied_is_there_and_not_ignored() -> None:
    kept = {
        line.removeprefix("!")
        for line in (ROOT / ".containerignore").read_text(encoding="utf-8").splitlines()
        if line.startswith("!")
    }
    sources = {source for words in words_of("COPY") for source in words.split()[:-1]}
    assert sources == kept
    assert [source for source in sources if not (ROOT / source).exists()] == []


def test_packages_are_installed_by_hash_and_the_program_is_not_run_by_root() -> None:
    runs = " ".join(words_of("RUN"))
    assert "--require-hashes -r requirements.lock" in runs
    order = [instruction for instruction, _words in instructions()]
    assert words_of("USER") == ["tiltwatch"]
    assert order.index("USER") > max(place for place, name in enumerate(order) if name == "RUN")


def test_set_up_of_a_checkout_installs_the_same_system_libraries() -> None:
    script = (ROOT / "infra" / "install.sh").read_text(encoding="utf-8")
    (listed,) = re.findall(r'packages="([^"]*)"', script)
    assert set(listed.split()) == installed_by_apt()


@pytest.mark.slow
def test_program_runs_with_nothing_but_what_is_copied(tmp_path: Path) -> None:
    for words in words_of("COPY"):
        *sources, target = words.split()
        for source in sources:
            place = tmp_path / target if target != "./" else tmp_path / source
            place.parent.mkdir(parents=True, exist_ok=True)
            if (ROOT / source).is_dir():
                shutil.copytree(ROOT / source, place, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(ROOT / source, place)
    code = "import flows.monitor_campaign, tasks, storage; print(flows.__file__, tasks.__file__, storage.__file__)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert [Path(path).is_relative_to(tmp_path) for path in done.stdout.split()] == [True] * 3


def _closure(packages: set[str]) -> set[str]:
    """Installed packages that these need, and they themselves."""
    listed = subprocess.run(
        ["dpkg-query", "-W", "-f", "${Package}\t${Pre-Depends}, ${Depends}\n"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    needs = {
        name: set(re.findall(r"(?:^|[,|] *)([a-z0-9][a-z0-9+.-]+)", depends))
        for name, depends in (line.split("\t") for line in listed.splitlines())
    }
    found: set[str] = set()
    waiting = set(packages)
    while waiting:
        found |= waiting
        waiting = {need for name in waiting for need in needs.get(name, ())} - found
    return found


def _system_libraries(package: Path) -> Iterator[str]:
    """Names of the libraries that open3d's own ones load, directly or not, and that are not in its folder."""
    # its operators for PyTorch and TensorFlow load only beside these
    for library in (*package.glob("libOpen3D.so*"), *package.glob("pybind*.so")):
        told = subprocess.run(["ldd", library], capture_output=True, text=True, check=True).stdout
        for name, where in re.findall(r"^\s*(\S+) => (.+?)(?: \(0x.*)?$", told, re.MULTILINE):
            if not where.startswith(str(package)):
                yield name


@pytest.mark.skipif(
    not (shutil.which("ldd") and shutil.which("dpkg-query") and importlib.util.find_spec("open3d")),
    reason="needs Debian's package database, ldd and open3d",
)
def test_system_packages_cover_every_library_that_open3d_loads() -> None:
    spec = importlib.util.find_spec("open3d")
    assert spec is not None
    assert spec.origin is not None
    libraries = set(_system_libraries(Path(spec.origin).parent))
    assert {"libEGL.so.1", "libGL.so.1", "libusb-1.0.so.0"} <= libraries
    covered = _closure(installed_by_apt() | {IN_EVERY_DEBIAN})
    assert {name: owners for name in libraries if not (owners := _owners(name)) & covered} == {}


def _owners(library: str) -> set[str]:
    """Packages that hold a library."""
    if library in NOT_ON_EVERY_MACHINE:
        return {NOT_ON_EVERY_MACHINE[library]}
    told = subprocess.run(
        ["dpkg-query", "-S", f"*/{library}"], capture_output=True, text=True, check=False
    ).stdout
    return {line.split(":")[0] for line in told.splitlines()}
