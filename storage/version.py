"""Rows of the views on earlier results: ``versions``, ``version_tilt`` and ``version_changes``."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records import Column, TiltRow


@dataclass(frozen=True, slots=True)
class VersionRow:
    """An epoch as it was published before, kept when it was processed anew."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    version: Annotated[str, Column("name under which the results are kept")]
    archived_at: Annotated[datetime, Column("when they were put aside", "UTC")]
    why: Annotated[str, Column("what they were put aside for")]
    run: Annotated[
        str | None, Column("run that published them; NULL where the row of the epoch was damaged, as below")
    ]
    state: Annotated[str | None, Column("state of the epoch then")]
    code_version: Annotated[str | None, Column("digest of the code that made them")]
    campaign_digest: Annotated[
        str | None, Column("SHA-256 of the filled-in campaign settings that made them")
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class VersionTiltRow(TiltRow):
    """The axis of an epoch under a scheme and method as it was published before."""

    version: Annotated[str, Column("name under which the results are kept")]


@dataclass(frozen=True, slots=True)
class VersionChangeRow:
    """An axis as it was published before, and what has become of it.

    d is the present lean minus the earlier one: what another code, method or setting made of the same scans, no movement
    of the structure. ``outcome`` is ``unchanged`` where lean and covariance are the same to the last bit, and ``gone``
    where the scheme and method have no axis now.
    """

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    epoch_time: Annotated[datetime, Column("time of the epoch, as an instant", "UTC")]
    version: Annotated[str, Column("name under which the earlier results are kept")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    outcome: Annotated[str, Column("unchanged, changed or gone")]
    height_m: Annotated[float, Column("height H at which the difference is stated, as it was then", "m")]
    d_lean_east: Annotated[float | None, Column("lean_east now minus then; NULL where gone", "1")]
    d_lean_north: Annotated[float | None, Column("lean_north now minus then; NULL where gone", "1")]
    d_top_m: Annotated[float | None, Column("length of the difference at height_m; NULL where gone", "m")]
    d_sigmas: Annotated[
        float | None,
        Column(
            "root of d' C^-1 d with the earlier covariance: the difference in earlier sigmas; NULL where C is unknown",
            "1",
        ),
    ]
    sigma_ratio: Annotated[
        float | None,
        Column(
            "sigma of a component of the lean (root mean square of both) now over then; NULL where unknown",
            "1",
        ),
    ]
    verdict_before: Annotated[str, Column("verdict then: pass, fail, cannot tell or no limit")]
    verdict_now: Annotated[str | None, Column("verdict now; NULL where gone")]
    verdict_changed: Annotated[bool | None, Column("whether the two verdicts differ; NULL where gone")]
