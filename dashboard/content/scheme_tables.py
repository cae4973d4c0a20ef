"""Tables 1 to 3 of the paper for the schemes of an epoch, with what it lacks: uncertainty, azimuth, significance, time."""

from collections.abc import Sequence

from dashboard import numbers
from dashboard.content.schemes import (
    QUANTITIES,
    TWO_CENTRES,
    Control,
    Way,
    means,
    relative_error_pct,
)
from dashboard.content.sheet import Head, Line, Sheet, Shown, gap
from storage.records import SchemeComparisonRow, TiltRow

NO_COVARIANCE = "no covariance of the axis is stored"
NO_DIRECTION = "the lean is below 3 sigma: it has no direction"
NO_CONTROL = "the control does not have this quantity, or it is zero"
BANDS = "height bands: the whole surface is fitted at once"


def fitting_sheet(found: Sequence[Way]) -> Sheet:
    """Table 1: how the axis of each scheme was fitted."""
    head = (
        Head("scheme", is_number=False),
        Head("centres", means="centres in the axis"),
        Head("iterations"),
        Head("reweighted, %", means="share of centres whose weight is below half of the largest"),
        Head("mean deviation, mm", means="mean distance of the centres from the axis, eq. 18"),
        Head("RMS, mm", means="root mean square distance of the centres from the axis, eq. 18"),
        Head("effective centres", means="(sum of weights) squared over the sum of their squares"),
        Head("time, s", means="slicing, contours and axis, when they were computed"),
    )
    lines = [_fitting_line(way) for way in found]
    return Sheet("Fitting accuracy of the axis of each scheme", head, [*lines, *_fitting_means(found)])


def _fitting_line(way: Way) -> Line:
    tilt = way.tilt
    if tilt is None:
        return _gone(way)
    why = TWO_CENTRES if way.is_direct else "not stored"
    return Line(
        (
            Shown(way.label),
            Shown(numbers.count(tilt.n_centres)),
            _known(tilt.iterations, numbers.count(tilt.iterations), why),
            _known(tilt.update_weight_ratio_pct, numbers.number(tilt.update_weight_ratio_pct, 1), why),
            _known(tilt.mean_deviation_m, numbers.mm(tilt.mean_deviation_m, 2, ""), why),
            _known(tilt.rmse_m, numbers.mm(tilt.rmse_m, 2, ""), why),
            _known(tilt.n_effective, numbers.number(tilt.n_effective, 1), why),
            _known(way.seconds, numbers.number(way.seconds, 2), way.seconds_reason or "not stored"),
        ),
        "marked" if way.is_primary else "",
    )


def _fitting_means(found: Sequence[Way]) -> list[Line]:
    lines = []
    for method in dict.fromkeys(way.method for way in found):
        counted = [
            way.tilt
            for way in found
            if way.method == method and way.tilt is not None and way.tilt.rmse_m is not None
        ]
        if len(counted) < 2:
            continue
        schemes = ", ".join(tilt.scheme for tilt in counted)
        deviations = [tilt.mean_deviation_m for tilt in counted if tilt.mean_deviation_m is not None]
        rms = [tilt.rmse_m for tilt in counted if tilt.rmse_m is not None]
        empty = Shown("")
        deviation = numbers.mm(sum(deviations) / len(deviations), 2, "") if deviations else numbers.MISSING
        mean = Shown(numbers.mm(sum(rms) / len(rms), 2, ""))
        cells = (
            Shown(f"mean, {method}", f"of {schemes}"),
            empty,
            empty,
            empty,
            Shown(deviation),
            mean,
            empty,
            empty,
        )
        lines.append(Line(cells, "mean"))
    return lines


