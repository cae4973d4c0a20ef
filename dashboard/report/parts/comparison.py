"""The slicing schemes side by side: tables 1 to 3 of the paper with uncertainties added."""

from dashboard import numbers
from dashboard.report.blocks import Block, Chart, Missing, Remark, Section, Table, Text
from dashboard.report.charts import schemes
from dashboard.report.facts import Facts
from dashboard.report.legible import label
from dashboard.report.parts import phrases
from dashboard.report.words import Words
from storage.records import AccuracyRow, SchemeComparisonRow, TiltRow

QUANTITIES = ("beta_deg", "tilt_deg", "verticality_permille", "deviation_m")


def section(facts: Facts, words: Words, charts: dict[str, str]) -> Section:
    """Write the chapter."""
    if not facts.tilts:
        return Section(
            words("schemes.title"),
            (Missing(words("schemes.title"), words("card.no_result")), *_failed(facts, words)),
        )
    blocks: list[Block] = [
        _chart(facts, words, charts),
        _first(facts, words),
        _second(facts, words),
        _third(facts, words),
        *_advice(facts, words),
        *_failed(facts, words),
    ]
    return Section(words("schemes.title"), tuple(blocks))


def _chart(facts: Facts, words: Words, charts: dict[str, str]) -> Block:
    found = [
        schemes.Found(
            label(phrases.way(row.scheme, row.method)),
            row.scheme,
            row.method,
            row.deviation_m,
            row.deviation_sigma_m,
            (row.scheme, row.method) == facts.primary,
        )
        for row in facts.tilts
    ]
    found += [
        schemes.Found(label(row.source), "", "", row.deviation_m, row.deviation_sigma_m, is_primary=False)
        for row in facts.references
    ]
    charts["schemes"] = schemes.chart(found, facts.tilts[0].allowable_m, words)
    return Chart(
        "schemes", words("schemes.chart"), words("schemes.chart_note"), words("schemes.chart_described")
    )


def _marked(facts: Facts) -> tuple[int, ...]:
    return tuple(place for place, row in enumerate(facts.tilts) if (row.scheme, row.method) == facts.primary)


def _first(facts: Facts, words: Words) -> Table:
    head = ("scheme", "centres", "iterations", "reweighted", "mean_deviation", "rms", "effective")
    return Table(
        words("schemes.first"),
        tuple(words(f"schemes.{name}") for name in head),
        "lrrrrrr",
        tuple(_first_row(row) for row in facts.tilts),
        marked=_marked(facts),
        small=True,
    )


def _first_row(row: TiltRow) -> tuple[str, ...]:
    return (
        phrases.way(row.scheme, row.method),
        numbers.count(row.n_centres),
        numbers.count(row.iterations),
        numbers.number(row.update_weight_ratio_pct, 1),
        numbers.mm(row.mean_deviation_m, 2, ""),
        numbers.mm(row.rmse_m, 2, ""),
        numbers.number(row.n_effective, 1),
    )


def _second(facts: Facts, words: Words) -> Table:
    head = ("scheme", "slices", "vector", "azimuth", "tilt", "verticality", "deviation", "verdict")
    return Table(
        words("schemes.second"),
        tuple(words(f"schemes.{name}") for name in head),
        "lrlrrrrl",
        tuple(_second_row(row, words) for row in facts.tilts),
        note=words("schemes.second_note"),
        marked=_marked(facts),
        small=True,
    )


def _second_row(row: TiltRow, words: Words) -> tuple[str, ...]:
    vector = ", ".join(numbers.number(part, 8) for part in (row.d_east, row.d_north, row.d_up))
    return (
        phrases.way(row.scheme, row.method),
        numbers.count(row.n_slices),
        vector,
        numbers.degrees(row.azimuth_deg),
        numbers.dms(row.tilt_deg),
        numbers.number(row.verticality_permille, 3),
        numbers.mm_with_u(row.deviation_m, row.deviation_sigma_m, ""),
        words.named("verdict_word", row.verdict),
    )


def _third(facts: Facts, words: Words) -> Block:
    if not facts.accuracy and not facts.comparison:
        return Missing(words("schemes.third"), words("schemes.no_control"))
    control = facts.accuracy[0].control if facts.accuracy else numbers.MISSING
    note = words("schemes.third_note", primary=phrases.way(*facts.primary))
    found = {(row.scheme, row.method, row.quantity): row for row in facts.accuracy}
    beside = {row.compared: row for row in facts.comparison}
    head = ("scheme", "rel_beta", "rel_tilt", "rel_verticality", "rel_deviation", "apart", "apart_p", "ratio")
    rows = tuple(
        _third_row(row, found, beside.get(phrases.way(row.scheme, row.method))) for row in facts.tilts
    )
    return Table(
        words("schemes.third_against", control=control),
        tuple(words(f"schemes.{name}") for name in head),
        "lrrrrrrr",
        rows,
        note=note if facts.accuracy else f"{control}: {words('schemes.no_control')}. {note}",
        marked=_marked(facts),
        small=True,
    )


def _third_row(
    row: TiltRow, found: dict[tuple[str, str, str], AccuracyRow], beside: SchemeComparisonRow | None
) -> tuple[str, ...]:
    told = [found.get((row.scheme, row.method, quantity)) for quantity in QUANTITIES]
    return (
        phrases.way(row.scheme, row.method),
        *(numbers.number(each.relative_error_pct if each else None, 3) for each in told),
        numbers.mm_with_u(beside.d_top_m, beside.d_sigma_top_m, "") if beside else numbers.MISSING,
        numbers.probability(beside.p_value) if beside else numbers.MISSING,
        numbers.number(beside.workload_ratio, 2) if beside else numbers.MISSING,
    )


def _advice(facts: Facts, words: Words) -> list[Block]:
    chosen = next((row for row in facts.comparison if row.is_recommended), None)
    if chosen is None:
        return []
    return [Text(words("schemes.recommended", way=chosen.compared, slices=numbers.count(chosen.n_slices)))]


def _failed(facts: Facts, words: Words) -> list[Block]:
    return [
        Remark(
            "quality",
            words("schemes.failed", way=phrases.way(row.scheme, row.method)),
            row.reason or words("phrase.no_reason"),
        )
        for row in facts.schemes
        if row.state == "failed"
    ]
