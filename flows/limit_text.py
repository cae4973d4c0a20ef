"""Tables of limits as lines for people and as an object for programs."""

from collections.abc import Iterator
from dataclasses import dataclass

from tasks.geometry.failure import FitFailure
from tasks.limits import LimitKind, LimitTable, allowable


@dataclass(frozen=True, slots=True)
class LimitFacts:
    """Everything that is known of a table; ``allowable_m`` and ``no_limit`` belong to ``height_m``."""

    name: str
    version: int
    valid_from: str | None
    kind: str
    rule: str
    holds: str
    document: str
    edition: str
    clause: str
    source: str
    verified_by: str | None
    note: str
    sigmas: float | None
    height_m: float | None
    allowable_m: float | None
    no_limit: str | None


def limit_facts(table: LimitTable, height_m: float | None) -> LimitFacts:
    """Put together what is known of a table, and what it allows at a height."""
    found = None if height_m is None else allowable(table, height_m)
    return LimitFacts(
        name=table.name,
        version=table.version,
        valid_from=table.valid_from,
        kind=str(table.kind),
        rule=table.rule.described,
        holds=table.rule.holds,
        document=table.document,
        edition=table.edition,
        clause=table.clause,
        source=table.source,
        verified_by=table.verified_by,
        note=table.note,
        sigmas=table.sigmas if table.kind is LimitKind.MEASUREMENT else None,
        height_m=height_m,
        allowable_m=None if isinstance(found, FitFailure) else found,
        no_limit=found.reason if isinstance(found, FitFailure) else None,
    )


def limit_lines(facts: LimitFacts) -> Iterator[str]:
    """A table of limits, a line a question."""
    since = "" if facts.valid_from is None else f", for epochs from {facts.valid_from} on"
    yield f"{facts.name}, version {facts.version}{since}"
    yield f"  kind: {facts.kind}"
    yield f"  rule: {facts.rule}"
    yield f"  holds: {facts.holds}"
    if facts.sigmas is not None:
        yield f"  judges: {facts.sigmas:g} sigma of the deviation, not the deviation"
    yield f"  document: {', '.join(filter(None, (facts.document, facts.edition, facts.clause)))}"
    yield f"  source: {facts.source}"
    yield f"  verified by: {facts.verified_by or 'nobody: not compared with the document'}"
    if facts.note:
        yield f"  note: {facts.note}"
    if facts.allowable_m is not None:
        yield f"  at {facts.height_m:g} m: {1e3 * facts.allowable_m:.1f} mm"
    if facts.no_limit is not None:
        yield f"  at {facts.height_m:g} m: no limit; {facts.no_limit}"
