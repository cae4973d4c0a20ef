"""How good the data are: what was seen, what was removed, what to mind and what follows from it, alarms."""

from collections.abc import Iterator, Sequence

from dashboard import numbers
from dashboard.report.alarm_log import AlarmThen
from dashboard.report.blocks import Beside, Block, Heading, Missing, Remark, Section, Table, Text
from dashboard.report.facts import Facts
from dashboard.report.parts import phrases
from dashboard.report.words import Words


def section(facts: Facts, words: Words, charts: dict[str, str]) -> Section:
    """Write the chapter."""
    del charts
    blocks: list[Block] = [
        Beside((_removals(facts, words), _pairs(facts, words)), (0.48, 0.52)),
        Heading(words("quality.warnings")),
        *_told(list(_warnings(facts, words)), words),
        Heading(words("quality.alarms")),
        _alarms(facts, words),
    ]
    return Section(words("quality.title"), tuple(blocks))


def _told(warnings: list[Remark], words: Words) -> Sequence[Block]:
    return warnings or [Text(words("quality.no_warnings"))]


def _removals(facts: Facts, words: Words) -> Block:
    title = words("quality.removals")
    if not facts.removals:
        return Missing(title, words("quality.no_removals"))
    total = sum(row.n_points for row in facts.removals)
    rows = tuple(
        (
            words.named("removal", row.reason),
            numbers.count(row.n_points),
            numbers.number(100.0 * row.n_points / total, 1),
        )
        if total
        else (words.named("removal", row.reason), numbers.count(row.n_points), numbers.MISSING)
        for row in facts.removals
    )
    head = (words("quality.reason"), words("quality.points"), "%")
    kept = tuple(place for place, row in enumerate(facts.removals) if row.reason == "kept")
    return Table(title, head, "lrr", rows, marked=kept, small=True)


def _pairs(facts: Facts, words: Words) -> Block:
    title = words("quality.pairs")
    rated = [row for row in facts.pairs if row.rmse_m is not None]
    if not rated:
        return Missing(title, words("quality.no_pairs"))
    worst = sorted(rated, key=lambda row: (-(row.rmse_shaft_m or row.rmse_m or 0.0), row.station, row.other))[
        :7
    ]
    rows = tuple(
        (
            f"{row.station} – {row.other}",
            numbers.number(100.0 * row.overlap, 0),
            numbers.mm(row.rmse_m, unit=""),
            numbers.mm(row.rmse_shaft_m, unit=""),
            numbers.mm(row.closure_m, unit=""),
        )
        for row in worst
    )
    head = tuple(words(f"quality.pair_{name}") for name in ("name", "overlap", "rms", "shaft", "closure"))
    return Table(
        title,
        head,
        "lrrrr",
        rows,
        note=words("quality.pairs_note", shown=len(rows), all=len(facts.pairs)),
        small=True,
    )


def _warnings(facts: Facts, words: Words) -> Iterator[Remark]:
    epoch, tilt = facts.epoch, facts.now.tilt
    if epoch.state != "ok":
        key = "warning.failed" if epoch.state == "failed" else "warning.degraded"
        yield Remark("quality", epoch.reason or words("phrase.no_reason"), words(key))
    if tilt is None:
        return
    if tilt.warning is not None:
        yield Remark("warning", tilt.warning, words("warning.tilt"))
    if tilt.deviation_sigma_m is None:
        yield Remark("quality", words("warning.no_sigma"), words("warning.no_sigma_then"))
    elif tilt.azimuth_deg is None:
        yield Remark("quality", words("warning.no_direction"), words("warning.no_direction_then"))
    yield from _stations(facts, words)
    yield from _slices(facts, words)
    yield from _sides(facts, words)


def _stations(facts: Facts, words: Words) -> Iterator[Remark]:
    for row in facts.stations:
        if row.state != "ok":
            what = words("warning.station", station=row.station, state=words.named("state", row.state))
            then = "warning.station_suspect" if row.state == "suspect" else "warning.station_failed"
            yield Remark("quality", f"{what}: {row.reason or words('phrase.no_reason')}", words(then))


def _slices(facts: Facts, words: Words) -> Iterator[Remark]:
    failed = [row for row in facts.primary_slices if row.state != "ok"]
    if failed:
        heights = ", ".join(f"{row.z_m:.1f}" for row in failed[:8]) + (" …" if len(failed) > 8 else "")
        what = words("warning.slices", count=len(failed), all=len(facts.primary_slices), heights=heights)
        yield Remark("quality", what, words("warning.slices_then"))


def _sides(facts: Facts, words: Words) -> Iterator[Remark]:
    epoch = facts.epoch
    if facts.now.lacks_a_station and epoch.next_station_azimuth_deg is not None:
        coverage_deg = numbers.degrees(epoch.coverage_deg, 0)
        then = words(
            "warning.sides_then",
            azimuth=numbers.degrees(epoch.next_station_azimuth_deg, 0),
            now=numbers.number(epoch.stations_sigma_arcsec, 1),
            then=numbers.number(epoch.next_station_sigma_arcsec, 1),
        )
        yield Remark("quality", words("warning.sides", coverage=coverage_deg), then)


def _alarms(facts: Facts, words: Words) -> Block:
    if not facts.alarms:
        return Text(words("quality.no_alarms"))
    head = ("severity", "rule", "epoch", "what", "state")
    return Table(
        "",
        tuple(words(f"alarm.{name}") for name in head),
        "lllll",
        tuple(_alarm(row, words) for row in facts.alarms[-10:]),
        note=words("quality.alarms_note"),
        small=True,
    )


def _alarm(row: AlarmThen, words: Words) -> tuple[str, ...]:
    state = words.named("alarm_state", row.state) + (f" ({row.person})" if row.person else "")
    raised = row.raised_epoch or numbers.MISSING
    return words.named("severity", row.severity), row.rule, raised, phrases.brief(row.what), state
