"""The axis from foot to top, and the cross sections that fit worst."""

from dashboard import numbers
from dashboard.content.direction import direction_of
from dashboard.content.profile import profile_of, shaft_of
from dashboard.report.blocks import Beside, Block, Chart, Missing, Pairs, Section
from dashboard.report.charts import profile
from dashboard.report.facts import Facts
from dashboard.report.parts import worst_slices
from dashboard.report.words import Words
from storage.records import ChangeTestRow


def section(facts: Facts, words: Words, charts: dict[str, str]) -> Section:
    """Write the chapter."""
    blocks: list[Block] = [
        _profile(facts, words, charts),
        _form(facts, words),
        *worst_slices.blocks(facts, words, charts),
    ]
    return Section(words("shape.title"), tuple(blocks))


def _profile(facts: Facts, words: Words, charts: dict[str, str]) -> Block:
    title, tilt = words("shape.profile"), facts.now.tilt
    if tilt is None:
        return Missing(title, words("card.no_result"))
    parameters = [row for row in facts.parameters if (row.scheme, row.method) == facts.primary]
    shown = profile_of(tilt, facts.primary_slices, parameters, direction_of(tilt), shaft_of(facts.coverage))
    if not len(shown.z_m):
        return Missing(title, words("shape.no_centres"))
    charts["profile"] = profile.chart(shown, words)
    told = [row for row in facts.primary_slices if row.residual_m is not None]
    note = words("shape.profile_note") if told else words("shape.no_residuals")
    return Chart("profile", title, note, words("shape.profile_described"))


def _form(facts: Facts, words: Words) -> Block:
    tilt = facts.now.tilt
    if tilt is None:
        return Missing(words("shape.form"), words("card.no_result"))
    bending = _test(facts, "bending")
    model = words.named("model", tilt.axis_model) if tilt.axis_model else numbers.MISSING
    pairs = (
        (words("shape.model"), model),
        (words("shape.bending"), numbers.mm(tilt.bending_m, 2)),
        (words("shape.rmse"), numbers.mm(tilt.rmse_m, 2)),
        (words("shape.mean_deviation"), numbers.mm(tilt.mean_deviation_m, 2)),
        (words("shape.bending_change"), _change(bending, words)),
        (words("shape.base_change"), _change(_test(facts, "base"), words)),
    )
    return Beside((Pairs(pairs[:3]), Pairs(pairs[3:])), (0.5, 0.5))


def _test(facts: Facts, quantity: str) -> ChangeTestRow | None:
    found = [
        row for row in facts.tests if (row.scheme, row.method) == facts.primary and row.quantity == quantity
    ]
    return found[0] if found else None


def _change(test: ChangeTestRow | None, words: Words) -> str:
    if test is None or test.size_m is None:
        return numbers.MISSING
    size = numbers.mm_with_u(test.size_m, test.sigma_m)
    if test.significant is None:
        return size
    return f"{size} ({words('word.significant' if test.significant else 'word.not_significant')})"
