"""A stage of a run."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class StageRunRow:
    """What one stage of one run did: the ledger, independent of Prefect's."""

    run: Annotated[str, Column("id of the run")]
    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    stage: Annotated[str, Column("stage, with station or scheme and method where it has one")]
    state: Annotated[str, Column("computed or cached")]
    outcome: Annotated[str, Column("ok, refused (bad input, see reason) or failed (a fault of the program)")]
    reason: Annotated[str | None, Column("why the outcome is not ok")]
    started_at: Annotated[datetime, Column("when the stage was asked for", "UTC")]
    seconds: Annotated[float | None, Column("time the stage took; NULL where it was cached", "s")]
    points: Annotated[int | None, Column("points that came in; NULL where the stage has none")]
    peak_rss_mb: Annotated[
        float | None, Column("largest memory of the process so far; NULL where it was cached", "MB")
    ]
    code_version: Annotated[str, Column("digest of all code that the stage reaches")]
    cache_key: Annotated[str, Column("key of the stage's record")]
