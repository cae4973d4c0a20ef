"""The annex: every number, so that the result can be followed and signed."""

from dashboard import numbers
from dashboard.report.blocks import Block, Missing, Pairs, Section, SignOff, Table
from dashboard.report.facts import Facts
from dashboard.report.parts import phrases
from dashboard.report.words import Words
from storage.records import SliceRow, StationRow, TiltRow, VerdictRow


def section(facts: Facts, words: Words, charts: dict[str, str]) -> Section:
    """Write the annex."""
    del charts
    blocks: list[Block] = [
        SignOff(
            tuple(words(f"sign.{name}") for name in ("role", "name", "date", "signature")),
            tuple(words(f"sign.{name}") for name in ("prepared", "checked", "approved")),
        ),
        _origin(facts, words),
        _verdicts(facts, words),
        _leans(facts, words),
        _parameters(facts, words),
        _tests(facts, words),
        _slices(facts, words),
        _poses(facts, words),
        _digests(facts, words),
        _stages(facts, words),
    ]
    return Section(words("annex.title"), tuple(blocks), annex=True)


def _origin(facts: Facts, words: Words) -> Pairs:
    epoch = facts.epoch
    return Pairs(
        (
            (words("annex.structure"), facts.structure),
            (words("annex.epoch"), f"{epoch.epoch}, {numbers.minute(epoch.epoch_time)}"),
            (words("annex.run"), epoch.run),
            (words("annex.published"), numbers.minute(facts.published_at)),
            (words("annex.campaign_digest"), epoch.campaign_digest),
            (words("annex.code_version"), epoch.code_version),
            (words("annex.tables_version"), str(epoch.schema_version)),
            (words("annex.program"), facts.program_version),
            (words("annex.libraries"), ", ".join(facts.library_versions) or numbers.MISSING),
        )
    )


def _verdicts(facts: Facts, words: Words) -> Block:
    title = words("annex.verdicts")
    if not facts.primary_verdicts:
        return Missing(title, words("annex.no_verdicts"))
    head = ("limit", "version", "kind", "document", "allowable", "verdict", "reason")
    rows = tuple(_verdict(row, words) for row in facts.primary_verdicts)
    marked = tuple(place for place, row in enumerate(facts.primary_verdicts) if row.is_primary)
    return Table(
        title, tuple(words(f"verdicts.{name}") for name in head), "lrllrll", rows, marked=marked, small=True
    )


def _verdict(row: VerdictRow, words: Words) -> tuple[str, ...]:
    paper = phrases.SEPARATOR[words.lang].join(
        part for part in (row.document, row.edition, row.clause) if part
    )
    return (
        row.limit_name,
        numbers.count(row.version),
        words.named("kind", row.kind) if row.kind else numbers.MISSING,
        paper or numbers.MISSING,
        numbers.mm(row.allowable_m, unit=""),
        words.named("verdict_word", row.verdict),
        row.reason,
    )


def _leans(facts: Facts, words: Words) -> Block:
    title = words("annex.leans")
    if not facts.tilts:
        return Missing(title, words("card.no_result"))
    head = (
        "scheme",
        "lean_east",
        "lean_north",
        "sigma_east",
        "sigma_north",
        "correlation",
        "base_east",
        "base_north",
        "beta",
        "u",
    )
    return Table(
        title,
        tuple(words(f"leans.{name}") for name in head),
        "lrrrrrrrrr",
        tuple(_lean(row) for row in facts.tilts),
        note=words("leans.note"),
        small=True,
    )


def _lean(row: TiltRow) -> tuple[str, ...]:
    east = None if row.lean_cov_ee is None else 1e6 * row.lean_cov_ee**0.5
    north = None if row.lean_cov_nn is None else 1e6 * row.lean_cov_nn**0.5
    correlation = None
    if row.lean_cov_en is not None and east and north:
        correlation = 1e12 * row.lean_cov_en / (east * north)
    return (
        phrases.way(row.scheme, row.method),
        numbers.number(1e6 * row.lean_east, 1),
        numbers.number(1e6 * row.lean_north, 1),
        numbers.number(east, 1),
        numbers.number(north, 1),
        numbers.number(correlation, 3),
        numbers.number(row.base_east_m, 4),
        numbers.number(row.base_north_m, 4),
        numbers.number(row.beta_deg, 5),
        numbers.mm(
            None if row.deviation_sigma_m is None else numbers.COVERAGE * row.deviation_sigma_m, 2, ""
        ),
    )


