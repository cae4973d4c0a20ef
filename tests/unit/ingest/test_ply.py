"""PLY: text and binary, lists and none, vertices first or last."""

import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import plyfile
import pytest
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tests.shared import SHARED, needs_shared
from tests.unit.ingest.clouds import wall_points, write_text

PDAL = SHARED / "data" / "formats" / "pdal"
TRIANGLES = [[0, 1, 2]] * 9
POLYGONS = [[0, 1, 2], [3, 4, 5, 6], [], [7, 8, 9]]
ENCODINGS = ("text", "<", ">")
HEAD = "ply\nformat {} 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\nend_header\n"


def table(name: str, columns: dict[str, NDArray[np.generic] | Sequence[Sequence[int]]]) -> plyfile.PlyElement:
    """An element whose columns are numbers or lists."""
    n = len(next(iter(columns.values())))
    kinds = [(key, v.dtype.str if isinstance(v, np.ndarray) else "O") for key, v in columns.items()]
    rows = np.empty(n, kinds)
    for key, values in columns.items():
        if isinstance(values, np.ndarray):
            rows[key] = values
        else:
            for index, value in enumerate(values):
                rows[key][index] = np.array(value, "i4")
    lists = [key for key, values in columns.items() if not isinstance(values, np.ndarray)]
    return plyfile.PlyElement.describe(rows, name, val_types=dict.fromkeys(lists, "i4"))


def vertices(points_m: NDArray[np.float64], kind: str = "f8") -> dict[str, NDArray[np.generic]]:
    x, y, z = points_m.astype(kind).T
    return {"red": np.arange(len(points_m)).astype("u1"), "z": z, "x": x, "intensity": x.astype("f4"), "y": y}


def write_ply(path: Path, *elements: plyfile.PlyElement, encoding: str = "<") -> Path:
    is_text = encoding == "text"
    plyfile.PlyData(
        elements,
        text=is_text,
        byte_order="=" if is_text else encoding,
        comments=["made here"],
        obj_info=["x y"],
    ).write(path)
    return path


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_columns_are_found_by_name_in_every_encoding(tmp_path: Path, encoding: str) -> None:
    points_m = wall_points(200)
    path = write_ply(tmp_path / "a.ply", table("vertex", vertices(points_m)), encoding=encoding)
    scan = read_scan(path)
    assert np.array_equal(scan.points_m, points_m)
    assert (scan.n_in_file, scan.notes, scan.pose) == (200, (), None)
    assert describe_scan(path).n_points == 200


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("lists", [TRIANGLES, POLYGONS], ids=["triangles", "polygons"])
def test_elements_around_the_vertices_are_passed_over(
    tmp_path: Path, encoding: str, lists: list[list[int]]
) -> None:
    points_m = wall_points(30)

    def around(place: str) -> list[plyfile.PlyElement]:
        return [
            table(f"face_{place}", {"flag": np.zeros(len(lists), "u1"), "vertex_indices": lists}),
            table(f"camera_{place}", {"x": np.arange(3.0), "k": np.arange(3, dtype="i2")}),
        ]

    points = table("vertex", vertices(points_m))
    path = write_ply(tmp_path / "a.ply", *around("before"), points, *around("after"), encoding=encoding)
    assert np.array_equal(read_scan(path).points_m, points_m)


def record(order: str, point_m: NDArray[np.float64], seen: list[int]) -> bytes:
    """A vertex with a list before y; by hand, for plyfile 1.1.5 writes those of big endian wrongly."""
    x, y, z = point_m
    if order == "text":
        return " ".join(str(value) for value in (x, len(seen), *seen, y, z)).encode() + b"\n"
    return struct.pack(f"{order}dB{len(seen)}idd", x, len(seen), *seen, y, z)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("regular", [True, False])
