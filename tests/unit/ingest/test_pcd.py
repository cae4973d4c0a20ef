"""PCD: text, binary, compressed; viewpoints."""

import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tasks.ingest.lzf import decompress_lzf
from tasks.open3d_import import import_open3d
from tests.shared import SHARED, needs_shared
from tests.unit.ingest.clouds import rows_of, wall_points, write_text

FILE = ScanRequest(frame="file")
ENCODINGS = ("ascii", "binary", "binary_compressed")
IDENTITY = "0 0 0 1 0 0 0"


def header_of(n_points: int, changes: Mapping[str, str | None] | None = None) -> str:
    """A header of x, y, z in double precision; None takes a line out."""
    lines: dict[str, str | None] = {
        "VERSION": "0.7",
        "FIELDS": "x y z",
        "SIZE": "8 8 8",
        "TYPE": "F F F",
        "COUNT": "1 1 1",
        "WIDTH": str(n_points),
        "HEIGHT": "1",
        "VIEWPOINT": IDENTITY,
        "POINTS": str(n_points),
        "DATA": "ascii",
    }
    lines.update(changes or {})
    head = "".join(f"{key} {value}\n" for key, value in lines.items() if value is not None)
    return "# .PCD v0.7 - Point Cloud Data file format\n" + head


def literals(content: bytes) -> bytes:
    """LZF without any repetition: valid, and as small as a packer can be."""
    runs = [content[at : at + 32] for at in range(0, len(content), 32)]
    return b"".join(bytes([len(run) - 1]) + run for run in runs)


def write_pcd(
    path: Path, columns: Mapping[str, NDArray[np.generic]], encoding: str, viewpoint: str = IDENTITY
) -> Path:
    """Columns (n,) or (n, COUNT) by field name."""
    blocks = [np.atleast_2d(values.T).T for values in columns.values()]
    rows = np.empty(len(blocks[0]), [(f"f{i}", b.dtype, b.shape[1:]) for i, b in enumerate(blocks)])
    for index, block in enumerate(blocks):
        rows[f"f{index}"] = block
    changes = {
        "FIELDS": " ".join(columns),
        "SIZE": " ".join(str(block.dtype.itemsize) for block in blocks),
        "TYPE": " ".join(block.dtype.kind.upper() for block in blocks),
        "COUNT": " ".join(str(block.shape[1]) for block in blocks),
        "VIEWPOINT": viewpoint,
        "DATA": encoding,
    }
    if encoding == "ascii":
        body = "".join(
            " ".join(str(value) for value in np.hstack(row)) + "\n" for row in zip(*blocks, strict=True)
        ).encode()
    elif encoding == "binary":
        body = rows.tobytes()
    else:
        planes = b"".join(block.tobytes() for block in blocks)
        packed = literals(planes)
        body = struct.pack("<II", len(packed), len(planes)) + packed
    path.write_bytes(header_of(len(rows), changes).encode() + body)
    return path


def xyz(points_m: NDArray[np.float64], kind: str = "f8") -> dict[str, NDArray[np.generic]]:
    return dict(zip("xyz", points_m.astype(kind).T, strict=True))


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_columns_are_found_by_name_in_every_encoding(tmp_path: Path, encoding: str) -> None:
    points_m = wall_points(200)
    x, y, z = points_m.T
    columns = {
        "ring": np.arange(200, dtype="u2"),
        "Z": z,
        "histogram": np.arange(600, dtype="f4").reshape(200, 3),
        "X": x,
        "_": np.zeros((200, 2), "u1"),
        "Y": y,
    }
    path = write_pcd(tmp_path / "a.pcd", columns, encoding)
    scan = read_scan(path, FILE)
    assert np.array_equal(scan.points_m, points_m)
    assert (scan.n_in_file, scan.notes, scan.pose) == (200, (), None)
    header = describe_scan(path)
    assert (header.n_points, header.format) == (200, f"PCD 0.7 ({encoding})")


