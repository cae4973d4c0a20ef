"""P10: which runs made the results, of which inputs, by which code, how long it took; and the tables to take along."""

from collections.abc import Sequence
from typing import Final
from urllib.parse import quote, urlencode

from dash import dcc, html
from dash.development.base_component import Component

from dashboard import numbers
from dashboard.content.runs import Run, bars, runs_of
from dashboard.content.sheet import Head, Shown, gap
from dashboard.figures.runs import timeline
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.shell import badge
from dashboard.tables import Cell, copied, missing, row, table, words
from dashboard.theme import TONES
from dashboard.view import View
from storage.errors import UsageError
from storage.records import StageRunRow, StationRow, columns_of
from storage.views import (
    VIEWS,
    VersionChangeRow,
    VersionRow,
    run_rows_of,
    station_rows,
    version_change_rows,
    version_rows,
)

MOST_RUNS: Final = 40


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of the runs."""
    rows = view.reader.ask(run_rows_of, view.structure)
    found = runs_of(rows)
    of_epoch = [row for row in rows if row.epoch == view.epoch.epoch]
    run = _chosen(view, found, of_epoch)
    stages = [row for row in of_epoch if row.run == run]
    return [
        _runs_panel(view, found, run, rows),
        _origin_panel(view),
        _inputs_panel(view),
        _timeline_panel(view, run, stages),
        _stages_panel(view, run, stages),
        _versions_panel(view),
        _version_changes_panel(view),
        _downloads_panel(view),
    ]


PAGE = Page("runs", 10, "Runs", "Which run made this, of which inputs, by which code?", fill)


def _chosen(view: View, found: Sequence[Run], of_epoch: Sequence[StageRunRow]) -> str | None:
    """The run whose stages are shown: the reader's, else the newest that processed the epoch."""
    wanted = view.asked.more.get("run")
    known = [run.run for run in found]
    if wanted is not None and wanted not in known:
        raise UsageError(f"unknown run {wanted!r}; known: {', '.join(known) or 'none'}")
    return wanted or next((name for name in known if any(row.run == name for row in of_epoch)), None)


def _table_of(rows: Sequence[object], record: type) -> Table:
    names = [column.name for column in columns_of(record)]
    return Table(names, [[getattr(each, name) for name in names] for each in rows])


_RUN_HEAD: Final = (
    Head("run", is_number=False),
    Head("began", is_number=False),
    Head("epochs", is_number=False),
    Head("computed"),
    Head("cached"),
    Head("refused", means="stages with bad input"),
    Head("failed", means="faults of the program"),
    Head("stages took, s", means="sum of the stages that were computed"),
    Head("peak memory, MB", means="largest memory of a process"),
)


def _runs_panel(view: View, found: Sequence[Run], shown: str | None, rows: Sequence[StageRunRow]) -> Panel:
    lines = [
        row(_RUN_HEAD, _run_cells(view, run), "here" if run.run == shown else "") for run in found[:MOST_RUNS]
    ]
    return Panel(
        "runs",
        f"{len(found)} runs of {view.site.name}" if len(found) != 1 else f"One run of {view.site.name}",
        table(_RUN_HEAD, lines, fluid=True),
        _table_of(rows, StageRunRow),
        span=12,
        missing=None if found else "the ledger tells of no run of this structure",
        note=f"The newest {MOST_RUNS}; the CSV has the stages of all." if len(found) > MOST_RUNS else None,
    )


def _run_cells(view: View, run: Run) -> list[Cell]:
    cached = "all its stages came from the cache"
    return [
        dcc.Link(run.run, href=view.asked.with_more(run=run.run).href),
        numbers.minute(run.began_at),
        words(", ".join(run.epochs)),
        Shown(numbers.count(run.computed)),
        Shown(numbers.count(run.cached)),
        Shown(numbers.count(run.refused)),
        Shown(numbers.count(run.failed)),
        gap(cached) if run.seconds is None else Shown(numbers.number(run.seconds, 1)),
        gap(cached) if run.peak_rss_mb is None else Shown(numbers.number(run.peak_rss_mb, 0)),
    ]


