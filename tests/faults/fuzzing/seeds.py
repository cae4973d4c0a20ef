"""Files to begin from: those of the shared data that are small, and small ones written here."""

import struct
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tests.shared import SHARED
from tests.unit.ingest.clouds import SCALE_M, geo_keys_vlr, rows_of, wall_points, wkt_vlr, write_las
from tests.unit.ingest.e57_files import (
    CARTESIAN,
    SPHERICAL,
    Source,
    cloud,
    doubles,
    integers,
    named,
    posed,
    singles,
    write_e57,
)
from tests.unit.settings.campaign_text import FEWEST, WHOLE
from tests.unit.settings.test_sidecar import SOUND

LARGEST_BYTES = 10_000
TIGHT_M = 100.0
SUFFIXES = (".las", ".laz", ".e57", ".ptx", ".pts", ".ply", ".pcd", ".xyz", ".csv", ".txt", ".parquet")
BROKEN = {
    "1.2-no-points.las", "prec3.las", "bunny_8.pts", "multiple-and-transform.ptx", "sized_dims.ply", "unsized_dims.ply",
}  # fmt: skip
SOUND_AFTER_ALL = {"1.2-empty-geotiff-vlrs.las", "bad-geotiff-keys.las", "hextest.las"}
SEVERAL = ("A_B", "A_moved_B", "own-two")
"""How the names begin of files that hold two scans."""

LIMITS = """\
[[limits]]
name = "own"
version = 1
kind = "construction"
document = "contract"
source = "page 3"
points_m = [[10.0, 0.02], [50.0, 0.05], [100.0, 0.09]]
[[limits]]
name = "own"
version = 2
valid_from = 2026-01-01
kind = "construction"
document = "contract"
source = "page 4"
one_in = 500.0
at_least_m = 0.01
above_m = 10.0
"""
SETTINGS = {
    "campaign": (WHOLE, FEWEST),
    "sidecar": (SOUND, SOUND + 'id = "north"\nof = ["north", "ST02"]\nsize_bytes = 12\n'),
    "limits": (LIMITS,),
}


@dataclass(frozen=True, slots=True)
class Seed:
    """A file to begin from; ``family`` is its suffix without the dot, or the kind of its settings.

    One that ``is_broken`` is refused before anything is done to it.
    """

    family: str
    name: str
    content: bytes
    is_broken: bool = False

    @property
    def suffix(self) -> str:
        """Suffix under which it is read."""
        return ".toml" if self.family in SETTINGS else f".{self.family}"


@cache
def seeds() -> Mapping[str, tuple[Seed, ...]]:
    """All seeds by family, in an order that is the same everywhere."""
    found: dict[str, list[Seed]] = {}
    for seed in (*_shared(), *_own(), *_settings()):
        found.setdefault(seed.family, []).append(seed)
    return {family: tuple(group) for family, group in found.items()}


def _settings() -> Iterator[Seed]:
    for family, texts in SETTINGS.items():
        for number, text in enumerate(texts, 1):
            yield Seed(family, f"own-{number}", text.encode())


def _shared() -> Iterator[Seed]:
    for folder in ("formats", "malformed"):
        for path in sorted((SHARED / "data" / folder).rglob("*")):
            if path.suffix in SUFFIXES and path.stat().st_size <= LARGEST_BYTES:
                is_broken = path.name in BROKEN or (
                    folder == "malformed" and path.name not in SOUND_AFTER_ALL
                )
                yield Seed(path.suffix[1:], f"{path.parent.name}/{path.name}", path.read_bytes(), is_broken)


def _own() -> Iterator[Seed]:
    with tempfile.TemporaryDirectory() as folder:
        for suffix, name, write in _writers():
            path = Path(folder) / f"{name}.{suffix}"
            write(path)
            yield Seed(suffix, f"own-{name}", _dateless(path))


def _dateless(path: Path) -> bytes:
    """Content without the day on which it was written."""
    content = bytearray(path.read_bytes())
    if path.suffix in {".las", ".laz"}:
        struct.pack_into("<HH", content, 90, 1, 2025)
    return bytes(content)


def _writers() -> Iterator[tuple[str, str, Callable[[Path], object]]]:
    yield from _point_records()
    yield from _e57_files()
    yield from _texts()
    yield from _plys()
    yield from _pcds()
    yield from _tables()


def _point_records() -> Iterator[tuple[str, str, Callable[[Path], object]]]:
    points = wall_points(40)
    for point_format, version in ((0, "1.2"), (3, "1.2"), (6, "1.4"), (7, "1.4")):
        for suffix in ("las", "laz"):
            yield (
                suffix,
                f"format-{point_format}",
                lambda path, v=version, f=point_format: write_las(path, points, version=v, point_format=f),
            )
    extra = {"height": points[:, 2]}
    yield "laz", "extra", lambda path: write_las(path, points, extra=extra)
    yield "las", "wkt", lambda path: write_las(path, points, vlrs=(wkt_vlr('LOCAL_CS["a",UNIT["metre",1]]'),))
    yield "las", "keys", lambda path: write_las(path, points, vlrs=(geo_keys_vlr((1024, 1), (3076, 9001)),))


