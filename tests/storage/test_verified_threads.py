from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from storage.artifacts import is_whole, put_array
from storage.workspace import open_workspace


def test_threads_that_ask_at_once_all_find_a_whole_artifact_whole(tmp_path: Path) -> None:
    ws = open_workspace(tmp_path / "ws")
    refs = [put_array(ws, "x", np.arange(10.0) + i) for i in range(100)]
    with ThreadPoolExecutor(8) as pool:
        for _ in range(5):
            (ws.artifacts / "verified.txt").unlink(missing_ok=True)
            assert all(pool.map(lambda ref: is_whole(ws, ref), refs * 3))
