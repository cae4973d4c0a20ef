"""An array that several hold is in memory once, and is let go when nobody holds it."""

import gc
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from storage.artifacts import artifact_path, put_array
from storage.errors import StorageError
from storage.shared_arrays import share_array
from storage.workspace import open_workspace


def test_all_who_hold_it_hold_the_same(tmp_path: Path) -> None:
    workspace = open_workspace(tmp_path)
    values = np.arange(300.0).reshape(100, 3)
    ref = put_array(workspace, "shaft", values)
    with ThreadPoolExecutor(8) as pool:
        held = list(pool.map(lambda _: share_array(workspace, ref), range(8)))
    assert all(array is held[0] for array in held)
    assert np.array_equal(held[0], values)


def test_what_nobody_holds_is_read_anew(tmp_path: Path) -> None:
    workspace = open_workspace(tmp_path)
    ref = put_array(workspace, "shaft", np.arange(5.0))
    held = share_array(workspace, ref)
    artifact_path(workspace, ref).unlink()
    assert share_array(workspace, ref) is held
    del held
    gc.collect()
    with pytest.raises(StorageError):
        share_array(workspace, ref)


def test_workspaces_do_not_share(tmp_path: Path) -> None:
    one, other = open_workspace(tmp_path / "one"), open_workspace(tmp_path / "other")
    refs = [put_array(place, "shaft", np.arange(5.0)) for place in (one, other)]
    assert share_array(one, refs[0]) is not share_array(other, refs[1])
