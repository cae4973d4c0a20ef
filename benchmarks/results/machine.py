"""On what was measured: processor, memory, versions, commit."""

import os
import platform
import subprocess
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parents[2]


def machine_lines() -> list[str]:
    """Lines of Markdown."""
    gib = psutil.virtual_memory().total / 2**30
    load = os.getloadavg()[0]
    libraries = ", ".join(
        f"{name} {version(name)}" for name in ("numpy", "numba", "laspy", "lazrs", "prefect", "duckdb")
    )
    return [
        f"- {datetime.now(UTC):%Y-%m-%d}, commit {_commit()}",
        f"- {_processor()}, {os.cpu_count()} cores, {gib:.0f} GiB, {platform.system()}",
        f"- load of the last minute {load:.1f}",
        f"- Python {platform.python_version()}, {libraries}",
    ]


def _commit() -> str:
    told = _git("rev-parse", "--short", "HEAD")
    return f"{told} with changes" if _git("status", "--porcelain", "--untracked-files=no") else told


def _git(*words: str) -> str:
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.strip() if done.returncode == 0 else "unknown"


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