def _origin_panel(view: View) -> Panel:
    epoch = view.epoch
    facts = (
        ("run that published it", epoch.run),
        ("settings of the campaign, SHA-256", epoch.campaign_digest),
        ("code, digest", epoch.code_version),
    )
    body = [html.Div([html.P(name, className="does"), copied(value)]) for name, value in facts]
    return Panel(
        "origin",
        f"Where epoch {epoch.epoch} comes from",
        html.Div(body),
        Table([name for name, _ in facts], [[value for _, value in facts]]),
        span=5,
        note=f"The same settings, code and scans give the same results. Version {epoch.schema_version} of the tables.",
    )


def _timeline_panel(view: View, run: str | None, stages: Sequence[StageRunRow]) -> Panel:
    return Panel(
        "timeline",
        f"Epoch {view.epoch.epoch} in run {run}" if run else f"Epoch {view.epoch.epoch}",
        timeline(bars(stages)) if stages else None,
        _table_of(stages, StageRunRow),
        span=5,
        missing=None if stages else _no_stage(run),
        note="Stages that ran side by side overlap." if stages else None,
    )


def _no_stage(run: str | None) -> str:
    return f"run {run} did not process this epoch" if run else "the ledger tells of no run of this epoch"


_STAGE_HEAD: Final = (
    Head("stage", is_number=False),
    Head("state", is_number=False),
    Head("outcome", is_number=False),
    Head("seconds"),
    Head("points"),
    Head("peak, MB", means="largest memory of the process so far"),
    Head("code", is_number=False, means="digest of all code that the stage reaches"),
    Head("record", is_number=False, means="key of the stage's record"),
)


def _stages_panel(view: View, run: str | None, stages: Sequence[StageRunRow]) -> Panel:
    lines = [row(_STAGE_HEAD, _stage_cells(each)) for each in stages]
    return Panel(
        "stages",
        f"{len(stages)} stages of epoch {view.epoch.epoch}" if stages else "Stages",
        html.Div(table(_STAGE_HEAD, lines), className="tall high"),
        _table_of(stages, StageRunRow),
        span=7,
        missing=None if stages else _no_stage(run),
    )


def _stage_cells(each: StageRunRow) -> list[Cell]:
    cached = "it came from the cache"
    outcome: Cell = each.outcome
    if each.outcome != "ok":
        outcome = [
            html.Div(badge(TONES["quality"], each.outcome.upper())),
            words(each.reason or "no reason is stored"),
        ]
    return [
        each.stage,
        each.state,
        outcome,
        gap(cached) if each.seconds is None else Shown(numbers.number(each.seconds, 3)),
        gap("the stage has none") if each.points is None else Shown(numbers.count(each.points)),
        gap(cached) if each.peak_rss_mb is None else Shown(numbers.number(each.peak_rss_mb, 0)),
        _digest(each.code_version),
        _digest(each.cache_key),
    ]


def _digest(value: str | None, why: str = "not stored") -> Component:
    """The beginning of a digest; the whole of it is its title."""
    if value is None:
        return missing(why)
    return html.Code(value if len(value) <= 14 else f"{value[:12]}…", title=value)


_INPUT_HEAD: Final = (
    Head("station", is_number=False),
    Head("points read"),
    Head("SHA-256 of the scan", is_number=False),
    Head("state", is_number=False),
)


def _inputs_panel(view: View) -> Panel:
    stations = view.reader.ask(station_rows, view.structure, view.epoch.epoch)
    why = "the scan could not be read"
    lines = [
        row(
            _INPUT_HEAD,
            [
                each.station,
                gap(why) if each.n_points is None else Shown(numbers.count(each.n_points)),
                missing(why) if each.scan_digest is None else html.Code(each.scan_digest),
                each.state,
            ],
        )
        for each in stations
    ]
    return Panel(
        "inputs",
        f"Scans of epoch {view.epoch.epoch}",
        table(_INPUT_HEAD, lines),
        _table_of(stations, StationRow),
        span=7,
        missing=None if stations else "no scan is stored of this epoch",
        note="sha256sum FILE gives the same of a scan." if stations else None,
    )


