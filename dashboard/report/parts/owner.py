"""The first page: the verdict in words, colour and icon, for those who read no other."""

from typing import Final

from dashboard import numbers, theme
from dashboard.report.blocks import Card, Chart, FirstPage, Missing, Tone
from dashboard.report.charts import sketch
from dashboard.report.facts import Facts
from dashboard.report.parts import phrases
from dashboard.report.parts.next_steps import next_steps
from dashboard.report.parts.statement import statement
from dashboard.report.words import Words

TONES: Final[dict[str, Tone]] = {
    "pass": "ok",
    "fail": "alarm",
    "cannot tell": "warning",
    "no limit": "missing",
}

ICONS: Final[dict[Tone, str]] = {
    "ok": "✓",
    "alarm": "▲",
    "warning": "◆",
    "quality": "?",
    "missing": "–",
    "": "",
}


def verdict_of(facts: Facts) -> tuple[str, Tone]:
    """The verdict by name, and how it is shown; an epoch without a result has none."""
    tilt = facts.now.tilt
    if tilt is None:
        return "no result", "quality"
    return tilt.verdict, TONES.get(tilt.verdict, "missing")


def first_page(facts: Facts, words: Words, charts: dict[str, str]) -> FirstPage:
    """Write the first page; the sketch goes into ``charts``."""
    verdict, tone = verdict_of(facts)
    key = verdict.replace(" ", "_")
    tilt = facts.now.tilt
    limit = facts.primary_limit
    return FirstPage(
        tone=tone,
        icon=ICONS[tone],
        word=words(f"verdict.{key}"),
        sentence=words(f"verdict.{_sentence_key(facts, key)}"),
        measured_label=words("first.measured", height=f"{facts.epoch.height_m:g}"),
        measured=numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m) if tilt else numbers.MISSING,
        limit_label=words("first.limit_of", title=phrases.limit_title(limit, words))
        if _has_limit(facts)
        else words("first.limit"),
        limit=numbers.mm(tilt.allowable_m) if tilt else numbers.MISSING,
        cards=(_change(facts, words), _rate(facts, words), _tilt(facts, words), _data(facts, words)),
        statement_label=words("first.statement"),
        statement=statement(facts, words),
        next_label=words("first.next"),
        next_steps=next_steps(facts, words),
        sketch=_sketch(facts, tone, words, charts),
    )


def _sentence_key(facts: Facts, key: str) -> str:
    limit = facts.primary_limit
    if limit is not None and limit.kind == "measurement" and key in ("pass", "fail", "cannot_tell"):
        return f"{key}_measurement"
    if key == "cannot_tell" and facts.now.tilt is not None and facts.now.tilt.deviation_sigma_m is None:
        return "cannot_tell_without_sigma"
    return f"{key}_sentence"


def _has_limit(facts: Facts) -> bool:
    return facts.primary_limit is not None and facts.primary_limit.document is not None


def _change(facts: Facts, words: Words) -> Card:
    change = facts.now.change
    label = words("card.change")
    if change is None:
        return Card(label, numbers.MISSING, _no_change(facts, words), "missing")
    label = words("card.change_since", reference=change.reference_epoch)
    value = numbers.mm_with_u(change.d_top_m, change.sigma_top_m)
    if change.significant is None:
        return Card(label, value, words("card.significance_unknown"), "quality")
    p_value = phrases.p_value(change.p_value)
    key = "card.significant" if change.significant else "card.not_significant"
    note = words(key, p=p_value, detectable=numbers.mm(change.smallest_detectable_m))
    return Card(label, value, note, "warning" if change.significant else "ok")


def _no_change(facts: Facts, words: Words) -> str:
    if facts.epoch.is_reference:
        return words("card.is_reference")
    return words("card.no_result") if facts.now.tilt is None else words("card.reference_without_result")


def _rate(facts: Facts, words: Words) -> Card:
    label, trend = words("card.rate"), facts.trend
    if trend is None:
        return Card(
            label,
            numbers.MISSING,
            words("card.trend_goes_on" if facts.trend_goes_on else "card.no_trend"),
            "missing",
        )
    if trend.rate_m_per_year is None:
        return Card(label, numbers.MISSING, words("card.no_rate", epochs=trend.n_epochs), "missing")
    unit = words("card.mm_per_year")
    value = numbers.mm_with_u(trend.rate_m_per_year, trend.rate_sigma_m_per_year, f" {unit}")
    if not trend.rate_significant:
        return Card(
            label, value, words("card.rate_not_significant", p=phrases.p_value(trend.rate_p_value)), "ok"
        )
    return Card(label, value, phrases.limit_date(trend, words), "warning")


def _tilt(facts: Facts, words: Words) -> Card:
    label, tilt = words("card.tilt"), facts.now.tilt
    if tilt is None:
        return Card(label, numbers.MISSING, words("card.no_result"), "missing")
    towards = (
        words("card.no_direction")
        if tilt.azimuth_deg is None
        else words(
            "card.azimuth",
            azimuth=numbers.degrees(tilt.azimuth_deg, 1),
            compass=phrases.compass(tilt.azimuth_deg, words),
        )
    )
    note = words("card.verticality", permille=numbers.number(tilt.verticality_permille, 2), towards=towards)
    return Card(label, numbers.dms(tilt.tilt_deg), note, "")


def _data(facts: Facts, words: Words) -> Card:
    epoch = facts.epoch
    coverage = numbers.MISSING if epoch.coverage_deg is None else f"{epoch.coverage_deg:.0f}°"
    note = words(
        "card.data_note",
        used=epoch.n_stations_used,
        stations=epoch.n_stations,
        coverage=coverage,
        points=numbers.count(epoch.n_points_used),
    )
    tone: Tone = "ok" if epoch.state == "ok" else "quality"
    return Card(words("card.data"), words.named("state", epoch.state), note, tone)


def _sketch(facts: Facts, tone: Tone, words: Words, charts: dict[str, str]) -> Chart | Missing:
    tilt, settings = facts.now.tilt, facts.settings
    if tilt is None:
        return Missing(words("first.sketch"), words("card.no_result"))
    if settings is None:
        return Missing(words("first.sketch"), words("method.no_settings"))
    leaning = sketch.Leaning(
        tilt.height_m,
        settings.shaft_z_m,
        settings.radius_m,
        tilt.deviation_m,
        tilt.deviation_sigma_m,
        tilt.allowable_m,
        tilt.azimuth_deg,
    )
    colour = theme.TONES[tone].ink if tone in theme.TONES else theme.INK
    charts["sketch"] = sketch.chart(leaning, colour, words)
    described = words("first.sketch_described", factor=sketch.factor_of(leaning))
    return Chart("sketch", words("first.sketch"), "", described)
