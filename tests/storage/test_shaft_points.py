"""The points of an epoch are found by what is on record, cut by height as by a mask, and missed with a reason."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from storage.artifacts import ArtifactRef, artifact_path
from storage.catalog import rebuild_catalog
from storage.errors import StorageError, UsageError
from storage.ledger import append_run
from storage.places import with_store
from storage.views.shaft_points import ShaftPoints, shaft_points
from storage.workspace import Workspace
from tasks.caching import record_name
from tests.storage.campaign import STRUCTURE, stage_run_row
from tests.storage.stored_points import keep_isolation, publish

N = 500
STATIONS = ("ST02", "ST01")


def cloud(n: int = N, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    # heights in steps, so that many are equal
    up = np.sort(np.round(rng.uniform(0.0, 30.0, n), 1))
    return np.column_stack([rng.normal(0.0, 4.0, (n, 2)), up]), rng.integers(0, 2, n).astype(np.uint16)


def keep(ws: Workspace, less: str, stations: tuple[str, ...], seed: int = 1) -> ArtifactRef:
    points_m, index = cloud(seed=seed)
    return keep_isolation(ws, points_m, (index % len(stations)).astype(np.uint16), stations, less)


def test_points_and_stations_are_those_of_the_isolation(ws: Workspace) -> None:
    keep(ws, "", STATIONS)
    publish(ws, "", n_points_used=N)
    found = shaft_points(ws, STRUCTURE, "e0")
    points_m, index = cloud()
    np.testing.assert_array_equal(found.points_m, points_m)
    np.testing.assert_array_equal(found.station_index, index)
    # in the order of the poses, not of the alphabet
    assert found.stations == STATIONS
    assert isinstance(found.points_m, np.memmap)


def test_points_of_a_workspace_with_a_store_elsewhere_are_taken_from_there(
    ws: Workspace, tmp_path: Path
) -> None:
    elsewhere = Workspace(tmp_path / "store")
    elsewhere.artifacts.mkdir(parents=True)
    keep(elsewhere, "", STATIONS)
    publish(ws, "", n_points_used=N)
    assert len(shaft_points(with_store(ws, str(elsewhere.root)), STRUCTURE, "e0")) == N


def test_of_several_isolations_the_published_one_counts(ws: Workspace) -> None:
    """First with a station that was left out afterwards, then without, then without another one."""
    keep(ws, "", ("ST01", "ST02", "ST03"), seed=1)
    keep(ws, " without ST03", ("ST01", "ST02"), seed=2)
    keep(ws, " without ST01", ("ST02", "ST03"), seed=3)
    publish(ws, "", " without ST03", " without ST01", n_points_used=N)
    found = shaft_points(ws, STRUCTURE, "e0")
    np.testing.assert_array_equal(found.points_m, cloud(seed=2)[0])
    assert found.stations == ("ST01", "ST02")


def test_an_isolation_on_behalf_of_another_epoch_is_not_taken(ws: Workspace) -> None:
    keep(ws, "", STATIONS)
    publish(ws, n_points_used=N)
    row = replace(stage_run_row("run-2", "e0"), stage="e9 preprocessing", cache_key="preprocessing-1")
    append_run(ws, "run-2", STRUCTURE, [row])
    rebuild_catalog(ws)
    with pytest.raises(StorageError, match="are not in this workspace; to make them anew"):
        shaft_points(ws, STRUCTURE, "e0")


def test_points_that_were_swept_are_missed_with_what_to_do(ws: Workspace) -> None:
    ref = keep(ws, "", STATIONS)
    publish(ws, "", n_points_used=N)
    artifact_path(ws, ref).unlink()
    with pytest.raises(StorageError, match=r"chimney-01, epoch e0 are gone; .*tiltwatch run FILE --epoch e0"):
        shaft_points(ws, STRUCTURE, "e0")


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"result": 3}', b'{"result": "{}"}'])
def test_a_torn_record_is_none(ws: Workspace, content: bytes) -> None:
    keep(ws, "", STATIONS)
    publish(ws, "", n_points_used=N)
    (ws.root / record_name("preprocessing-1")).write_bytes(content)
    with pytest.raises(StorageError, match="are not in this workspace"):
        shaft_points(ws, STRUCTURE, "e0")


def test_a_failed_epoch_has_no_points_and_says_why(ws: Workspace) -> None:
    publish(ws, state="failed", n_points_used=0)
    with pytest.raises(
        StorageError, match="epoch e0 of chimney-01 is failed and has no isolated shaft: no scan"
    ):
        shaft_points(ws, STRUCTURE, "e0")


@pytest.mark.parametrize("epoch", ["e1", "../e0", "<b>", "' OR 1=1 --"])
def test_an_unknown_epoch_is_said_with_those_that_are_known(ws: Workspace, epoch: str) -> None:
    publish(ws, n_points_used=N)
    with pytest.raises(UsageError, match="known: e0"):
        shaft_points(ws, STRUCTURE, epoch)


def made(n: int = N) -> ShaftPoints:
    return ShaftPoints(STRUCTURE, "e0", *cloud(n), STATIONS)


@given(st.integers(-20, 320), st.integers(-20, 320))
def test_a_range_of_heights_is_what_a_mask_gives(low: int, high: int) -> None:
    points = made()
    found = points.between(low / 10.0, high / 10.0)
    inside = (points.points_m[:, 2] >= low / 10.0) & (points.points_m[:, 2] <= high / 10.0)
    np.testing.assert_array_equal(found.points_m, points.points_m[inside])
    np.testing.assert_array_equal(found.station_index, points.station_index[inside])


def test_a_slice_has_the_points_on_both_of_its_ends() -> None:
    points = made()
    # 10.15 - 0.05 is a little above 10.1
    inside = (points.points_m[:, 2] > 10.05) & (points.points_m[:, 2] < 10.25)
    assert len(points.of_slice(10.15, 0.1)) == np.count_nonzero(inside) > 0


@pytest.mark.parametrize(
    ("most", "step"), [(1, 500), (7, 72), (250, 2), (251, 2), (499, 2), (500, 1), (10**9, 1)]
)
def test_thinning_takes_every_kth_point(most: int, step: int) -> None:
    points = made()
    found = points.thinned(most)
    np.testing.assert_array_equal(found.points_m, points.points_m[::step])
    np.testing.assert_array_equal(found.station_index, points.station_index[::step])
    assert len(found) <= most


def test_thinning_to_nothing_is_refused() -> None:
    with pytest.raises(UsageError, match="at least 1 point; got 0"):
        made().thinned(0)