def _parameters(facts: Facts, words: Words) -> Block:
    title = words("annex.parameters", way=phrases.way(*facts.primary))
    rows = [row for row in facts.parameters if (row.scheme, row.method) == facts.primary]
    if not rows:
        return Missing(title, words("annex.no_parameters"))
    head = tuple(words(f"parameters.{name}") for name in ("parameter", "value", "sigma"))
    body = tuple((row.parameter, numbers.number(row.value, 7), numbers.number(row.sigma, 7)) for row in rows)
    return Table(title, head, "lrr", body, note=words("parameters.note"), small=True)


def _tests(facts: Facts, words: Words) -> Block:
    title = words("annex.tests")
    rows = [row for row in facts.tests if (row.scheme, row.method) == facts.primary]
    if not rows:
        return Missing(title, words("annex.no_tests"))
    head = ("quantity", "size", "p", "significant", "detectable", "reason")
    body = tuple(
        (
            words.named("quantity", row.quantity),
            numbers.mm_with_u(row.size_m, row.sigma_m, ""),
            numbers.probability(row.p_value),
            numbers.MISSING
            if row.significant is None
            else words("word.yes" if row.significant else "word.no"),
            numbers.mm(row.smallest_detectable_m, 2, ""),
            row.reason or "",
        )
        for row in rows
    )
    return Table(
        title,
        tuple(words(f"tests.{name}") for name in head),
        "lrrlrl",
        body,
        note=words("tests.note"),
        small=True,
    )


def _slices(facts: Facts, words: Words) -> Block:
    title = words("annex.slices", way=phrases.way(*facts.primary))
    if not facts.primary_slices:
        return Missing(title, words("slices.none"))
    head = (
        "number",
        "z",
        "points",
        "east",
        "north",
        "sigma",
        "radius",
        "rmse",
        "coverage",
        "off_axis",
        "weight",
    )
    rows = tuple(_slice(row) for row in facts.primary_slices)
    return Table(title, tuple(words(f"slices.{name}") for name in head), "rrrrrrrrrrr", rows, small=True)


def _slice(row: SliceRow) -> tuple[str, ...]:
    return (
        str(row.slice_index),
        numbers.number(row.z_m, 3),
        numbers.count(row.n_points),
        numbers.number(row.center_east_m, 4),
        numbers.number(row.center_north_m, 4),
        numbers.mm(row.sigma_center_m, 2, ""),
        numbers.number(row.radius_m, 4),
        numbers.mm(row.rmse_m, 1, ""),
        numbers.degrees(row.arc_coverage_deg, 0),
        numbers.mm(row.residual_m, 2, ""),
        numbers.number(row.weight, 2),
    )


def _poses(facts: Facts, words: Words) -> Block:
    title = words("annex.poses")
    if not facts.stations:
        return Missing(title, words("method.no_stations"))
    head = ("station", "up", "heading", "d_heading", "d_east", "d_north", "d_up", "level_check", "weakest")
    rows = tuple(_pose(row) for row in facts.stations)
    return Table(title, tuple(words(f"poses.{name}") for name in head), "lrrrrrrrl", rows, small=True)


def _pose(row: StationRow) -> tuple[str, ...]:
    return (
        row.station,
        numbers.number(row.position_up_m, 3),
        numbers.degrees(row.heading_deg, 4),
        numbers.degrees(row.heading_correction_deg, 4),
        numbers.mm(row.correction_east_m, 1, ""),
        numbers.mm(row.correction_north_m, 1, ""),
        numbers.mm(row.correction_up_m, 1, ""),
        numbers.number(row.level_check_arcsec, 1),
        row.weakest_direction or numbers.MISSING,
    )


def _digests(facts: Facts, words: Words) -> Block:
    title = words("annex.digests")
    if not facts.stations:
        return Missing(title, words("method.no_stations"))
    head = (words("stations.station"), words("annex.points"), "SHA-256")
    rows = tuple(
        (row.station, numbers.count(row.n_points), row.scan_digest or numbers.MISSING)
        for row in facts.stations
    )
    return Table(title, head, "lrl", rows, small=True)


def _stages(facts: Facts, words: Words) -> Block:
    title = words("annex.stages")
    if not facts.stages:
        return Missing(title, words("annex.no_stages"))
    head = tuple(words(f"stages.{name}") for name in ("stage", "outcome", "points", "seconds", "code"))
    rows = tuple(
        (
            row.stage,
            words.named("outcome", row.outcome) + (f": {row.reason}" if row.reason else ""),
            numbers.count(row.points),
            numbers.number(row.seconds, 2),
            row.code_version[:16],
        )
        for row in facts.stages
    )
    return Table(title, head, "llrrl", rows, note=words("stages.note"), small=True)