def monitoring_sheet(found: Sequence[Way]) -> Sheet:
    """Table 2: what each scheme says of the axis."""
    head = (
        Head("scheme", is_number=False),
        Head("slices", means="slices that were cut"),
        Head("contours", means="slices that got a contour"),
        Head("centres", means="centres in the axis"),
        Head("unit vector: east, north, up"),
        Head("β", means="tilt-azimuth of the paper, eq. 19: angle between the axis and the x axis"),
        Head("azimuth", means="direction of lean, clockwise from grid north"),
        Head("tilt", means="angle between the axis and the vertical, eq. 20"),
        Head("verticality, ‰"),
        Head("deviation, mm (k = 2)", means="height times the tangent of the tilt, eq. 22"),
        Head("verdict", is_number=False),
    )
    return Sheet("Results of each scheme", head, [_monitoring_line(way) for way in found])


def _monitoring_line(way: Way) -> Line:
    tilt = way.tilt
    if tilt is None:
        return _gone(way)
    vector = "  ".join(numbers.number(part, 8) for part in (tilt.d_east, tilt.d_north, tilt.d_up))
    whole = way.row is not None and way.row.contour == "whole surface"
    why = BANDS if whole else None
    contours = _known(way.n_contours, numbers.count(way.n_contours), "slices are not stored")
    return Line(
        (
            Shown(way.label),
            Shown(numbers.count(tilt.n_slices), why),
            contours,
            Shown(numbers.count(tilt.n_centres), why),
            Shown(vector),
            Shown(numbers.dms(tilt.beta_deg, 0)),
            _known(
                tilt.azimuth_deg,
                _with_u(tilt.azimuth_deg, tilt.azimuth_sigma_deg),
                tilt.warning or NO_DIRECTION,
            ),
            Shown(numbers.dms(tilt.tilt_deg, 0)),
            Shown(numbers.number(tilt.verticality_permille, 2)),
            _deviation(tilt),
            Shown(tilt.verdict, tilt.verdict_reason),
        ),
        "marked" if way.is_primary else "",
    )


def _with_u(value_deg: float | None, sigma_deg: float | None) -> str:
    if value_deg is None or sigma_deg is None:
        return numbers.degrees(value_deg)
    u_deg = numbers.COVERAGE * sigma_deg
    digits = numbers.digits_for(u_deg)
    return f"{numbers.number(value_deg, digits)} ± {numbers.number(u_deg, digits)}°"


def _deviation(tilt: TiltRow) -> Shown:
    text = numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m, "")
    return Shown(text, NO_COVARIANCE if tilt.deviation_sigma_m is None else tilt.warning)


def accuracy_sheet(found: Sequence[Way], control: Control) -> Sheet:
    """Table 3: relative errors against a control, eq. 23, and the mean of each method against it."""
    head = (
        Head("scheme", is_number=False),
        Head("β, %", means="relative error of the paper's tilt-azimuth"),
        Head("tilt, %"),
        Head("verticality, %"),
        Head("deviation, %"),
        Head("deviation, mm", means="value minus control"),
    )
    lines = [_accuracy_line(way, control) for way in found]
    return Sheet(f"Relative errors against {control.label}", head, [*lines, *_error_means(found, control)])


def _accuracy_line(way: Way, control: Control) -> Line:
    tilt = way.tilt
    if tilt is None:
        return _gone(way)
    if way.label == control.label:
        return Line((Shown(way.label),), "marked" if way.is_primary else "", "the control itself")
    errors = [
        relative_error_pct(getattr(tilt, quantity), control.values.get(quantity)) for quantity in QUANTITIES
    ]
    return Line(
        (
            Shown(way.label),
            *(_known(error, numbers.number(error, 3), NO_CONTROL) for error in errors),
            _apart(tilt.deviation_m, control),
        ),
        "marked" if way.is_primary else "",
    )


def _apart(value_m: float, control: Control) -> Shown:
    reference = control.values.get("deviation_m")
    return gap(NO_CONTROL) if reference is None else Shown(numbers.signed_mm(value_m - reference, 1, ""))