def test_lists_among_the_coordinates_do_not_shift_them(
    tmp_path: Path, encoding: str, regular: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tasks.ingest.ply_lists.PIECE", 7)
    points_m = wall_points(25)
    name = {"text": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[encoding]
    head = HEAD.format(name, 25).replace("double x\n", "double x\nproperty list uchar int seen\n")
    rows = [
        record(encoding, point_m, [9] * (2 if regular else index % 4))
        for index, point_m in enumerate(points_m)
    ]
    (tmp_path / "a.ply").write_bytes(head.encode() + b"".join(rows))
    assert np.array_equal(read_scan(tmp_path / "a.ply").points_m, points_m)


@pytest.mark.parametrize("encoding", ["<", ">"])
def test_pieces_join_without_a_seam(tmp_path: Path, encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.ingest.binary_records.PIECE_BYTES", 1000)
    points_m = wall_points(500)
    path = write_ply(tmp_path / "a.ply", table("vertex", vertices(points_m)), encoding=encoding)
    assert np.array_equal(read_scan(path).points_m, points_m)


def test_single_precision_far_from_the_origin_is_refused_by_its_step(tmp_path: Path) -> None:
    points_m = wall_points(10) + np.array([500_000.0, 4_400_000.0, 0.0])
    path = write_ply(tmp_path / "a.ply", table("vertex", vertices(points_m, "f4")))
    with pytest.raises(InputError, match="needs coordinates finer than 50 mm, came steps of 500 mm"):
        read_scan(path)


def test_single_precision_near_the_origin_is_read_without_a_note(tmp_path: Path) -> None:
    points_m = wall_points(10)
    scan = read_scan(write_ply(tmp_path / "a.ply", table("vertex", vertices(points_m, "f4"))))
    # single precision has 24 bits: 2e-6 m at 50 m
    assert scan.points_m == pytest.approx(points_m, abs=2e-6)
    assert scan.notes == ()


def test_whole_numbers_are_no_coordinates_in_metres(tmp_path: Path) -> None:
    path = write_ply(tmp_path / "a.ply", table("vertex", vertices(wall_points(10) * 1000.0, "i4")))
    with pytest.raises(InputError, match="came steps of 1e\\+03 mm"):
        read_scan(path)


def test_nan_counts_as_a_beam_without_return(tmp_path: Path) -> None:
    points_m = wall_points(10)
    points_m[[2, 5]] = np.nan
    scan = read_scan(write_ply(tmp_path / "a.ply", table("vertex", vertices(points_m))))
    assert np.array_equal(scan.points_m, np.delete(points_m, [2, 5], axis=0))
    assert scan.n_in_file == 10
    assert scan.notes[0] == "2 of 10 records are NaN, which is taken as (0, 0, 0)"


def test_a_point_that_is_nan_in_one_coordinate_is_refused(tmp_path: Path) -> None:
    points_m = wall_points(10)
    points_m[4, 1] = np.nan
    with pytest.raises(InputError, match="needs finite coordinates, came 1 of 10 points"):
        read_scan(write_ply(tmp_path / "a.ply", table("vertex", vertices(points_m))))


def test_polar_columns_are_found_by_name(tmp_path: Path) -> None:
    polar = {"S": np.array([10.0, 20.0]), "alpha": np.array([0.0, 90.0]), "omega": np.array([0.0, 30.0])}
    path = write_ply(tmp_path / "a.ply", table("vertex", polar))
    scan = read_scan(path, ScanRequest(coordinates="polar"))
    assert np.linalg.norm(scan.points_m, axis=1) == pytest.approx([10.0, 20.0])
    with pytest.raises(InputError, match="needs one column 'x', came 0 among S, alpha, omega"):
        read_scan(path)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("lists", [None, TRIANGLES, POLYGONS], ids=["vertices", "triangles", "polygons"])
@pytest.mark.parametrize("left", [-3, 0.9, 0.5, 0.1])
def test_a_file_cut_short_is_refused(
    tmp_path: Path, encoding: str, lists: list[list[int]] | None, left: float
) -> None:
    elements = [table("vertex", vertices(wall_points(20)))]
    if lists is not None:
        elements.append(table("face", {"vertex_indices": lists, "flag": np.full(len(lists), 7, "u1")}))
    path = write_ply(tmp_path / "a.ply", *elements, encoding=encoding)
    content = path.read_bytes()
    path.write_bytes(content[: int(left) if left < 0 else int(len(content) * left)])
    if encoding == "text" and left == -3:
        # within the last number: the points are whole, or may be whole
        scan = read_scan(path)
        assert len(scan.points_m) == 20
        assert (lists is None) == any("cut short" in note for note in scan.notes)
    else:
        with pytest.raises(InputError, match=r"cut short"):
            read_scan(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "does not begin with the line 'ply'"),
        ("solid\n", "does not begin with the line 'ply'"),
        ("ply\nformat ascii 1.0\n", "needs a header that ends with 'end_header', came none"),
        ("ply\nend_header\n", "needs a line 'format' of .*, came 'none'"),
        (HEAD.format("ascii_", 1), "came 'format ascii_ 1.0'"),
        (HEAD.format("ascii", 0), "came a file that holds no points"),
        (HEAD.format("ascii", -1), "came 'element vertex -1' in line 3"),
        (HEAD.format("ascii", 10**25), "came 'element vertex 1000"),
        (HEAD.format("ascii", 3) + "1 2 3\n4 5 6\n", "needs the 3 points that its header states, came 2"),
        (
            HEAD.format("ascii", 1) + "1 2 3\n4 5 6\n",
            r"came '4 5 6' after them, from line 9 on; the count is wrong",
        ),
        (HEAD.format("ascii", 10**15) + "1 2 3\n", "needs the 1000000000000000 points .*, came 1"),
        (
            HEAD.format("ascii", 2) + "1 2 3\n4 5\n",
            "needs 3 columns in the 2 rows .*, came 2 in line 9 '4 5'",
        ),
        (HEAD.format("ascii", 2) + "1 2 3\n4 b 6\n", "needs numbers, came 'b' in line 9"),
        (
            HEAD.format("binary_little_endian", 10**15) + "1" * 60,
            "needs the 1000000000000000 points of 24 bytes .* came 2",
        ),
        (
            HEAD.format("binary_big_endian", 2) + "1" * 72,
            "came 24 bytes behind the last record; the count is wrong",
        ),
        (HEAD.format("ascii", 1).replace("double x", "quad x"), "came 'property quad x' in line 4"),
        (HEAD.format("ascii", 1).replace("double z", "list uchar int z"), "came a list"),
        (HEAD.format("ascii", 1).replace("double z", "double y"), "needs one column 'y', came 2"),
        (
            HEAD.format("ascii", 1).replace("vertex", "point"),
            "needs one element 'vertex', came 0 among point",
        ),
    ],
)
def test_a_bad_file_says_what(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=r"a\.ply: .*" + message):
        read_scan(write_text(tmp_path / "a.ply", text))


@pytest.mark.parametrize("length", [b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff"])
@pytest.mark.parametrize("kind", ["int", "uint"])
def test_a_list_that_lies_about_its_length_is_refused(tmp_path: Path, length: bytes, kind: str) -> None:
    head = (
        "ply\nformat binary_little_endian 1.0\nelement face 2\n"
        f"property list {kind} double vertex_indices\nelement vertex 1\n"
        "property float x\nproperty float y\nproperty float z\nend_header\n"
    )
    (tmp_path / "a.ply").write_bytes(head.encode() + length * 2 + bytes(12))
    with pytest.raises(InputError, match=r"cut short|came one of -1"):
        read_scan(tmp_path / "a.ply")


def test_a_part_that_is_not_there_is_refused(tmp_path: Path) -> None:
    path = write_ply(tmp_path / "a.ply", table("vertex", vertices(wall_points(5))))
    assert len(read_scan(path, ScanRequest(part=1)).points_m) == 5
    with pytest.raises(InputError, match="needs part = 'north', came a file of one scan"):
        read_scan(path, ScanRequest(part="north"))


@needs_shared
@pytest.mark.parametrize(
    ("name", "points_m"),
    [
        ("simple_text.ply", [[-1, 0, 0], [0, 1, 0], [1, 0, 0]]),
        ("simple_binary.ply", [[-1, 0, 0], [0, 1, 0], [1, 0, 0]]),
        ("mesh.ply", [[1, 1, 0], [2, 1, 0], [1, 2, 0], [2, 2, 2]]),
        ("mesh_fixed.ply", [[1, 1, 0], [2, 1, 0], [1, 2, 0], [2, 2, 2]]),
        ("text_extradim.ply", [[-2.64944, -13.0955, 0.00640115]]),
    ],
)
def test_files_of_other_programs_are_read_whole(name: str, points_m: list[list[float]]) -> None:
    scan = read_scan(PDAL / name)
    assert scan.points_m.tolist() == points_m
    assert scan.notes == ()


@needs_shared
@pytest.mark.parametrize("name", ["sized_dims.ply", "unsized_dims.ply"])
def test_vertices_without_heights_are_no_points(name: str) -> None:
    with pytest.raises(InputError, match="needs one column 'z', came 0 among"):
        read_scan(PDAL / name)


@needs_shared
def test_a_header_without_elements_is_told() -> None:
    with pytest.raises(InputError, match="needs one element 'vertex', came 0 among no elements"):
        read_scan(SHARED / "data" / "malformed" / "pdal" / "no_vertex.ply")
