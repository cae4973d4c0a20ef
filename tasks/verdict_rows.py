"""The rows of the table of verdicts: every limit of a campaign beside every axis of an epoch."""

from collections.abc import Iterator, Sequence

from storage.records import TiltRow, VerdictRow
from tasks.evaluation import Standard
from tasks.limits import LimitTable, MissingLimit, verdict


def verdict_rows(tilt: Sequence[TiltRow], standard: Standard) -> list[VerdictRow]:
    """Judge axes by the primary limit and by those beside it; none where the campaign names no limit."""
    limits = [] if standard.limit is None else [(standard.limit, True)]
    limits += [(limit, False) for limit in standard.also]
    return list(_rows(tilt, limits))


def _rows(
    tilt: Sequence[TiltRow], limits: Sequence[tuple[LimitTable | MissingLimit, bool]]
) -> Iterator[VerdictRow]:
    for row in tilt:
        for limit, is_primary in limits:
            judged = verdict(row.deviation_m, row.deviation_sigma_m, row.height_m, limit)
            table = limit if isinstance(limit, LimitTable) else None
            yield VerdictRow(
                structure=row.structure,
                epoch=row.epoch,
                scheme=row.scheme,
                method=row.method,
                limit_name=limit.name,
                is_primary=is_primary,
                version=table.version if table else None,
                kind=str(table.kind) if table else None,
                document=table.document if table else None,
                edition=table.edition if table else None,
                clause=table.clause if table else None,
                height_m=row.height_m,
                allowable_m=judged.allowable_m,
                deviation_m=row.deviation_m,
                sigma_m=row.deviation_sigma_m,
                verdict=judged.verdict,
                reason=judged.reason,
            )
