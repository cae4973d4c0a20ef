"""What the numbers of a scan must be like."""

from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from tasks.ingest import READERS, describe_scan, read_scan
from tasks.ingest.soundness import check_extent, check_step, horizontal_step
from tests.unit.ingest.clouds import wall_points

PATH = Path("a.laz")


def test_millimetres_are_noticed_by_their_extent() -> None:
    with pytest.raises(InputError, match=r"a\.laz: needs a cloud in metres of at most 10 km, .*millimetres"):
        check_extent(PATH, wall_points(2000) * 1000.0)


def test_a_few_strays_do_not_make_an_extent() -> None:
    points_m = wall_points(2000)
    points_m[:5] *= 1e6
    assert check_extent(PATH, points_m) == ()


@pytest.mark.parametrize("step_m", [0.005, 0.01, 0.03])
def test_a_coarse_grid_is_told(step_m: float) -> None:
    points_m = np.round(wall_points(5000) / step_m) * step_m
    assert horizontal_step(points_m) == pytest.approx(step_m, rel=1e-6)
    assert f"steps of {step_m * 1000:.3g} mm" in check_step(PATH, points_m, None)[0]


def test_single_precision_far_from_the_origin_is_refused() -> None:
    points_m = (
        (wall_points(5000) + np.array([512_345.0, 4_412_345.0, 0.0])).astype(np.float32).astype(np.float64)
    )
    with pytest.raises(InputError, match="needs coordinates finer than 50 mm, came steps of 500 mm"):
        check_step(PATH, points_m, 0.0001)


def test_fine_coordinates_show_no_grid() -> None:
    assert check_step(PATH, wall_points(5000), 0.0001) == ()


def test_sparse_points_show_no_grid() -> None:
    assert horizontal_step(wall_points(1100) * 100.0) <= 0.011


def test_rings_at_whole_heights_are_no_grid() -> None:
    angle_rad = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 5000)
    rings_m = np.column_stack((np.cos(angle_rad), np.sin(angle_rad), np.repeat(np.arange(50.0), 100)))
    assert check_step(PATH, rings_m, None) == ()


@pytest.mark.parametrize("ask", [read_scan, describe_scan])
@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a.zip", r"needs one of .*\.laz.*, came \.zip, which is packed; unpack it first"),
        ("a.FLS", r"came \.fls, which is a maker's raw format; export E57 or LAZ"),
        ("a.dwg", r"came \.dwg, which is unknown"),
        ("a", r"came no suffix"),
    ],
)
def test_a_format_that_is_not_read_is_answered_with_advice(
    tmp_path: Path, name: str, message: str, ask: object
) -> None:
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(InputError, match=message):
        ask(tmp_path / name)  # type: ignore[operator]


@pytest.mark.parametrize("ask", [read_scan, describe_scan])
def test_a_missing_file_and_a_folder_are_told_apart(tmp_path: Path, ask: object) -> None:
    with pytest.raises(InputError, match="came no such file"):
        ask(tmp_path / "a.laz")  # type: ignore[operator]
    with pytest.raises(InputError, match="came a folder"):
        ask(tmp_path)  # type: ignore[operator]


def test_no_two_readers_claim_a_suffix() -> None:
    suffixes = [suffix for reader in READERS.values() for suffix in reader.suffixes]
    assert len(suffixes) == len(set(suffixes))
