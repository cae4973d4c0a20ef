"""The points of the scans of an E57 file, decoded by libE57Format, which verifies the checksum of every page."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.e57_header import E57Field, E57Scan
from tasks.ingest.file_pose import place_points
from tasks.ingest.polar import cartesian_from_polar
from tasks.ingest.scan import FilePose
from tasks.ingest.third_party import decoding

if TYPE_CHECKING:
    from pye57.libe57 import ImageFile

PIECE_RECORDS: Final = 1_000_000
"""Decoded at a time: 32 MB."""

CARTESIAN: Final = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL: Final = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
STATES: Final = ("cartesianInvalidState", "sphericalInvalidState")

FEWEST_BITS: Final = 8
"""A record whose coordinates take fewer can stand for few places only; many of them are a trap for memory."""

FEW_POINTS: Final = 1_000_000

BULK: Final = 0.99
"""This share of the points decides on the step of floating point numbers; the rest may be stray."""

SAMPLE_OF_PIECE: Final = 2000
"""Enough for that quantile."""

ROUNDING_RAD: Final = 1e-5
"""What float32 and rounding may add to a right angle."""


@dataclass(frozen=True, slots=True)
class Layout:
    """The fields of a scan that are read: three coordinates, and the state that marks a record as empty."""

    coordinates: tuple[E57Field, E57Field, E57Field]
    state: E57Field | None
    is_spherical: bool


@dataclass(frozen=True, slots=True)
class ScanFigures:
    """What reading a scan told.

    ``n_invalid`` records are marked so; ``step`` is that of the coordinates in metres, None where all are float64;
    ``steepest_rad`` is the largest elevation, without sign, of spherical coordinates.
    """

    n_invalid: int
    step: float | None
    steepest_rad: float

    def notes(self, scan: E57Scan) -> tuple[str, ...]:
        """A note on angles that no elevation has."""
        if self.steepest_rad <= np.pi / 2.0 + ROUNDING_RAD:
            return ()
        return (
            f"{scan.place} states elevations up to {math.degrees(self.steepest_rad):.4g} degrees, the standard has them "
            "from -90 to 90: if they are zenith angles the points are wrong; export cartesian coordinates",
        )


def find_layout(path: Path, scan: E57Scan) -> Layout:
    """The fields to read; Cartesian ones where a scan has both kinds.

    Raises
    ------
    InputError
        If there are none, or they cannot tell so many points apart.
    """
    by_name = {field.name: field for field in scan.fields}
    for names, states in ((CARTESIAN, STATES), (SPHERICAL, STATES[::-1])):
        if all(name in by_name for name in names):
            first, second, third = (by_name[name] for name in names)
            state = next((by_name[name] for name in states if name in by_name), None)
            layout = Layout((first, second, third), state, names is SPHERICAL)
            break
    else:
        raise InputError(
            f"{path}: needs the fields {', '.join(CARTESIAN)} or {', '.join(SPHERICAL)}, came "
            f"{', '.join(list(by_name)[:20]) or 'none'} in {scan.place}; export the scan again with coordinates"
        )
    n_bits = sum(field.n_bits for field in layout.coordinates)
    if n_bits < FEWEST_BITS and scan.n_points > FEW_POINTS:
        raise InputError(
            f"{path}: needs coordinates that can tell {scan.n_points} points apart, came {n_bits} bits a point in "
            f"{scan.place}; the file is damaged, copy or export it again"
        )
    return layout


@contextmanager
def open_image(path: Path) -> Iterator["ImageFile"]:
    """The file as libE57Format sees it; what goes wrong inside becomes InputError.

    Raises
    ------
    InputError
        If the library cannot read what is asked of it.
    """
    with decoding(path):
        from pye57 import libe57  # noqa: PLC0415  # most runs read no E57, and the start must not pay for it

        try:
            image = libe57.ImageFile(str(path), "r")
            try:
                yield image
            finally:
                image.close()
        except libe57.E57Exception as error:
            # the rest of its text are places in its source
            reason = str(error).partition("\n")[0]
            raise InputError(
                f"{path}: needs points that can be decoded, came {reason}; "
                "the file is cut short or damaged, copy or export it again"
            ) from error


def fill_points(
    path: Path, image: "ImageFile", scan: E57Scan, pose: FilePose | None, values: NDArray[np.float64]
) -> ScanFigures:
    """Decode the points of a scan into values (n, 3), placed by ``pose`` where one is given.

    Records that the file marks as invalid become (0, 0, 0), as a beam without a return.

    Raises
    ------
    InputError
        If there are not as many as the file states, or they cannot be coordinates.
    """
    layout = find_layout(path, scan)
    samples: list[NDArray[np.float64]] = []
    done, n_invalid, steepest_rad = 0, 0, 0.0
    for piece in _pieces(path, image, scan, layout):
        target = values[done : done + len(piece)]
        if len(target) < len(piece):
            raise _other_count(path, scan, done + len(piece))
        target[:] = piece[:, :3]
        is_invalid = piece[:, 3] != 0.0
        target[is_invalid] = 0.0
        n_invalid += int(np.count_nonzero(is_invalid))
        samples.append(np.abs(target[:: max(1, len(target) // SAMPLE_OF_PIECE)]))
        if layout.is_spherical:
            steepest_rad = max(steepest_rad, float(np.abs(target[:, 2]).max()))
        _convert(path, scan, layout, pose, target)
        done += len(piece)
    if done != scan.n_points:
        raise _other_count(path, scan, done)
    return ScanFigures(n_invalid, _step(layout, np.concatenate(samples)), steepest_rad)


def _pieces(path: Path, image: "ImageFile", scan: E57Scan, layout: Layout) -> Iterator[NDArray[np.float64]]:
    """Records (n, 4) of a scan: the three coordinates as stored, and the state, 0 where there is none."""
    from pye57 import libe57  # noqa: PLC0415

    points = image.root()["data3D"][scan.number - 1]["points"]
    if points.childCount() != scan.n_points:
        raise _other_count(path, scan, points.childCount())
    columns = np.zeros((4, min(PIECE_RECORDS, scan.n_points)))
    names = [field.name for field in (*layout.coordinates, layout.state) if field is not None]
    buffers = libe57.VectorSourceDestBuffer()
    for name, column in zip(names, columns, strict=False):
        # integers become float64, scaled ones are scaled
        buffers.append(libe57.SourceDestBuffer(image, name, column, len(column), True, True))
    reader = points.reader(buffers)
    try:
        while n_read := reader.read():
            yield columns[:, :n_read].T
    finally:
        reader.close()


def _convert(
    path: Path, scan: E57Scan, layout: Layout, pose: FilePose | None, values: NDArray[np.float64]
) -> None:
    """Turn coordinates (n, 3) as stored into Cartesian ones, placed by ``pose`` where one is given, in place."""
    # infinities give NaN here, and the check for finite numbers then says so
    with np.errstate(over="ignore", invalid="ignore"):
        if layout.is_spherical:
            shortest = float(values[:, 0].min())
            if shortest < 0.0:
                raise InputError(
                    f"{path}: needs ranges of at least 0, came {shortest:g} in {scan.place}; "
                    "export the scan again with cartesian coordinates"
                )
            values[:, 1:] = np.degrees(values[:, 1:])
            values[:] = cartesian_from_polar(values)
        if pose is not None:
            place_points(pose, values)


def _step(layout: Layout, sample: NDArray[np.float64]) -> float | None:
    """Coarsest step of the coordinates, from the sizes (n, 3) of those stored."""
    largest = np.quantile(np.nan_to_num(sample, posinf=0.0), BULK, axis=0)
    steps = np.array(
        [
            np.spacing(np.float32(size)) if field.is_single else field.step
            for field, size in zip(layout.coordinates, largest, strict=True)
        ]
    )
    if layout.is_spherical:
        steps[1:] *= largest[0]
    step = float(steps.max())
    return step if step > 0.0 else None


def _other_count(path: Path, scan: E57Scan, n_found: int) -> InputError:
    return InputError(
        f"{path}: needs the {scan.n_points} points that the file states of {scan.place}, came {n_found}; "
        "the file is cut short or damaged, copy or export it again"
    )
