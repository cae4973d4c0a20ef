"""The dashboard as a process of its own, as a user starts it."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

READY_S = 60.0


@dataclass(frozen=True)
class Served:
    """Where it listens, and its process."""

    url: str
    process: subprocess.Popen[str]

    def at(self, path: str) -> str:
        """The address of a page."""
        return f"{self.url}{path.lstrip('/')}"


@contextmanager
def serve_dashboard(campaign: Path, workspace: Path) -> Iterator[Served]:
    """Start `tiltwatch dashboard` on a free port of loopback, and stop it."""
    command = [
        sys.executable,
        "-m",
        "flows.cli",
        "dashboard",
        str(campaign),
        "--port",
        "0",
        "--workspace",
        str(workspace),
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said: list[str] = []
    assert process.stdout is not None
    assert process.stderr is not None
    listener = threading.Thread(target=lambda: said.extend(process.stderr or ()), daemon=True)
    listener.start()
    killer = threading.Timer(READY_S, process.kill)
    killer.start()
    try:
        url = process.stdout.readline().strip()
        killer.cancel()
        if not url.startswith("http://127.0.0.1:"):
            process.kill()
            listener.join(5.0)
            raise RuntimeError(f"the dashboard did not start within {READY_S:g} s:\n{''.join(said)}")
        yield Served(url, process)
    finally:
        killer.cancel()
        process.terminate()
        process.wait(10.0)
        listener.join(5.0)
        # left to the collector they would warn in some later test
        process.stdout.close()
        process.stderr.close()