def _e57_files() -> Iterator[tuple[str, str, Callable[[Path], object]]]:
    points = wall_points(30)
    pose = posed((0.8, 0.0, 0.0, 0.6), (1.0, 2.0, 3.0))
    scaled = Source(
        tuple(
            integers(name, values, -600_000, 600_001, SCALE_M)
            for name, values in zip(CARTESIAN, points.T, strict=True)
        ),
        30,
        named("west"),
    )
    angles = Source(
        (
            singles(SPHERICAL[0], np.linspace(5.0, 30.0, 30)),
            doubles(SPHERICAL[1], np.linspace(-1.0, 1.0, 30)),
            doubles(SPHERICAL[2], np.linspace(-0.2, 1.2, 30)),
            integers("sphericalInvalidState", np.arange(30) % 5 == 0, 0, 2),
        ),
        30,
        named("polar") + pose,
    )
    yield "e57", "doubles", lambda path: write_e57(path, cloud(points, named("east") + pose))
    yield "e57", "scaled", lambda path: write_e57(path, scaled)
    yield "e57", "two", lambda path: write_e57(path, cloud(points, named("a")), scaled, system="LOCAL")
    yield "e57", "angles", lambda path: write_e57(path, angles)


def _texts() -> Iterator[tuple[str, str, Callable[[Path], object]]]:
    points = wall_points(25)
    rows, inside = rows_of(points), [f"{line} 0.5 10 20 30" for line in rows_of(points).splitlines()]
    head = "5\n5\n1 2 3\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 2 3 1\n"
    polar = "".join(f"{5 + k},{10 * k},{2 * k - 20}\n" for k in range(25))
    contents = (
        ("xyz", "plain", rows),
        ("xyz", "counted", f"25\n{rows}"),
        ("txt", "commented", f"# x y z\n{rows}"),
        ("csv", "named", "x,y,z\n" + rows_of(points, ",")),
        (
            "csv",
            "units",
            "id;X [m];Z [m];Y [m]\n" + "".join(f"a;{x:.3f};{z:.3f};{y:.3f}\n" for x, y, z in points),
        ),
        ("csv", "polar", "S,alpha,omega\n" + polar),
        ("pts", "plain", f"25\n{rows}"),
        ("pts", "two", "25\n" + "\n".join(inside) + "\n10\n" + "\n".join(inside[:10]) + "\n"),
        ("ptx", "plain", head + "\n".join(inside) + "\n"),
        ("ptx", "two", 2 * (head + "\n".join(line.rsplit(maxsplit=3)[0] for line in inside) + "\n")),
    )
    for suffix, name, text in contents:
        yield suffix, name, lambda path, text=text: path.write_text(text)


def _plys() -> Iterator[tuple[str, str, Callable[[Path], object]]]:
    points = wall_points(25)
    axes = "property {0} x\nproperty {0} y\nproperty {0} z\n"
    faces = "element face 2\nproperty list uchar int vertex_indices\n"
    text = f"ply\nformat ascii 1.0\ncomment a\nelement vertex 25\n{axes.format('double')}{faces}end_header\n"
    yield "ply", "text", lambda path: path.write_text(text + rows_of(points) + "3 0 1 2\n4 0 1 2 3\n")
    for order, name in (("<", "little"), (">", "big")):
        head = f"ply\nformat binary_{name}_endian 1.0\nelement vertex 25\n{axes.format('double')}{faces}end_header\n"
        tail = struct.pack(f"{order}B3iB4i", 3, 0, 1, 2, 4, 0, 1, 2, 3)
        body = head.encode() + points.astype(f"{order}f8").tobytes() + tail
        yield "ply", name, lambda path, body=body: path.write_bytes(body)
    lists = "ply\nformat binary_little_endian 1.0\nelement vertex 25\nproperty list uchar short n\n"
    records = b"".join(struct.pack("<Bh3f", 1, k, *point) for k, point in enumerate(points))
    body = f"{lists}{axes.format('float')}end_header\n".encode() + records
    yield "ply", "lists", lambda path, body=body: path.write_bytes(body)


def _pcds() -> Iterator[tuple[str, str, Callable[[Path], object]]]:
    points = wall_points(25)
    head = (
        "# .PCD v.7\nVERSION .7\nFIELDS x y z i\nSIZE {0} {0} {0} 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 5\nHEIGHT 5\n"
        "VIEWPOINT 1 2 3 1 0 0 0\nPOINTS 25\nDATA {1}\n"
    )
    lines = "".join(f"{line} 7\n" for line in rows_of(points).splitlines())
    yield "pcd", "text", lambda path: path.write_text(head.format(4, "ascii") + lines)
    records = b"".join(struct.pack("<3dI", *point, 7) for point in points)
    yield "pcd", "binary", lambda path: path.write_bytes(head.format(8, "binary").encode() + records)
    plain = points.T.astype("<f8").tobytes() + bytes(100)
    packed = b"".join(bytes([len(piece) - 1]) + piece for piece in _pieces(plain))
    body = head.format(8, "binary_compressed").encode() + struct.pack("<II", len(packed), len(plain)) + packed
    yield "pcd", "packed", lambda path: path.write_bytes(body)


def _pieces(content: bytes) -> Iterator[bytes]:
    """Content in runs as LZF stores what it cannot make shorter."""
    for start in range(0, len(content), 32):
        yield content[start : start + 32]


def _tables() -> Iterator[tuple[str, str, Callable[[Path], object]]]:
    points = wall_points(40)
    columns = {name: pa.array(values) for name, values in zip("xyz", points.T, strict=True)}
    kinds: Mapping[str, dict[str, object]] = {
        "plain": {"compression": "none", "use_dictionary": False},
        "snappy": {"row_group_size": 15},
        "zstd": {"compression": "zstd", "data_page_version": "2.0", "write_page_checksum": True},
    }
    for name, options in kinds.items():
        yield "parquet", name, lambda path, o=options: pq.write_table(pa.table(columns), path, **o)
