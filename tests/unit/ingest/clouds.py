"""Small scan files, written here and nowhere else."""

from collections.abc import Mapping
from pathlib import Path

import laspy
import numpy as np
from numpy.typing import NDArray

SCALE_M = 1e-4


def wall_points(n_points: int = 500, seed: int = 3) -> NDArray[np.float64]:
    """Points (n, 3) in a box of 20 m by 20 m by 30 m, on the grid of SCALE_M."""
    rng = np.random.default_rng(seed)
    return np.round(rng.uniform((-10.0, 30.0, -1.0), (10.0, 50.0, 29.0), (n_points, 3)) / SCALE_M) * SCALE_M


def write_las(
    path: Path,
    points_m: NDArray[np.float64],
    *,
    version: str = "1.4",
    point_format: int = 6,
    scale: float = SCALE_M,
    extra: Mapping[str, NDArray[np.float64]] | None = None,
    vlrs: tuple[laspy.VLR, ...] = (),
) -> Path:
    header = laspy.LasHeader(version=version, point_format=point_format)
    header.scales = np.full(3, scale)
    header.offsets = np.round(points_m.mean(axis=0)) if len(points_m) else np.zeros(3)
    header.vlrs.extend(vlrs)
    for name in extra or {}:
        header.add_extra_dim(laspy.ExtraBytesParams(name=name, type=np.float64))
    las = laspy.LasData(header)
    las.x, las.y, las.z = points_m.T
    for name, values in (extra or {}).items():
        las[name] = values
    las.write(path, laz_backend=laspy.LazBackend.LazrsParallel)
    return path


def wkt_vlr(wkt: str) -> laspy.VLR:
    return laspy.VLR("LASF_Projection", 2112, "wkt", wkt.encode() + b"\0")


def geo_keys_vlr(*keys: tuple[int, int]) -> laspy.VLR:
    rows = [(1, 1, 0, len(keys)), *((key, 0, 1, value) for key, value in keys)]
    return laspy.VLR("LASF_Projection", 34735, "keys", np.array(rows, dtype="<u2").tobytes())


def write_text(path: Path, text: str) -> Path:
    path.write_bytes(text.encode())
    return path


def rows_of(points_m: NDArray[np.float64], separator: str = " ") -> str:
    return "".join(separator.join(f"{value:.4f}" for value in point) + "\n" for point in points_m)
