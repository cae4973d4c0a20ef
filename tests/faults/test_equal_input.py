"""The same measurement written down in another way gives the same lean."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.records import TiltRow
from tasks.ingest import read_scan
from tests.faults.sites import FIRST, Site, epoch_text, head_of, stations_of
from tests.faults.test_bad_epochs import site_cloud
from tests.flows.campaigns import replace_text
from tests.unit.ingest.clouds import write_text

pytestmark = pytest.mark.usefixtures("prefect_api")

FAR_NORTH_EAST_UP_M = (4_412_345.0, 512_345.0, 1_234.0)
ROUNDING = 1e-6
"""Of a standard deviation: what 1e-9 m in the coordinates may do to a lean known to 5e-6."""


@pytest.fixture(scope="module")
def cloud(sound: Site) -> NDArray[np.float64]:
    """Points (n, 3) of an epoch near the structure, in the frame of the site."""
    points_m = site_cloud(sound, FIRST)
    return off_grid(points_m[np.hypot(points_m[:, 0], points_m[:, 1]) < 15.0])


def off_grid(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (n, 3) off the grid of the file: on the edge of a voxel, rounding would decide where one belongs."""
    return points_m + np.random.default_rng(0).uniform(-4e-5, 4e-5, points_m.shape)


def rows_of_all(values: NDArray[np.float64], digits: int) -> str:
    return "".join(",".join(f"{value:.{digits}f}" for value in row) + "\n" for row in values.tolist())


def registered(sound: Site, folder: Path, points_m: NDArray[np.float64]) -> Site:
    site = Site(folder)
    write_text(folder / "merged.csv", "x,y,z\n" + rows_of_all(points_m, 10))
    epoch = '[[epochs]]\nid = "only"\ntime = 2026-01-01T06:00:00Z\nregistered = "merged.csv"\n'
    site.file.write_text(head_of(sound.text()) + epoch, encoding="utf-8")
    return site


def lean_of(site: Site, epoch: str = "only") -> TiltRow:
    told = site.run("--scheme", "A", "--epoch", epoch)
    assert told.code == 0, told.err
    return site.tilts(epoch)["A/robust"]


def assert_same(one: TiltRow, other: TiltRow, tolerance: float) -> None:
    """Leans within a share of their standard deviation, and their covariances alike."""
    sigma = np.sqrt(one.lean_cov_ee)
    assert abs(one.lean_east - other.lean_east) < tolerance * sigma
    assert abs(one.lean_north - other.lean_north) < tolerance * sigma
    assert other.lean_cov_ee == pytest.approx(one.lean_cov_ee, rel=max(tolerance, 1e-6))
    assert other.lean_cov_nn == pytest.approx(one.lean_cov_nn, rel=max(tolerance, 1e-6))


def test_a_cloud_in_north_east_up_far_from_the_origin_leans_as_in_the_local_frame(
    sound: Site, cloud: NDArray[np.float64], tmp_path: Path
) -> None:
    (tmp_path / "local").mkdir()
    (tmp_path / "grid").mkdir()
    local = registered(sound, tmp_path / "local", cloud)
    grid = registered(sound, tmp_path / "grid", cloud[:, (1, 0, 2)] + FAR_NORTH_EAST_UP_M)
    replace_text(grid.file, 'axes = "ENU"', 'axes = "NEU"')
    replace_text(
        grid.file, 'horizontal = "local"', f'horizontal = "EPSG:4547"\norigin_m = {list(FAR_NORTH_EAST_UP_M)}'
    )
    assert_same(lean_of(local), lean_of(grid), ROUNDING)


@pytest.mark.slow
def test_polar_stations_lean_as_the_cartesian_ones(sound: Site, tmp_path: Path) -> None:
    site = Site(tmp_path)
    stations = stations_of(sound.text(), FIRST)[:3]
    for table in stations:
        points_m = off_grid(read_scan(sound.folder / str(table["scan"])).points_m)
        write_text(tmp_path / f"{table['id']}.xyz", rows_of_all(points_m, 10))
        range_m = np.linalg.norm(points_m, axis=1)
        alpha_deg = np.degrees(np.arctan2(points_m[:, 1], points_m[:, 0]))
        omega_deg = np.degrees(np.arcsin(points_m[:, 2] / range_m))
        polar = np.stack([range_m, alpha_deg, omega_deg], axis=1)
        write_text(tmp_path / f"{table['id']}.csv", "S,alpha,omega\n" + rows_of_all(polar, 11))
    cartesian = [{**table, "scan": f"{table['id']}.xyz"} for table in stations]
    polar = [{**table, "scan": f"{table['id']}.csv", "coordinates": "polar"} for table in stations]
    epochs = epoch_text("cartesian", 0, cartesian) + epoch_text("polar", 1, polar)
    site.file.write_text(head_of(sound.text()) + epochs, encoding="utf-8")
    assert_same(lean_of(site, "cartesian"), lean_of(site, "polar"), ROUNDING)
