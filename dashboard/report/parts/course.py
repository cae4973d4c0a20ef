"""How the lean came about: the series over the epochs, and the top in the plan."""

from dashboard import numbers
from dashboard.content.plan import tops
from dashboard.content.series import series_points
from dashboard.report.blocks import Block, Chart, Missing, Section, Table
from dashboard.report.charts import plan, series
from dashboard.report.facts import Facts
from dashboard.report.words import Words
from storage.views.condition import Condition


def section(facts: Facts, words: Words, charts: dict[str, str]) -> Section:
    """Write the chapter."""
    blocks: list[Block] = [_series(facts, words, charts), _plan(facts, words, charts), _table(facts, words)]
    return Section(words("course.title"), tuple(blocks))


def _series(facts: Facts, words: Words, charts: dict[str, str]) -> Block:
    tilts = [each.tilt for each in facts.history if each.tilt is not None]
    if not tilts:
        return Missing(words("course.series"), words("card.no_result"))
    points = series_points([each.epoch for each in facts.history], tilts)
    absolute = [
        series.Mark(
            point.epoch,
            point.time,
            point.tilt.deviation_m if point.tilt else None,
            point.tilt.deviation_sigma_m if point.tilt else None,
            point.doubtful,
        )
        for point in points
    ]
    changes = [_change(each) for each in facts.history if each.change is not None]
    reference = facts.changes[-1].reference_epoch if facts.changes else None
    shown = series.Series(absolute, changes, tilts[-1].allowable_m, tilts[-1].height_m, reference)
    charts["series"] = series.chart(shown, words)
    return Chart(
        "series", words("course.series"), words("course.series_note"), words("course.series_described")
    )


def _change(each: Condition) -> series.Mark:
    change = each.change
    if change is None:
        raise ValueError(f"epoch {each.epoch.epoch} has no change")
    return series.Mark(
        change.epoch,
        change.epoch_time,
        change.d_top_m,
        change.sigma_top_m,
        each.epoch.state != "ok",
        change.significant,
        change.smallest_detectable_m,
    )


def _plan(facts: Facts, words: Words, charts: dict[str, str]) -> Block:
    tilts = [each.tilt for each in facts.history if each.tilt is not None]
    if not tilts:
        return Missing(words("course.plan"), words("card.no_result"))
    charts["plan"] = plan.chart(tops(tilts), tilts[-1].allowable_m, words)
    return Chart("plan", words("course.plan"), words("course.plan_note"), words("course.plan_described"))


def _table(facts: Facts, words: Words) -> Table:
    head = ("epoch", "date", "deviation", "azimuth", "change", "significant", "detectable", "state")
    return Table(
        words("course.table"),
        tuple(words(f"course.{name}") for name in head),
        "llrrrlrl",
        tuple(_row(each, words) for each in facts.history[-24:]),
        note=words("course.table_cut", count=len(facts.history) - 24) if len(facts.history) > 24 else "",
        small=True,
    )


def _row(each: Condition, words: Words) -> tuple[str, ...]:
    tilt, change = each.tilt, each.change
    significant = change.significant if change else None
    word = numbers.MISSING if significant is None else words("word.yes" if significant else "word.no")
    return (
        each.epoch.epoch,
        numbers.day(each.epoch.epoch_time),
        numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m, "") if tilt else numbers.MISSING,
        numbers.degrees(tilt.azimuth_deg) if tilt else numbers.MISSING,
        numbers.mm_with_u(change.d_top_m, change.sigma_top_m, "") if change else numbers.MISSING,
        word,
        numbers.mm(change.smallest_detectable_m, unit="") if change else numbers.MISSING,
        words.named("state", each.epoch.state),
    )