@pytest.mark.parametrize("compressed", [True, False])
def test_what_open3d_writes_is_read(tmp_path: Path, compressed: bool) -> None:
    o3d = import_open3d()
    # equal coordinates make long and overlapping repetitions
    points_m = np.vstack((wall_points(3000), np.tile([1.5, 2.5, 3.5], (500, 1)), np.zeros((100, 3)) + 7.0))
    cloud = o3d.t.geometry.PointCloud(o3d.core.Tensor(points_m))
    path = tmp_path / "a.pcd"
    o3d.t.io.write_point_cloud(str(path), cloud, write_ascii=False, compressed=compressed)
    assert (b"binary_compressed" in path.read_bytes()[:400]) == compressed
    assert np.array_equal(read_scan(path).points_m, points_m)


@pytest.mark.parametrize(
    ("packed", "unpacked"),
    [
        (b"\x02abc", b"abc"),
        (b"\x02abc\x20\x02", b"abcabc"),
        (b"\x00a\xe0\x05\x00", b"a" * 15),
        (b"\x01ab\x60\x01", b"ab" + b"ababa"),
    ],
)
def test_lzf_repeats_what_was_there_before(packed: bytes, unpacked: bytes) -> None:
    assert decompress_lzf(packed, len(unpacked)) == unpacked


@pytest.mark.parametrize(
    ("packed", "n_bytes", "message"),
    [
        (b"\x02ab", 3, "unpack to 2 bytes instead of 3"),
        (b"\x02abc", 2, "unpack to 3 bytes instead of 2"),
        (b"\x02abc", 4, "unpack to 3 bytes instead of 4"),
        (b"\x20\x00", 3, "refer to bytes before the first"),
        (b"\x00a\x20\x01", 4, "refer to bytes before the first"),
        (b"\x00a\xe0", 9, "end within a step"),
        (b"\x00a\xe0\x05", 9, "end within a step"),
    ],
)
def test_damaged_lzf_is_refused(packed: bytes, n_bytes: int, message: str) -> None:
    with pytest.raises(InputError, match=message):
        decompress_lzf(packed, n_bytes)


def test_damage_in_compressed_points_names_the_file(tmp_path: Path) -> None:
    path = write_pcd(tmp_path / "a.pcd", xyz(wall_points(50)), "binary_compressed")
    content = bytearray(path.read_bytes())
    content[content.index(b"compressed\n") + 19] = 3
    path.write_bytes(content)
    with pytest.raises(
        InputError, match=r"a\.pcd: needs 50 points, came compressed points that .*; the file is damaged"
    ):
        read_scan(path)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("left", [0.99, 0.5, 0.1])
def test_a_file_cut_short_is_refused(tmp_path: Path, encoding: str, left: float) -> None:
    path = write_pcd(tmp_path / "a.pcd", xyz(wall_points(200)), encoding)
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * left)])
    with pytest.raises(InputError, match=r"cut short|needs the header"):
        read_scan(path)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_nan_counts_as_a_beam_without_return(tmp_path: Path, encoding: str) -> None:
    points_m = wall_points(10)
    points_m[[2, 5]] = np.nan
    scan = read_scan(write_pcd(tmp_path / "a.pcd", xyz(points_m), encoding))
    assert np.array_equal(scan.points_m, np.delete(points_m, [2, 5], axis=0))
    assert (scan.n_in_file, scan.notes[0]) == (10, "2 of 10 records are NaN, which is taken as (0, 0, 0)")


def test_nothing_but_nan_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="needs points, came 4 records that are all NaN"):
        read_scan(write_pcd(tmp_path / "a.pcd", xyz(np.full((4, 3), np.nan)), "binary"))


@pytest.mark.parametrize("encoding", ["binary", "binary_compressed"])
def test_single_precision_far_from_the_origin_is_refused_by_its_step(tmp_path: Path, encoding: str) -> None:
    points_m = wall_points(10) + np.array([500_000.0, 4_400_000.0, 0.0])
    with pytest.raises(InputError, match="needs coordinates finer than 50 mm, came steps of 500 mm"):
        read_scan(write_pcd(tmp_path / "a.pcd", xyz(points_m, "f4"), encoding))


QUARTER = "100 200 5 0.70710678 0 0 0.70710678"


