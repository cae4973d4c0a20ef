"""The sidecar of a scan that comes through an inbox: its table of [[epochs.stations]], with the epoch and its time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Final

from pydantic import AfterValidator, Field, ValidationError

from tasks.settings.epochs import EpochTime, ScanPath, SetUp
from tasks.settings.problems import Problem, nearest, problems_of
from tasks.settings.section import SafeId, problem
from tasks.settings.toml_file import SIDECAR, input_error, read_toml

SUFFIX: Final = ".toml"

Sha256 = Annotated[str, Field(pattern=r"^[0-9a-fA-F]{64}$"), AfterValidator(str.lower)]
"""SHA-256 in hex."""


def _each_once(names: tuple[str, ...]) -> tuple[str, ...]:
    if len({name.casefold() for name in names}) < len(names):
        raise problem("names a station twice", "name each station of the epoch once")
    return names


StationIds = Annotated[tuple[SafeId, ...], Field(strict=False, min_length=1), AfterValidator(_each_once)]
"""Ids of the stations of an epoch."""


class Sidecar(SetUp):
    """What a scan says of itself when it comes through an inbox."""

    epoch: SafeId = Field(description="epoch that the station belongs to")
    time: EpochTime = Field(
        description="time of measuring of the epoch, with its offset; the same in all sidecars"
    )
    id: SafeId | None = Field(
        default=None, description="name of the station; that of the scan's file where it is missing"
    )
    scan: ScanPath | None = Field(
        default=None,
        description="name of the scan's file; need not be written, and must be right where it is",
    )
    of: StationIds | None = Field(
        default=None,
        description="ids of all stations of the epoch: when the last of them is there, the epoch is processed",
    )
    sha256: Sha256 | None = Field(
        default=None, description="SHA-256 of the scan's file in hex; checked if written"
    )
    size_bytes: int | None = Field(
        default=None, ge=0, description="size of the scan's file; checked if written [byte]"
    )


def load_sidecar(path: Path, scan: str) -> Sidecar:
    """Read the sidecar of a scan, the name of whose file is given.

    Raises
    ------
    InputError
        One line for every problem, each ``FILE: where: what; hint``.
    """
    raw = read_toml(path, SIDECAR)
    try:
        sidecar = Sidecar.model_validate({"id": Path(scan).stem, **raw})
    except ValidationError as error:
        raise input_error(path, list(problems_of(error, raw, Sidecar))) from error
    problems = list(_problems(sidecar, scan))
    if problems:
        raise input_error(path, problems)
    return sidecar


def station_of(sidecar: Sidecar, scan: str) -> dict[str, object]:
    """The table of [[epochs.stations]] that a sidecar stands for, with the scan's path; what it leaves out is not in it."""
    stated = sidecar.model_dump(
        exclude={"epoch", "time", "of", "sha256", "size_bytes"}, exclude_none=True, exclude_unset=True
    )
    return {"id": sidecar.id, **stated, "scan": scan}


def _problems(sidecar: Sidecar, scan: str) -> Iterator[Problem]:
    if sidecar.scan is not None and sidecar.scan != scan:
        yield Problem("scan", f"names {sidecar.scan!r}, the file beside it is {scan!r}", "drop the key")
    if sidecar.of is not None and sidecar.id is not None and sidecar.id not in sidecar.of:
        yield Problem("of", f"lists no station {sidecar.id!r}", nearest(sidecar.id, sidecar.of))
