"""Judge a case: what was accepted must be what stands in the file, and all ways to ask must agree."""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError, StorageError, UsageError
from tasks.ingest import ScanRequest, describe_scan, read_scan, stream_scan
from tasks.settings import load_campaign
from tasks.settings.limit_file import load_limits
from tasks.settings.sidecar import load_sidecar, station_of
from tasks.settings.toml_text import toml_text
from tests.faults.fuzzing import independent_binary, independent_text
from tests.faults.fuzzing.cases import Case
from tests.faults.fuzzing.independent_text import Unsure

Outcome = Literal["refused", "same", "as it says", "told", "undecidable", "finding"]
FOOT_M = {"metre": 1.0, "foot": 0.3048, "US survey foot": 1200.0 / 3937.0}
REFUSALS = (InputError, StorageError, UsageError)
RELATIVE = 1e-9
POSED = 1e-4
"""A matrix of five decimals is freed from its rounding by the product and not by the independent reader."""

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a case; ``why`` is the refusal, or what is wrong."""

    outcome: Outcome
    why: str = ""


@dataclass(frozen=True, slots=True)
class _Read:
    """What reading gave: points and notes, or a refusal."""

    points_m: Points | None
    notes: frozenset[str]
    refusal: str
    n_in_file: int = 0


def judge(case: Case, folder: Path) -> Verdict:
    """Write the file of a case and ask for it in all ways."""
    path = folder / f"case{case.seed.suffix}"
    path.unlink(missing_ok=True)
    path.write_bytes(case.content)
    return _judge_settings(case, path) if case.is_settings else _judge_scan(case, path)


def _read(path: Path, request: ScanRequest) -> _Read:
    try:
        scan = read_scan(path, request)
    except REFUSALS as error:
        return _Read(None, frozenset(), _short(error, path))
    return _Read(scan.points_m, frozenset(scan.notes), "", scan.n_in_file)


def _short(error: Exception, path: Path) -> str:
    return str(error).replace(str(path), "FILE")[:300]


def _judge_scan(case: Case, path: Path) -> Verdict:
    try:
        described: int | str | None = describe_scan(path, case.request).n_points
    except REFUSALS as error:
        described = _short(error, path)
    found = _read(path, case.request)
    if fault := _disagreement(case, path, described, found):
        return Verdict("finding", fault)
    if found.points_m is None:
        is_large = "more memory than this machine" in found.refusal
        return Verdict("finding" if is_large else "refused", found.refusal)
    if not np.isfinite(found.points_m).all() or len(found.points_m) == 0:
        return Verdict("finding", "points that are none were accepted")
    return _judge_points(case, found)


def _disagreement(case: Case, path: Path, described: int | str | None, found: _Read) -> str:
    """What the three ways to ask say differently."""
    if isinstance(described, str) and found.points_m is not None:
        return f"described as bad, but read: {described}"
    if isinstance(described, int) and found.points_m is not None and described != found.n_in_file:
        return f"described as {described} points, read {found.n_in_file}"
    try:
        stream = stream_scan(path, case.request)
        facts: list[object] = []
        # what is scaled beyond float64 is refused after the last piece
        with np.errstate(over="ignore", invalid="ignore"):
            pieces = [
                piece.copy() if stream.grid is None else stream.grid.metres(piece)
                for piece in stream.pieces(facts.append)
            ]
    except REFUSALS as error:
        return "" if found.points_m is None else f"read, but not in pieces: {_short(error, path)}"
    if found.points_m is None:
        return f"refused, but read in pieces: {found.refusal}"
    return "" if np.array_equal(np.concatenate(pieces), found.points_m) else "other points in pieces"


def _judge_points(case: Case, found: _Read) -> Verdict:
    assert found.points_m is not None
    before = _baseline(case)
    if before.points_m is not None and _agree(found.points_m, before.points_m, RELATIVE):
        return Verdict("same")
    if found.notes - before.notes:
        return Verdict("told")
    return _held_against(case, found.points_m)


def _held_against(case: Case, points_m: Points) -> Verdict:
    """Compare points (n, 3) that were accepted without a word with what an independent reader makes of the file."""
    try:
        with np.errstate(all="ignore"):
            said = _as_asked(case, _independent(case))
    except Unsure:
        said = None
    except Exception as error:
        return Verdict(
            "finding", f"accepted, but an independent reader refuses it: {type(error).__name__} {error}"[:300]
        )
    if said is None:
        return Verdict("undecidable")
    tolerance = POSED if case.request.frame == "file" and case.family in {"ptx", "e57"} else RELATIVE
    if _agree(points_m, said, tolerance):
        return Verdict("as it says")
    return Verdict("finding", f"{len(points_m)} points, an independent reader has {len(said)} others")


def _baseline(case: Case) -> _Read:
    return _baseline_of(case.seed.family, case.seed.name, case.seed.content, case.seed.suffix, case.request)


@cache
def _baseline_of(_family: str, name: str, content: bytes, suffix: str, request: ScanRequest) -> _Read:
    import tempfile  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"case{suffix}"
        path.write_bytes(content)
        return _read(path, request)


def _agree(one: Points, other: Points, tolerance: float) -> bool:
    if one.shape != other.shape:
        return False
    size = max(1.0, float(np.abs(other).max(initial=0.0)))
    return bool(np.allclose(one, other, rtol=tolerance, atol=tolerance * size))


def _independent(case: Case) -> Points | None:
    """Records (n, 3) as an independent reader has them; None where there is none."""
    content, part, in_file = case.content, case.request.part, case.request.frame == "file"
    if isinstance(part, str):
        raise Unsure
    names = ("s", "alpha", "omega") if case.request.coordinates == "polar" else ("x", "y", "z")
    readers: Mapping[str, Callable[[], Points | None]] = {
        "las": lambda: independent_binary.las(content),
        "laz": lambda: independent_binary.laz(content, case.seed),
        "e57": lambda: independent_binary.e57(content, part, in_file=in_file),
        "ptx": lambda: independent_text.ptx(content, part, in_file=in_file),
        "pts": lambda: independent_text.pts(content, part),
        "ply": lambda: independent_text.ply(content, names),
        "pcd": lambda: independent_text.pcd(content, names),
        "parquet": lambda: None,
    }
    return readers.get(case.family, lambda: independent_text.delimited(content, names))()


def _as_asked(case: Case, records: Points | None) -> Points | None:
    """Records in the unit, origin and axes that are asked for; without beams that had no return."""
    request = case.request
    if records is None or request.levelling == "file":
        return None
    if case.family in {"ply", "pcd"}:
        records = records[~np.isnan(records).all(axis=1)]
    if request.coordinates == "polar":
        records = records[records[:, 0] != 0.0]
        alpha, omega = np.radians(records[:, 1]), np.radians(records[:, 2])
        level = records[:, 0] * np.cos(omega)
        records = np.column_stack(
            [level * np.cos(alpha), level * np.sin(alpha), records[:, 0] * np.sin(omega)]
        )
    else:
        records = records[records.any(axis=1)]
    points = records * FOOT_M[request.unit] - np.array(request.origin_m)
    return points[:, (1, 0, 2)] if request.swap_axes else points


def _judge_settings(case: Case, path: Path) -> Verdict:
    """Settings that are accepted must be those that stand in the file."""
    try:
        loaded = _loaded(case.family, path)
    except REFUSALS as error:
        return Verdict("refused", _short(error, path))
    raw = tomllib.loads(case.content.decode("utf-8-sig"))
    missing = _not_taken(raw, loaded, "")
    if missing:
        return Verdict("finding", f"accepted, but not as it stands: {missing}")
    return Verdict("same" if case.content == case.seed.content else "as it says")


def _loaded(family: str, path: Path) -> object:
    if family == "campaign":
        campaign = load_campaign(path)
        for epoch in campaign.epochs:
            for scan in epoch.scans:
                campaign.scan_path(scan)
        return campaign.model_dump()
    if family == "limits":
        return {"limits": [limit.model_dump() for limit in load_limits(path)]}
    sidecar = load_sidecar(path, "ST01.laz")
    station = station_of(sidecar, "ST01.laz")
    again = tomllib.loads(toml_text("a station", {"stations": [station]}))["stations"][0]
    if _not_taken(again, station, ""):
        raise AssertionError(f"a station is not written as it is: {again} {station}")
    return sidecar.model_dump()


def _not_taken(raw: object, taken: object, where: str) -> str:
    """First place whose value is not the one of the file; texts may lose the space around them and hex its capitals."""
    if isinstance(raw, Mapping):
        if not isinstance(taken, Mapping):
            return where
        return next(
            (bad for key in raw if (bad := _not_taken(raw[key], taken.get(key), f"{where}.{key}"))), ""
        )
    if isinstance(raw, list):
        if not isinstance(taken, Sequence) or len(raw) != len(taken):
            return where
        return next(
            (
                bad
                for k, (one, two) in enumerate(zip(raw, taken, strict=True))
                if (bad := _not_taken(one, two, f"{where}[{k}]"))
            ),
            "",
        )
    if isinstance(raw, str) and isinstance(taken, str):
        return "" if raw.strip().lower() == taken.strip().lower() else where
    # a whole number may have more digits than a float has
    same = float(raw) == taken if isinstance(raw, int) and isinstance(taken, float) else raw == taken
    return "" if same else where