def test_a_viewpoint_is_the_pose_of_a_scan_whose_points_stay(tmp_path: Path) -> None:
    points_m = wall_points(10)
    scan = read_scan(write_pcd(tmp_path / "a.pcd", xyz(points_m), "binary", QUARTER))
    assert np.array_equal(scan.points_m, points_m)
    assert scan.pose is not None
    # a quarter turn about z takes east to north
    assert scan.pose.rotation @ np.array([1.0, 0.0, 0.0]) == pytest.approx([0.0, 1.0, 0.0], abs=1e-8)
    assert scan.pose.translation.tolist() == [100.0, 200.0, 5.0]
    assert any("VIEWPOINT is taken as the scanner's pose" in note for note in scan.notes)


@pytest.mark.parametrize("ask", [read_scan, describe_scan])
def test_a_viewpoint_of_a_cloud_in_the_frame_of_the_file_is_refused(tmp_path: Path, ask: object) -> None:
    path = write_pcd(tmp_path / "a.pcd", xyz(wall_points(10)), "binary", QUARTER)
    with pytest.raises(InputError, match="needs points in one stated frame, came a VIEWPOINT other than"):
        ask(path, FILE)  # type: ignore[operator]


def test_polar_fields_are_found_by_name(tmp_path: Path) -> None:
    polar = {"s": np.array([10.0, 20.0]), "alpha": np.array([0.0, 90.0]), "omega": np.array([0.0, 30.0])}
    path = write_pcd(tmp_path / "a.pcd", polar, "binary")
    scan = read_scan(path, ScanRequest(coordinates="polar"))
    assert np.linalg.norm(scan.points_m, axis=1) == pytest.approx([10.0, 20.0])


BODY = rows_of(wall_points(4))


@pytest.mark.parametrize(
    ("changes", "body"),
    [
        ({"VERSION": ".6"}, BODY),
        ({"COUNT": None, "HEIGHT": None, "VIEWPOINT": None, "POINTS": None}, BODY),
        ({"WIDTH": "2", "HEIGHT": "2"}, BODY),
        ({}, BODY.replace(" ", ",")),
        ({}, BODY.replace(" ", "\t").replace("\n", "\r\n")),
        ({"FIELDS": "x y z\n# a comment\n"}, BODY + "\n\n"),
    ],
)
def test_every_common_header_gives_the_same_points(
    tmp_path: Path, changes: Mapping[str, str | None], body: str
) -> None:
    scan = read_scan(write_text(tmp_path / "a.pcd", header_of(4, changes) + body))
    # four decimals as written
    assert scan.points_m == pytest.approx(wall_points(4), abs=1e-9)
    assert scan.notes == ()


