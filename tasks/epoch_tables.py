"""The rows of an epoch's tables, from what its stages produced."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

import numpy as np

from storage.artifacts import ArtifactRef
from storage.records import (
    EpochRow,
    RemovalRow,
    SchemeRow,
    SectionFit,
    SliceRow,
)
from tasks.lean import Lean
from tasks.methods import Method
from tasks.preprocessing import Removal
from tasks.slicing import SlicingScheme

LEAST_RADII: Final = 3
"""Two radii are on their line whatever they are."""


@dataclass(frozen=True, slots=True)
class Home:
    """Structure and epoch that rows belong to."""

    structure: str
    epoch: str


@dataclass(frozen=True, slots=True)
class ScanInput:
    """What became of one scan file: its digest and count, or why it was refused."""

    station: str
    digest: str | None
    n_points: int | None
    refusal: str | None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SchemeOutcome:
    """What became of one scheme and method: its slices, and its axis or why there is none."""

    scheme: SlicingScheme
    method: Method
    sections: tuple[SectionFit, ...]
    lean: Lean | None
    reason: str | None
    lean_ref: ArtifactRef | None = None


def removal_rows(home: Home, counts: Sequence[Removal]) -> list[RemovalRow]:
    """One row a reason for which points were removed, in order; the reason "kept" counts those that remained."""
    return [
        RemovalRow(home.structure, home.epoch, i, count.reason, count.n_points)
        for i, count in enumerate(counts)
    ]


def scheme_rows(home: Home, outcomes: Sequence[SchemeOutcome]) -> list[SchemeRow]:
    """One row a scheme and method, those without an axis too."""
    return [
        SchemeRow(
            structure=home.structure,
            epoch=home.epoch,
            scheme=outcome.scheme.name,
            method=outcome.method.name,
            interval_m=outcome.scheme.interval_m,
            thickness_m=None if outcome.scheme.surface is not None else outcome.method.thickness_m,
            contour=outcome.method.contour,
            axis=outcome.method.axis,
            n_slices=len(outcome.sections),
            n_centres=sum(section.state == "ok" for section in outcome.sections),
            state="ok" if outcome.lean is not None else "failed",
            reason=outcome.reason,
        )
        for outcome in outcomes
    ]


def slice_rows(home: Home, outcome: SchemeOutcome) -> list[SliceRow]:
    """One row a slice with its part in the axis, the failed ones too."""
    weights, residuals = iter(()), iter(())
    if outcome.lean is not None:
        axis = outcome.lean.axis
        weights = iter(axis.weights.tolist())
        residuals = iter(axis.residuals_m.tolist() if axis.residuals_m is not None else ())
    return [
        SliceRow(
            structure=home.structure,
            epoch=home.epoch,
            scheme=outcome.scheme.name,
            method=outcome.method.name,
            **{name: getattr(section, name) for name in SectionFit.__dataclass_fields__},
            weight=next(weights, None) if section.state == "ok" else None,
            residual_m=next(residuals, None) if section.state == "ok" else None,
            offset_east_m=_offset_m(section, outcome.lean, 0),
            offset_north_m=_offset_m(section, outcome.lean, 1),
            radius_offset_m=radius_offset_m,
        )
        for section, radius_offset_m in zip(
            outcome.sections, _radius_offsets_m(outcome.sections), strict=True
        )
    ]


def _offset_m(section: SectionFit, lean: Lean | None, component: int) -> float | None:
    """East (0) or north (1) of a centre beside the straight axis at its height; None without a centre or an axis."""
    centre_m = (section.center_east_m, section.center_north_m)[component]
    if lean is None or centre_m is None:
        return None
    axis = lean.axis
    at_height_m = axis.point_m[component] + axis.lean[component] * (section.z_m - axis.point_m[2])
    return centre_m - float(at_height_m)


def _radius_offsets_m(sections: Sequence[SectionFit]) -> list[float | None]:
    """What the radius of each slice is off the straight line through all of them; None without a radius, or a line.

    The local change of the radius of reference [50] of Zhou et al. 2025.
    """
    known = [(section.z_m, section.radius_m) for section in sections if section.radius_m is not None]
    if len(known) < LEAST_RADII:
        return [None] * len(sections)
    z_m, radius_m = np.array(known).T
    line = np.polynomial.Polynomial.fit(z_m, radius_m, 1)
    return [
        None if section.radius_m is None else section.radius_m - float(line(section.z_m))
        for section in sections
    ]


@dataclass(frozen=True, slots=True)
class EpochFacts:
    """What is said of an epoch as a whole; ``reasons`` are those why its state is not ok."""

    epoch_time: datetime
    run: str
    is_reference: bool
    height_m: float
    n_points_used: int
    campaign_digest: str
    code_version: str
    schema_version: int
    reasons: tuple[str, ...]
    has_result: bool


def epoch_row(home: Home, facts: EpochFacts, scans: Sequence[ScanInput]) -> EpochRow:
    """The row of an epoch: ok, degraded where something failed and the rest was processed, or failed."""
    state = "failed" if not facts.has_result else "degraded" if facts.reasons else "ok"
    return EpochRow(
        structure=home.structure,
        epoch=home.epoch,
        epoch_time=facts.epoch_time,
        run=facts.run,
        state=state,
        reason="; ".join(facts.reasons) or None,
        n_stations=len(scans),
        n_stations_used=sum(scan.refusal is None for scan in scans),
        n_points_in=sum(scan.n_points or 0 for scan in scans),
        n_points_used=facts.n_points_used,
        is_reference=facts.is_reference,
        height_m=facts.height_m,
        campaign_digest=facts.campaign_digest,
        code_version=facts.code_version,
        schema_version=facts.schema_version,
    )
