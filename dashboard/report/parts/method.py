"""How it was measured: method, instrument, stations, and what other means found."""

from dashboard import numbers
from dashboard.report.blocks import Beside, Block, Chart, Missing, Pairs, Section, Table, Text
from dashboard.report.charts import coverage, stations
from dashboard.report.facts import Facts
from dashboard.report.parts import phrases
from dashboard.report.words import Words
from storage.records import REGISTERED, StationRow


def section(facts: Facts, words: Words, charts: dict[str, str]) -> Section:
    """Write the chapter."""
    blocks: list[Block] = [
        Text(_text(facts, words)),
        Beside((_instrument(facts, words), _work(facts, words)), (0.5, 0.5)),
        Beside((_map(facts, words, charts), _table(facts, words)), (0.44, 0.56)),
        _references(facts, words),
        _coverage(facts, words, charts),
    ]
    return Section(words("method.title"), tuple(blocks))


def _text(facts: Facts, words: Words) -> str:
    came_registered = bool(facts.stations) and all(row.start == REGISTERED for row in facts.stations)
    key = "method.text_registered" if came_registered else "method.text"
    return words(key, way=phrases.way(*facts.primary), about=_about(facts, words))


def _about(facts: Facts, words: Words) -> str:
    return words.said.get(f"method.about_{facts.primary[1]}", words("method.about_other"))


def _instrument(facts: Facts, words: Words) -> Block:
    settings = facts.settings
    if settings is None:
        return Missing(words("method.instrument"), words("method.no_settings"))
    horizontal, vertical = settings.position_sigma_m
    temperature = settings.temperatures_c.get(facts.epoch.epoch)
    pairs = (
        (
            words("method.structure"),
            f"{words.named('structure', settings.kind)}, H = {settings.height_m:g} m",
        ),
        (words("method.range"), f"{numbers.mm(settings.range_sigma_m)} / 100 m"),
        (words("method.angle"), numbers.number(3600.0 * settings.angle_sigma_deg, 1) + "″"),
        (words("method.level"), numbers.number(3600.0 * settings.level_sigma_deg, 1) + "″"),
        (words("method.position"), f"{numbers.mm(horizontal)} / {numbers.mm(vertical)}"),
        (words("method.heading"), numbers.degrees(settings.heading_sigma_deg, 3)),
        (words("method.temperature"), numbers.number(temperature, 1, "°C")),
    )
    return Pairs(pairs)


def _work(facts: Facts, words: Words) -> Pairs:
    epoch, tilt = facts.epoch, facts.now.tilt
    shaft = numbers.MISSING
    if facts.settings is not None:
        low, high = facts.settings.shaft_z_m
        shaft = f"{low:g} – {high:g} m"
    source = numbers.MISSING
    if tilt is not None and tilt.covariance_source is not None:
        source = words.named("source", tilt.covariance_source)
    pairs = (
        (words("method.measured"), numbers.minute(epoch.epoch_time)),
        (words("method.frame"), _frame(facts, words)),
        (words("method.shaft"), shaft),
        (words("method.points_in"), numbers.count(epoch.n_points_in)),
        (words("method.points_used"), numbers.count(epoch.n_points_used)),
        (words("method.slices"), numbers.MISSING if tilt is None else f"{tilt.n_centres} / {tilt.n_slices}"),
        (words("method.covariance"), source),
    )
    return Pairs(pairs)


def _frame(facts: Facts, words: Words) -> str:
    if facts.settings is None:
        return numbers.MISSING
    horizontal = facts.settings.horizontal
    return (
        words("method.local_frame") if horizontal == "local" else f"EPSG:{horizontal.removeprefix('EPSG:')}"
    )


def _map(facts: Facts, words: Words, charts: dict[str, str]) -> Block:
    placed = [
        stations.Pin(row.station, row.position_east_m, row.position_north_m, row.state)
        for row in facts.stations
        if row.position_east_m is not None and row.position_north_m is not None
    ]
    if not placed:
        why = words("method.no_stations" if not facts.stations else "method.no_positions")
        return Missing(words("method.map"), why)
    tilt, settings = facts.now.tilt, facts.settings
    foot = settings.base_xy_m if settings else (0.0, 0.0)
    if tilt is not None:
        foot = (tilt.base_east_m, tilt.base_north_m)
    radius = max(settings.radius_m) if settings else 1.0
    shown = stations.StationMap(
        placed,
        foot,
        radius,
        tilt.azimuth_deg if tilt else None,
        facts.epoch.next_station_azimuth_deg if facts.now.lacks_a_station else None,
    )
    charts["stations"] = stations.chart(shown, words)
    return Chart("stations", words("method.map"), words("method.map_note"), words("method.map_described"))


def _table(facts: Facts, words: Words) -> Block:
    title = words("method.stations")
    if not facts.stations:
        return Missing(title, words("method.no_stations"))
    head = ("station", "east", "north", "rms", "overlap", "sigma", "level", "state")
    return Table(
        title,
        tuple(words(f"stations.{name}") for name in head),
        "lrrrrrrl",
        tuple(_station(row, words) for row in facts.stations),
        note=words("stations.note"),
        marked=tuple(place for place, row in enumerate(facts.stations) if row.state != "ok"),
        small=True,
    )


def _station(row: StationRow, words: Words) -> tuple[str, ...]:
    level = None if row.sigma_level_deg is None else 3600.0 * row.sigma_level_deg
    overlap = None if row.overlap is None else 100.0 * row.overlap
    return (
        row.station,
        numbers.number(row.position_east_m, 1),
        numbers.number(row.position_north_m, 1),
        numbers.mm(row.rmse_m, unit=""),
        numbers.number(overlap, 0),
        numbers.mm(row.sigma_position_m, unit=""),
        numbers.number(level, 1),
        words.named("state", row.state),
    )


def _references(facts: Facts, words: Words) -> Block:
    title = words("references.title")
    if not facts.references:
        return Missing(title, words("references.none"))
    differences = {row.compared: row for row in facts.comparison if row.scheme is None}
    rows = []
    for row in facts.references:
        beside = differences.get(row.source)
        rows.append(
            (
                row.source,
                numbers.mm_with_u(row.deviation_m, row.deviation_sigma_m),
                numbers.degrees(row.azimuth_deg, 2),
                numbers.mm_with_u(beside.d_top_m, beside.d_sigma_top_m) if beside else numbers.MISSING,
                numbers.probability(beside.p_value) if beside else numbers.MISSING,
                _significance(beside.significant if beside else None, words),
            )
        )
    head = ("source", "deviation", "azimuth", "difference", "p", "agree")
    return Table(title, tuple(words(f"references.{name}") for name in head), "lrrrrl", tuple(rows))


def _significance(significant: bool | None, words: Words) -> str:
    if significant is None:
        return numbers.MISSING
    return words("references.disagrees" if significant else "references.agrees")


def _coverage(facts: Facts, words: Words, charts: dict[str, str]) -> Block:
    title = words("quality.coverage")
    if not facts.coverage:
        return Missing(title, words("quality.no_coverage"))
    charts["coverage"] = coverage.chart(facts.coverage, words)
    empty = sum(row.n_points == 0 for row in facts.coverage)
    note = words("quality.coverage_note", empty=empty, all=len(facts.coverage))
    return Chart("coverage", title, note, words("quality.coverage_described"))
