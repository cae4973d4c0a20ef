"""What was found of a simulated campaign, against the truth that was written beside its scans."""

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.errors import InputError
from storage.records import TiltRow
from storage.views import ChangeRow, change_rows, tilt_rows
from storage.workspace import Workspace
from tasks.conventions import ARCSEC_RAD
from tasks.geometry.plane_vectors import CHI2_95
from tasks.settings import Campaign

TRUTH_FILE: Final = "truth.json"


@dataclass(frozen=True, slots=True)
class TrueLean:
    """True lean vector of an epoch, dimensionless."""

    east: float
    north: float


@dataclass(frozen=True, slots=True)
class FoundLean:
    """Error of the lean vector of an epoch under a scheme and method.

    ``error_arcsec`` is the length of the error, ``sigma_arcsec`` the stated standard deviation of a component;
    ``inside_95`` whether the truth lies in the stated 95 % region; None where no covariance was stated.
    """

    epoch: str
    scheme: str
    method: str
    error_arcsec: float
    error_top_m: float
    sigma_arcsec: float | None
    inside_95: bool | None


@dataclass(frozen=True, slots=True)
class FoundChange:
    """Movement of the top since the reference epoch, true and found."""

    epoch: str
    reference: str
    scheme: str
    method: str
    true_top_m: float
    found_top_m: float
    error_top_m: float
    sigma_top_m: float | None
    inside_95: bool | None
    significant: bool | None


@dataclass(frozen=True, slots=True)
class FoundAgainstTrue:
    """All leans and all changes of a campaign against the truth."""

    leans: tuple[FoundLean, ...]
    changes: tuple[FoundChange, ...]


def found_against_true(workspace: Workspace, campaign: Campaign) -> FoundAgainstTrue:
    """Compare what a workspace holds of a simulated campaign with its truth.

    Raises
    ------
    InputError
        If an epoch has no truth beside its scans.
    StorageError
        If the catalog cannot be read.
    """
    structure = campaign.structure.id
    truths = {epoch.id: _read_truth(campaign.folder / epoch.id / TRUTH_FILE) for epoch in campaign.epochs}
    leans = [row for row in tilt_rows(workspace, structure) if row.epoch in truths]
    changes = [
        row for row in change_rows(workspace, structure) if {row.epoch, row.reference_epoch} <= truths.keys()
    ]
    return FoundAgainstTrue(
        tuple(_found_lean(row, truths[row.epoch]) for row in leans),
        tuple(_found_change(row, truths[row.epoch], truths[row.reference_epoch]) for row in changes),
    )


def text_lines(found: FoundAgainstTrue) -> Iterator[str]:
    """Print found against true, a line for every scheme, method and epoch."""
    yield "Lean, found against true"
    yield f"{'epoch':10} {'scheme':8} {'method':8} {'error':>8} {'at H':>9} {'sigma':>8}  truth in 95 % region"
    for lean in found.leans:
        sigma = "--" if lean.sigma_arcsec is None else f'{lean.sigma_arcsec:.2f}"'
        yield (
            f"{lean.epoch:10} {lean.scheme:8} {lean.method:8} {_arcsec(lean.error_arcsec):>8}"
            f" {_mm(lean.error_top_m):>9} {sigma:>8}  {_yes_no(lean.inside_95)}"
        )
    yield ""
    yield "Movement of the top since the reference, found against true"
    yield (
        f"{'epoch':10} {'scheme':8} {'method':8} {'true':>9} {'found':>9} {'error':>9} {'sigma':>9}"
        "  in 95 %  significant"
    )
    for change in found.changes:
        sigma = "--" if change.sigma_top_m is None else _mm(change.sigma_top_m)
        yield (
            f"{change.epoch:10} {change.scheme:8} {change.method:8} {_mm(change.true_top_m):>9}"
            f" {_mm(change.found_top_m):>9} {_mm(change.error_top_m):>9} {sigma:>9}"
            f"  {_yes_no(change.inside_95):7}  {_yes_no(change.significant)}"
        )


def _read_truth(path: Path) -> TrueLean:
    try:
        east, north = json.loads(path.read_text(encoding="utf-8"))["lean_fit"]
        return TrueLean(float(east), float(north))
    except FileNotFoundError as error:
        raise InputError(
            f"{path}: no such file; only a simulated campaign has its truth beside it"
        ) from error
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: needs lean_fit = [east, north]; got {error}") from error


def _found_lean(row: TiltRow, truth: TrueLean) -> FoundLean:
    error = (row.lean_east - truth.east, row.lean_north - truth.north)
    length = math.hypot(*error)
    ee, nn = row.lean_cov_ee, row.lean_cov_nn
    sigma = None if ee is None or nn is None else math.sqrt((ee + nn) / 2.0)
    return FoundLean(
        epoch=row.epoch,
        scheme=row.scheme,
        method=row.method,
        error_arcsec=length / ARCSEC_RAD,
        error_top_m=length * row.height_m,
        sigma_arcsec=None if sigma is None else sigma / ARCSEC_RAD,
        inside_95=_inside(error, (ee, row.lean_cov_en, nn)),
    )


def _found_change(row: ChangeRow, truth: TrueLean, base: TrueLean) -> FoundChange:
    true = (truth.east - base.east, truth.north - base.north)
    error = (row.d_lean_east - true[0], row.d_lean_north - true[1])
    return FoundChange(
        epoch=row.epoch,
        reference=row.reference_epoch,
        scheme=row.scheme,
        method=row.method,
        true_top_m=math.hypot(*true) * row.height_m,
        found_top_m=row.d_top_m,
        error_top_m=math.hypot(*error) * row.height_m,
        sigma_top_m=row.sigma_top_m,
        inside_95=_inside(error, (row.d_cov_ee, row.d_cov_en, row.d_cov_nn)),
        significant=row.significant,
    )


def _inside(
    error: Sequence[float], covariance: tuple[float | None, float | None, float | None]
) -> bool | None:
    """Whether an error lies in the 95 % region of its covariance (ee, en, nn); None where that is no covariance."""
    ee, en, nn = covariance
    if ee is None or en is None or nn is None or ee <= 0.0 or ee * nn - en * en <= 0.0:
        return None
    east, north = error
    chi2 = (nn * east**2 - 2.0 * en * east * north + ee * north**2) / (ee * nn - en * en)
    return chi2 < CHI2_95


def _arcsec(value: float) -> str:
    return f'{value:.2f}"'


def _mm(value_m: float) -> str:
    return f"{1e3 * value_m:.2f} mm"


def _yes_no(value: bool | None) -> str:
    return {True: "yes", False: "NO", None: "--"}[value]
