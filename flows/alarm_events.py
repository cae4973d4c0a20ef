"""Tell a Prefect server of alarms, so that its automations can act on them."""

from collections.abc import Sequence
from typing import Final

from flows.prefect_home import users_server
from flows.terminal import note
from storage.records import AlarmEventRow

EVENT: Final = "tiltwatch.alarm"
"""Name of the event; the labels of its resource say which alarm of which structure, and what happened to it."""


def tell_prefect(rows: Sequence[AlarmEventRow]) -> int:
    """Emit an event for every row where PREFECT_API_URL names a server; returns how many were handed over.

    A server that cannot be reached never stops a run: the log of alarms is what counts, and targets of [[notify]] are
    what people rely on.
    """
    if not rows or users_server() is None:
        return 0
    try:
        # Prefect reads its settings when it is imported
        from prefect.events import emit_event  # noqa: PLC0415

        for row in rows:
            emit_event(EVENT, resource=_resource(row), payload=_payload(row), occurred=row.happened_at)
    except Exception as fault:
        note(f"Prefect was not told of {len(rows)} alarm events: {type(fault).__name__}: {fault}")
        return 0
    return len(rows)


def _resource(row: AlarmEventRow) -> dict[str, str]:
    return {
        "prefect.resource.id": f"tiltwatch.alarm.{row.structure}.{row.alarm}",
        "prefect.resource.name": row.alarm,
        "tiltwatch.structure": row.structure,
        "tiltwatch.rule": row.rule,
        "tiltwatch.severity": row.severity,
        "tiltwatch.action": row.action,
    }


def _payload(row: AlarmEventRow) -> dict[str, str | float | None]:
    return {
        "event": row.event,
        "epoch": row.epoch,
        "value": row.value,
        "limit_value": row.limit_value,
        "unit": row.unit,
        "what": row.note,
        "happened_at": row.happened_at.isoformat(),
    }