@pytest.mark.parametrize(
    ("changes", "body", "message"),
    [
        ({"VERSION": "0.5"}, BODY, r"needs PCD of version 0\.6 or 0\.7, came '0\.5'"),
        ({"FIELDS": "x y i"}, BODY, "needs one column 'z', came 0 among x, y, i"),
        ({"FIELDS": "x y"}, BODY, "needs as many SIZE, TYPE and COUNT as FIELDS, came 3, 3, 3 for 2"),
        ({"FIELDS": None}, BODY, "needs FIELDS in its header, came none"),
        ({"SIZE": "8 8 2"}, BODY, "came TYPE F, SIZE 2 in field 'z'"),
        ({"COUNT": "1 1 2"}, BODY, "needs COUNT 1 for each coordinate"),
        ({"COUNT": "1 1 0"}, BODY, "a COUNT from 1"),
        ({"WIDTH": "5"}, BODY, r"needs POINTS = WIDTH \* HEIGHT, came WIDTH 5, HEIGHT 1, POINTS 4"),
        ({"WIDTH": "0", "POINTS": "0"}, "", "came a file that holds no points"),
        ({"WIDTH": "-4"}, BODY, r"needs POINTS = WIDTH \* HEIGHT"),
        ({"VIEWPOINT": "0 0 0 0 0 0 0"}, BODY, "came norm 0 in VIEWPOINT"),
        ({"VIEWPOINT": "0 0 0 1e300 0 0 0"}, BODY, r"came norm 1e\+300 in VIEWPOINT"),
        ({"VIEWPOINT": "0 0 0 1 0 0"}, BODY, "needs seven numbers in VIEWPOINT, came 6"),
        ({"VIEWPOINT": "nan 0 0 1 0 0 0"}, BODY, "needs a finite pose"),
        ({"DATA": "zip"}, BODY, "needs DATA ascii, binary, binary_compressed, came 'zip'"),
        ({"WIDTH": "5", "POINTS": "5"}, BODY, "needs the 5 points that its header states, came 4"),
        ({"WIDTH": "3", "POINTS": "3"}, BODY, r"after them, from line 15 on; the count is wrong"),
        ({"WIDTH": "4000000000", "POINTS": "4000000000"}, BODY, "needs the 4000000000 points .*, came 4"),
        ({}, BODY.replace(" ", " 1 ", 1), "needs 3 columns in the 4 rows .*, came 4 in line 12"),
        (
            {"DATA": "binary", "WIDTH": "4000000000", "POINTS": "4000000000"},
            "a" * 50,
            "points of 24 bytes .*, came 2",
        ),
        (
            {"DATA": "binary", "COUNT": "1 1 1", "WIDTH": "1", "POINTS": "1"},
            "a" * 50,
            "came 26 bytes behind them",
        ),
        ({"DATA": "binary_compressed"}, "", "came 0 bytes of them; the file is cut short"),
        ({"DATA": "binary_compressed"}, "\0\0\0\0`\0\0\0", "unpack to 0 bytes instead of 96"),
        (
            {"DATA": "binary_compressed"},
            "\0\0\0\1`\0\0\0",
            "needs 16777216 bytes of compressed points, came 0",
        ),
    ],
)
def test_a_bad_file_says_what(
    tmp_path: Path, changes: Mapping[str, str | None], body: str, message: str
) -> None:
    with pytest.raises(InputError, match=r"a\.pcd: .*" + message):
        read_scan(write_text(tmp_path / "a.pcd", header_of(4, changes) + body))


@pytest.mark.parametrize("content", [b"", b"\n", bytes(range(256)) * 300, b"VERSION 0.7\n" * 3, b"#\n" * 500])
def test_what_is_no_pcd_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.pcd").write_bytes(content)
    with pytest.raises(
        InputError, match=r"needs the header|needs lines of text|needs one line VERSION|needs a header"
    ):
        read_scan(tmp_path / "a.pcd")


@needs_shared
def test_three_separators_give_the_same_points() -> None:
    folder = SHARED / "data" / "formats" / "pdal"
    comma, space, tab = (read_scan(folder / f"utm17_{name}.pcd") for name in ("comma", "space", "tab"))
    assert np.array_equal(comma.points_m, space.points_m)
    assert np.array_equal(comma.points_m, tab.points_m)
    # not rounded to the single precision that its header declares
    assert comma.points_m[0].tolist() == [289814.15, 4320978.61, 170.76]


@needs_shared
def test_a_binary_file_of_another_program_is_read_whole() -> None:
    scan = read_scan(SHARED / "data" / "formats" / "pdal" / "autzen-utm.pcd")
    assert len(scan.points_m) == 1065
    # the same points as those of the text of 1065 rows, in another system: the heights are in metres there, feet here
    feet = read_scan(SHARED / "data" / "formats" / "pdal" / "1.2-with-color.las").points_m[:, 2]
    assert scan.points_m[:, 2] == pytest.approx(feet * 0.3048, abs=0.01)


@needs_shared
def test_a_real_pole_is_read_whole_and_its_grid_told() -> None:
    path = SHARED / "data" / "pole" / "lamppost.pcd"
    scan = read_scan(path)
    assert np.array_equal(scan.points_m, np.loadtxt(path, skiprows=11))
    assert scan.notes == ("coordinates come in steps of 31.2 mm: export with a scale factor of 0.0001",)


@needs_shared
def test_points_without_a_header_are_told_to_be_renamed() -> None:
    with pytest.raises(
        InputError, match=r"came '289814\.15 4320978\.61 170\.76' in line 1; .* rename .* to \.xyz"
    ):
        read_scan(SHARED / "data" / "malformed" / "pdal" / "missingheader.pcd")
