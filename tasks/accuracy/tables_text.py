"""Tables 1 to 3 of the paper as lines of plain text, with the uncertainties that the paper lacks."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

from storage.records import TiltRow
from tasks.accuracy.grid_text import NO_VALUE, Line, degrees_minutes_seconds, grid, number
from tasks.accuracy.tables import Comparison, ComparisonTable, FittingTable, MonitoringTable
from tasks.accuracy.workload import RECOMMENDATIONS, savings, workload_factors

UPDATE_WEIGHT_NOTE: Final = (
    "update weight ratio: share of the centres whose weight is below half of the largest; "
    "effective centres: (sum w)^2 / sum w^2; both are our definitions, the paper gives none"
)
AZIMUTH_NOTE: Final = (
    "beta: eq. 19 of the paper, an angle in space near 90° for every small tilt; "
    "azimuth: the direction of lean, clockwise from grid north"
)
CONTROL_NOTE: Final = (
    "relative errors (eq. 23) count from the control, which is no truth unless it was measured"
)


def fitting_lines(table: FittingTable) -> list[str]:
    """Table 1: the fit of the axis, lengths in millimetres."""
    rows = table.rows
    mean = (NO_VALUE,)
    lines = [
        Line("centres in the fit", _cells(rows, lambda r: str(r.n_centres)) + mean),
        Line("iterations", _cells(rows, lambda r: number(r.iterations, 0)) + mean),
        Line("update weight ratio (%)", _cells(rows, lambda r: number(r.update_weight_ratio_pct, 1)) + mean),
        Line("effective centres", _cells(rows, lambda r: number(r.n_effective, 1)) + mean),
        Line(
            "mean deviation (mm)",
            (
                *_cells(rows, lambda r: number(r.mean_deviation_m, 1, 1e3)),
                number(table.mean_mean_deviation_m, 1, 1e3),
            ),
        ),
        Line(
            "root mean square error (mm)",
            (*_cells(rows, lambda r: number(r.rmse_m, 1, 1e3)), number(table.mean_rmse_m, 1, 1e3)),
        ),
        Line("bending (mm)", _cells(rows, lambda r: number(r.bending_m, 1, 1e3)) + mean),
    ]
    title = f"Table 1. Fit of the axis, {_of(rows[0])}"
    return [*grid(title, [*_schemes(rows), "mean"], lines), UPDATE_WEIGHT_NOTE]


def monitoring_lines(table: MonitoringTable) -> list[str]:
    """Table 2: what was found, sigmas of one standard deviation below each figure."""
    rows = table.rows
    lines = [
        Line("slices", _cells(rows, lambda r: str(r.n_slices))),
        Line("centres of contours", _cells(rows, lambda r: str(r.n_centres))),
        Line("direction east", _cells(rows, lambda r: number(r.d_east, 8))),
        Line("direction north", _cells(rows, lambda r: number(r.d_north, 8))),
        Line("direction up", _cells(rows, lambda r: number(r.d_up, 8))),
        Line("beta, eq. 19 (d m s)", _cells(rows, lambda r: degrees_minutes_seconds(r.beta_deg))),
        Line("azimuth (d m s)", _cells(rows, lambda r: degrees_minutes_seconds(r.azimuth_deg))),
        Line("  sigma (d m s)", _cells(rows, lambda r: degrees_minutes_seconds(r.azimuth_sigma_deg))),
        Line("tilt (d m s)", _cells(rows, lambda r: degrees_minutes_seconds(r.tilt_deg))),
        Line('  sigma (")', _cells(rows, lambda r: number(r.tilt_sigma_deg, 1, 3600.0))),
        Line("verticality (permille)", _cells(rows, lambda r: number(r.verticality_permille, 2))),
        Line(f"deviation at {rows[0].height_m:g} m (m)", _cells(rows, lambda r: number(r.deviation_m, 4))),
        Line("  sigma (mm)", _cells(rows, lambda r: number(r.deviation_sigma_m, 1, 1e3))),
        Line("allowable (mm)", _cells(rows, lambda r: number(r.allowable_m, 1, 1e3))),
        Line("verdict", _cells(rows, lambda r: r.verdict)),
    ]
    return [*grid(f"Table 2. Tilt, {_of(rows[0])}", _schemes(rows), lines), AZIMUTH_NOTE]


def comparison_lines(table: ComparisonTable) -> list[str]:
    """Table 3: the schemes, their mean and the control, and the errors of eq. 23 in percent."""
    beta, azimuth = table.comparison("beta_deg"), table.comparison("azimuth_deg")
    tilt, deviation = table.comparison("tilt_deg"), table.comparison("deviation_m")
    permille = table.comparison("verticality_permille")
    lines = [
        _values("beta, eq. 19 (d m s)", beta, degrees_minutes_seconds),
        _errors(beta, 3),
        _values("azimuth (d m s)", azimuth, degrees_minutes_seconds),
        Line(
            "  difference (d m s)",
            tuple(degrees_minutes_seconds(d) for d in (*azimuth.differences, azimuth.mean_difference, None)),
        ),
        _values("tilt (d m s)", tilt, degrees_minutes_seconds),
        _errors(tilt, 2),
        _values("verticality (permille)", permille, lambda v: number(v, 2)),
        _errors(permille, 2),
        _values(f"deviation at {table.height_m:g} m (m)", deviation, lambda v: number(v, 4)),
        _errors(deviation, 2),
    ]
    title = f"Table 3. Against the control {table.control}, method {table.method}"
    columns = [*table.schemes, "mean", f"control {table.control}"]
    allowed = f"allowable deviation at {table.height_m:g} m (mm): {number(table.allowable_m, 1, 1e3)}"
    return [*grid(title, columns, lines), allowed, CONTROL_NOTE]


def workload_lines(counts: Mapping[str, int]) -> list[str]:
    """Slicing workload of the scheme of a line as a multiple of that of a column."""
    factors = {(f.scheme, f.than): f.factor for f in workload_factors(counts)}
    if not factors:
        return []
    columns = [scheme for scheme in counts if any(than == scheme for _, than in factors)]
    heads = [scheme for scheme in counts if any(of == scheme for of, _ in factors)]
    lines = [Line(a, tuple(number(factors.get((a, b)), 1) for b in columns)) for a in heads]
    return grid("Slicing workload, times that of", columns, lines)


def recommendation_lines(counts: Mapping[str, int]) -> list[str]:
    """Advice of section 5 of the paper, with the savings from the slices that were really cut."""
    lines = ["Which interval (section 5 of the paper)"]
    for case in RECOMMENDATIONS:
        saved = [f"{f.than} {f.factor:.1f} times less than {f.scheme}" for f in savings(case, counts)]
        text = f"- {case.when}: {case.advice} ({', '.join(case.schemes)}); reliability {case.reliability}"
        lines.append(f"{text}; workload of {', '.join(saved)}" if saved else text)
    return lines


def _schemes(rows: Sequence[TiltRow]) -> list[str]:
    return [row.scheme for row in rows]


def _of(row: TiltRow) -> str:
    return f"{row.structure}, epoch {row.epoch}, method {row.method}"


def _cells(rows: Sequence[TiltRow], text: Callable[[TiltRow], str]) -> tuple[str, ...]:
    return tuple(text(row) for row in rows)


def _values(label: str, line: Comparison, text: Callable[[float | None], str]) -> Line:
    return Line(label, tuple(text(value) for value in (*line.values, line.mean, line.reference)))


def _errors(line: Comparison, decimals: int) -> Line:
    errors = (*line.errors_pct, line.mean_error_pct, None)
    return Line("  relative error (%)", tuple(number(error, decimals) for error in errors))
