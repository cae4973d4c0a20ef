"""The example notebook runs as a program on a catalog, and finds the lean that it simulates."""

import os
import re
import subprocess
import sys
from pathlib import Path

from tests.docs.sql_workspace import sql_workspace

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOK = ROOT / "docs" / "examples" / "notebook.py"


def test_the_notebook_reads_the_catalog_and_measures_the_lean(tmp_path: Path) -> None:
    ws = sql_workspace(tmp_path)
    done = subprocess.run(
        [sys.executable, NOTEBOOK, ws.catalog],
        cwd=tmp_path,
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "MPLBACKEND": "agg",
            "MPLCONFIGDIR": str(tmp_path / "matplotlib"),
        },
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    assert all(epoch in done.stdout for epoch in ("e0", "e1", "e2"))
    found = re.search(r"lean east, north: \[ *([\d.e-]+) +([\d.e-]+)\]", done.stdout)
    assert found is not None
    assert abs(float(found.group(1)) - 0.007) < 1e-5
    assert abs(float(found.group(2)) + 0.005) < 1e-5
