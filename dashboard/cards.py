"""The four cards of the overview: limit, change, rate, data. A word, the number with its uncertainty, what it rests on."""

from collections.abc import Mapping, Sequence
from typing import Final

from dash import dcc, html
from dash.development.base_component import Component

from dashboard import numbers
from dashboard.content.movement import Movement
from dashboard.panel import Panel
from dashboard.series_panels import no_movement, trend_of
from dashboard.shell import badge
from dashboard.theme import TONES, VERDICTS
from dashboard.view import View
from storage.records import TiltRow, TrendRow

_VERDICT_WORDS: Final = {
    "pass": "WITHIN LIMIT",
    "fail": "LIMIT EXCEEDED",
    "cannot tell": "CANNOT TELL",
    "no limit": "NO LIMIT",
}
_STATES: Final = {"ok": "WHOLE", "degraded": "INCOMPLETE", "failed": "FAILED"}
_MANY: Final = 2.0
"""From so many times the limit on, it is said in times and not in per cent."""


def cards(view: View, movements: Mapping[str, Movement]) -> list[Panel]:
    """Make the four cards of the epoch that is shown."""
    return [_limit(view), _change(view, movements), _rate(view), _data(view)]


def _card(name: str, title: str, big: Component, small: Sequence[str], opens: str) -> Panel:
    lines = [html.Div(line, className="small") for line in small if line]
    return Panel(
        name, title, dcc.Link([html.Div(big, className="big"), *lines], href=opens, className="card"), span=3
    )


def _limit(view: View) -> Panel:
    tilt, to = view.condition.tilt, view.asked.at("series").href
    if tilt is None:
        reason = view.epoch.reason or f"{'/'.join(view.site.primary)} gave no axis"
        return _card(
            "limit", "Limit", badge(TONES["missing"], "NO RESULT", id="verdict"), [numbers.brief(reason)], to
        )
    word = badge(TONES[VERDICTS[tilt.verdict]], _VERDICT_WORDS[tilt.verdict], id="verdict")
    lines = [numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m), _allowed(tilt), _share(tilt)]
    return _card("limit", "Limit", word, lines, to)


def _allowed(tilt: TiltRow) -> str:
    if tilt.allowable_m is None:
        return tilt.verdict_reason or "no limit is stated"
    return f"{numbers.mm(tilt.allowable_m)} allowed at {numbers.number(tilt.height_m, 1)} m"


def _share(tilt: TiltRow) -> str:
    if not tilt.allowable_m:
        return ""
    share = tilt.deviation_m / tilt.allowable_m
    return f"{share:.1f} times what is allowed" if share >= _MANY else f"{share:.0%} of what is allowed"


def _change(view: View, movements: Mapping[str, Movement]) -> Panel:
    to = view.asked.at("series").href
    reference, found = view.reference, movements.get(view.epoch.epoch)
    title = f"Change since {reference.epoch}" if reference else "Change"
    if found is None:
        is_first = reference is not None and reference.epoch == view.epoch.epoch
        why = "changes are counted from this epoch" if is_first else no_movement(view, movements)
        return _card(
            "change",
            title,
            badge(TONES["missing"], "NO CHANGE TO TELL"),
            [why or "this epoch has no axis"],
            to,
        )
    word, tone = {
        True: ("MOVED", "warning"),
        False: ("NO MOVEMENT FOUND", "ok"),
        None: ("NOT TESTED", "missing"),
    }[found.significant]
    least = found.detectable_m
    lines = [
        numbers.mm_with_u(found.size_m, found.sigma_m),
        "" if found.p_value is None else f"chance alone does so with {numbers.p_value(found.p_value)}",
        f"covariance: {found.basis}" if least is None else f"{numbers.mm(least)} or more would be found",
    ]
    return _card("change", title, badge(TONES[tone], word, id="moved"), lines, to)


def _rate(view: View) -> Panel:
    to, trend = view.asked.at("series").href, trend_of(view)
    if trend is None or trend.rate_m_per_year is None:
        why = trend.reason if trend else "no trend yet: it takes more epochs with an axis and a covariance"
        return _card("rate", "Rate", badge(TONES["missing"], "NO RATE"), [why], to)
    word, tone = ("MOVING", "warning") if trend.rate_significant else ("NO TREND FOUND", "ok")
    lines = [
        numbers.mm_with_u(trend.rate_m_per_year, trend.rate_sigma_m_per_year, " mm/a"),
        f"{trend.n_epochs} epochs, {trend.first_epoch} to {trend.last_epoch}, {numbers.p_value(trend.rate_p_value)}",
        _reached(view, trend),
    ]
    return _card("rate", "Rate", badge(TONES[tone], word), lines, to)


def _reached(view: View, trend: TrendRow) -> str:
    tilt = view.condition.tilt
    if not trend.rate_significant or trend.limit_reached_at is None:
        return ""
    if trend.last_time > view.epoch.epoch_time:
        return "of epochs after this one, too"
    if tilt is not None and tilt.allowable_m is not None and tilt.deviation_m > tilt.allowable_m:
        return "the limit is exceeded already"
    span = f"{numbers.day(trend.limit_earliest_at)} to {numbers.day(trend.limit_latest_at)}"
    return f"limit reached about {numbers.day(trend.limit_reached_at)} ({span})"


def _data(view: View) -> Panel:
    epoch, condition = view.epoch, view.condition
    tone = TONES["ok"] if epoch.state == "ok" else TONES["quality"]
    covered = (
        "coverage unknown"
        if epoch.coverage_deg is None
        else f"{epoch.coverage_deg:.0f}° of the circumference seen"
    )
    lines = [
        f"{epoch.n_stations_used} of {epoch.n_stations} stations",
        f"{numbers.count(epoch.n_points_used)} points on the shaft, {covered}",
        numbers.brief(epoch.reason),
        "one more station would help" if condition.lacks_a_station else "",
    ]
    return _card(
        "data",
        "Data",
        badge(tone, _STATES.get(epoch.state, epoch.state.upper())),
        lines,
        view.asked.at("quality").href,
    )