def _error_means(found: Sequence[Way], control: Control) -> list[Line]:
    of_all = {quantity: means(found, quantity, control) for quantity in QUANTITIES}
    lines = []
    for method, (schemes, mean_m, _) in of_all["deviation_m"].items():
        errors = [of_all[quantity][method][2] for quantity in QUANTITIES]
        cells = (
            Shown(f"mean, {method}", f"of {', '.join(schemes)}"),
            *(_known(error, numbers.number(error, 3), NO_CONTROL) for error in errors),
            _apart(mean_m, control),
        )
        lines.append(Line(cells, "mean"))
    return lines


def advice_sheet(found: Sequence[Way]) -> Sheet:
    """What each scheme costs and how sure it is; which is enough, and why."""
    head = (
        Head("scheme", is_number=False),
        Head("slices"),
        Head("points used"),
        Head("sigma, mm", means="of one component of the axis at the height of the deviation"),
        Head("above best, %", means="by how much sigma is above the smallest of the epoch"),
        Head("enough", is_number=False),
    )
    return Sheet("What each scheme costs and how sure it is", head, [_advice_line(way) for way in found])


def _advice_line(way: Way) -> Line:
    row = way.beside
    if way.tilt is None:
        return _gone(way)
    if row is None:
        return Line((Shown(way.label),), instead="it was not compared in this epoch")
    word = "recommended" if row.is_recommended else "yes" if row.is_enough else "no"
    return Line(
        (
            Shown(way.label),
            _known(row.n_slices, numbers.count(row.n_slices), "not sliced"),
            _known(row.n_points, numbers.count(row.n_points), "points are not stored"),
            _known(row.sigma_m, numbers.mm(row.sigma_m, 2, ""), NO_COVARIANCE),
            _known(row.excess_pct, numbers.number(row.excess_pct, 0), NO_COVARIANCE),
            gap(row.reason or NO_COVARIANCE) if row.is_enough is None else Shown(word, row.reason),
        ),
        "marked" if way.is_primary else "",
    )


def comparison_sheet(found: Sequence[Way], references: Sequence[SchemeComparisonRow], against: str) -> Sheet:
    """Each scheme and reference measurement minus the primary, with what the two share taken out."""
    head = (
        Head("scheme", is_number=False),
        Head("east, mm", means="difference of the axes at the height of the deviation"),
        Head("north, mm"),
        Head("length, mm (k = 2)", means="length of the difference"),
        Head("p", means="probability of such a difference or a larger one if both saw the same axis"),
        Head("significant", is_number=False, means="p below 0.01"),
    )
    lines = [_comparison_line(way, against) for way in found]
    measured = [_difference_line(row.compared, row, "") for row in references]
    return Sheet(f"Schemes minus {against}", head, [*lines, *measured])


def _comparison_line(way: Way, against: str) -> Line:
    row = way.beside
    if way.tilt is None:
        return _gone(way)
    if way.label == against:
        return Line((Shown(way.label),), "marked", "what the others are compared with")
    if row is None:
        return Line((Shown(way.label),), instead="it was not compared in this epoch")
    return _difference_line(way.label, row, "marked" if way.is_primary else "")


def _difference_line(label: str, row: SchemeComparisonRow, kind: str) -> Line:
    why = row.reason or "the covariance of the difference is unknown"
    parts = [None if part is None else row.height_m * part for part in (row.d_lean_east, row.d_lean_north)]
    length = numbers.mm_with_u(row.d_top_m, row.d_sigma_top_m, "")
    return Line(
        (
            Shown(label),
            *(_known(part, numbers.signed_mm(part, 1, ""), why) for part in parts),
            _known(row.d_top_m, length, why),
            _known(row.p_value, numbers.probability(row.p_value), why),
            _known(row.significant, "yes" if row.significant else "no", why),
        ),
        kind,
    )


def _known(value: object, text: str, why: str) -> Shown:
    return gap(why) if value is None else Shown(text)


def _gone(way: Way) -> Line:
    return Line((Shown(way.label),), "gone", f"no axis: {way.reason}")