_VERSION_HEAD: Final = (
    Head("version", is_number=False),
    Head("epoch", is_number=False),
    Head("put aside", is_number=False),
    Head("why", is_number=False),
    Head("run", is_number=False),
    Head("state", is_number=False),
    Head("code", is_number=False),
    Head("settings", is_number=False),
)


def _versions_panel(view: View) -> Panel:
    found = list(reversed(view.reader.ask(version_rows, view.structure)))
    damaged = "the row of the epoch was damaged"
    lines = [
        row(
            _VERSION_HEAD,
            [
                each.version,
                each.epoch,
                numbers.minute(each.archived_at),
                words(each.why),
                missing(damaged) if each.run is None else each.run,
                missing(damaged) if each.state is None else each.state,
                _digest(each.code_version, damaged),
                _digest(each.campaign_digest, damaged),
            ],
        )
        for each in found
    ]
    return Panel(
        "versions",
        "Earlier results that were put aside",
        html.Div(table(_VERSION_HEAD, lines, fluid=True), className="tall"),
        _table_of(found, VersionRow),
        span=6,
        missing=None if found else "no epoch was ever processed anew",
    )


_CHANGE_HEAD: Final = (
    Head("version", is_number=False),
    Head("epoch", is_number=False),
    Head("scheme", is_number=False),
    Head("outcome", is_number=False),
    Head("now minus then, mm"),
    Head("in sigmas", means="root of d' C^-1 d with the earlier covariance"),
    Head("sigma ratio", means="sigma of a component of the lean now over then"),
    Head("verdict", is_number=False),
)


def _version_changes_panel(view: View) -> Panel:
    versions = list(dict.fromkeys(each.version for each in view.reader.ask(version_rows, view.structure)))
    found = [
        each
        for version in reversed(versions)
        for each in view.reader.ask(version_change_rows, view.structure, version)
    ]
    shown = [each for each in found if (each.scheme, each.method) == view.result]
    return Panel(
        "version-changes",
        f"What became of them, {'/'.join(view.result)}",
        html.Div(
            table(_CHANGE_HEAD, [row(_CHANGE_HEAD, _change_cells(each)) for each in shown]), className="tall"
        ),
        _table_of(found, VersionChangeRow),
        span=6,
        missing=None if shown else "nothing that was put aside has this scheme and method",
        note="What another code or setting made of the same scans, no movement." if shown else None,
    )


def _change_cells(each: VersionChangeRow) -> list[Cell]:
    why = "it has no axis now" if each.outcome == "gone" else "the earlier covariance is unknown"
    verdict = f"{each.verdict_before} → {each.verdict_now or numbers.MISSING}"
    return [
        each.version,
        each.epoch,
        f"{each.scheme}/{each.method}",
        each.outcome,
        gap(why) if each.d_top_m is None else Shown(numbers.mm(each.d_top_m, 2, "")),
        gap(why) if each.d_sigmas is None else Shown(numbers.number(each.d_sigmas, 2)),
        gap(why) if each.sigma_ratio is None else Shown(numbers.number(each.sigma_ratio, 2)),
        verdict if each.verdict_changed else each.verdict_before,
    ]


def _downloads_panel(view: View) -> Panel:
    query = urlencode({"structure": view.structure})
    links = [
        html.A(f"{name}.{kind}", href=f"/view/{quote(name)}.{kind}?{query}", download="", className="chip")
        for kind in ("csv", "parquet")
        for name in VIEWS
    ]
    return Panel(
        "downloads",
        f"All tables of {view.structure}",
        html.Div(links, className="chips"),
        span=12,
        note="All epochs, unrounded, times in UTC, what does not exist is empty; the data dictionary says what each column "
        "means.",
    )
