"""The prediction of a survey as lines for people and as an object for programs."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

from flows.terminal import Json
from tasks.conventions import ARCSEC_RAD
from tasks.design import BestPlace, Outlook, Prediction, StationOutlook
from tasks.geometry.failure import FitFailure
from tasks.geometry.plane_vectors import ELLIPSE_95
from tasks.survey_design import Design

REMEDIES: Final = {
    "noise": "the noise of the points: a finer grid or nearer stations help",
    "form": "the form of the shaft: stations all round help, more points do not",
    "level": "the level of the stations: more stations or a better compensator help, more points do not",
    "position": "the positions of the stations: better GNSS or targets help",
    "heading": "the headings of the stations: better headings, or surroundings that several stations see, help",
}

ALL_ALIKE: Final = 0.98
"""Above this ratio of best to worst sigma no direction is worth naming."""

STRIP: Final = 36
"""Signs of the coverage strip, 10 degrees each."""

STRIP_ROWS: Final = 5


def plan_lines(design: Design, outlook: Outlook, place: BestPlace | FitFailure) -> Iterator[str]:
    """Prediction, a line a statement; then coverage and stations as tables."""
    lean, height_m = outlook.lean, design.height_m
    of = f"the stations of epoch {design.epoch}" if design.epoch else _counted(len(outlook.stations))
    yield f"{design.title}: {of}, predicted for {'/'.join(design.primary)}"
    yield (
        f'lean: sigma east {_east(lean) / ARCSEC_RAD:.2f}", north {_north(lean) / ARCSEC_RAD:.2f}", '
        f'worst direction {lean.sigma_worst_arcsec:.2f}" ({_direction(lean)})'
    )
    half_mm = [1e3 * ELLIPSE_95 * height_m * sigma for sigma in (lean.sigma_worst, lean.sigma_best)]
    yield (
        f"top at {height_m:g} m: sigma {1e3 * height_m * lean.sigma_worst:.2f} mm in the worst direction; "
        f"95 % ellipse ±{half_mm[0]:.2f} by ±{half_mm[1]:.2f} mm"
    )
    yield (
        f"change: {1e3 * lean.smallest_detectable_m(height_m):.2f} mm at {height_m:g} m between two such epochs "
        "is found in 80 % of cases (1 % test)"
    )
    yield f"limited by {_limit(design, lean)}"
    yield "variance: " + ", ".join(f"{name} {100.0 * share:.1f} %" for name, share in lean.shares.items())
    yield from _coverage_lines(outlook)
    yield from _station_lines(outlook)
    yield _place_line(lean, place)
    levels = "adjusted from what is stated" if design.survey.errors.levels == "adjusted" else "held as stated"
    yield f"assumed: GNSS and the shaft tie the stations; levels are {levels}, each on its own; ranges have no bias;"
    yield "         the fit makes the most of every point (method paper scatters more)"


def plan_facts(design: Design, outlook: Outlook, place: BestPlace | FitFailure) -> dict[str, Json]:
    """Prediction for programs: metres, degrees, null where something does not exist."""
    sighted = outlook.sighted
    covered = sighted.covered_deg
    return {
        "structure": design.title,
        "epoch": design.epoch,
        "primary": list(design.primary),
        "height_m": design.height_m,
        **_lean_facts(outlook.lean, design.height_m),
        "limited_by": _largest(outlook.lean),
        "variance_shares": outlook.lean.shares,
        "coverage": [
            {"z_m": float(z), "covered_deg": float(deg)}
            for z, deg in zip(sighted.bands.z_m, covered, strict=True)
        ],
        "covered_deg": float(covered.mean()),
        "least_covered_deg": float(covered.min()),
        "least_covered_z_m": float(sighted.bands.z_m[covered.argmin()]),
        "stations": [_station_facts(station, design.height_m) for station in outlook.stations],
        "one_more": _place_facts(place, outlook.lean, design.height_m),
    }


def _lean_facts(lean: Prediction, height_m: float) -> dict[str, Json]:
    covariance = lean.covariance
    return {
        "lean_cov_ee": float(covariance[0, 0]),
        "lean_cov_en": float(covariance[0, 1]),
        "lean_cov_nn": float(covariance[1, 1]),
        "sigma_east_arcsec": _east(lean) / ARCSEC_RAD,
        "sigma_north_arcsec": _north(lean) / ARCSEC_RAD,
        "sigma_worst_arcsec": lean.sigma_worst_arcsec,
        "worst_azimuth_deg": lean.worst_azimuth_deg,
        "sigma_east_m": height_m * _east(lean),
        "sigma_north_m": height_m * _north(lean),
        "sigma_worst_m": height_m * lean.sigma_worst,
        "ellipse_95_m": [
            height_m * ELLIPSE_95 * lean.sigma_worst,
            height_m * ELLIPSE_95 * lean.sigma_best,
        ],
        "smallest_detectable_m": lean.smallest_detectable_m(height_m),
    }


def _station_facts(station: StationOutlook, height_m: float) -> dict[str, Json]:
    left = station.without
    return {
        "station": station.site.station,
        "position_m": list(station.site.position_m),
        "azimuth_deg": station.azimuth_deg,
        "distance_m": station.distance_m,
        "n_points": round(station.n_points),
        "n_points_used": round(station.n_points_used),
        "covered_deg": station.covered_deg,
        "pull": station.pull,
        "sigma_worst_without_m": None if isinstance(left, FitFailure) else height_m * left.sigma_worst,
        "reason": left.reason if isinstance(left, FitFailure) else None,
    }


def _place_facts(place: BestPlace | FitFailure, now: Prediction, height_m: float) -> dict[str, Json]:
    if isinstance(place, FitFailure):
        return {"azimuth_deg": None, "reason": place.reason}
    return {
        "azimuth_deg": place.azimuth_deg,
        "distance_m": place.distance_m,
        "position_m": list(place.site.position_m),
        "sigma_worst_m": height_m * place.lean.sigma_worst,
        "gain": 1.0 - place.lean.sigma_worst / now.sigma_worst,
    }


def _counted(n: int) -> str:
    return "1 station" if n == 1 else f"{n} stations"


def _limit(design: Design, lean: Prediction) -> str:
    cause = _largest(lean)
    more = "" if design.uses_all_points else ", or a scheme that uses all points (S)"
    return REMEDIES[cause] + (more if cause == "noise" else "")


def _direction(lean: Prediction) -> str:
    if lean.sigma_best > ALL_ALIKE * lean.sigma_worst:
        return "all directions are alike"
    return f"azimuth {lean.worst_azimuth_deg:.0f}° or {lean.worst_azimuth_deg + 180.0:.0f}°"


def _east(lean: Prediction) -> float:
    return float(lean.covariance[0, 0] ** 0.5)


def _north(lean: Prediction) -> float:
    return float(lean.covariance[1, 1] ** 0.5)


def _largest(lean: Prediction) -> str:
    return max(lean.shares, key=lambda name: lean.shares[name])


def _coverage_lines(outlook: Outlook) -> Iterator[str]:
    """Mean and least coverage, then a strip a part of the height, top first, of how many stations see each 10°."""
    sighted = outlook.sighted
    covered, z_m = sighted.covered_deg, sighted.bands.z_m
    least = int(covered.argmin())
    yield (
        f"coverage: {covered.mean():.0f}° of 360° in the mean, least {covered[least]:.0f}° at {z_m[least]:.1f} m; "
        "stations that see each 10°, from north clockwise:"
    )
    per_sign = sighted.seen_by.reshape(len(z_m), STRIP, -1).min(axis=2)
    edges = [len(z_m) * row // STRIP_ROWS for row in range(STRIP_ROWS + 1)]
    half_m = sighted.bands.thickness_m / 2.0
    for low, high in reversed(list(pairwise(edges))):
        signs = "".join(_sign(int(n)) for n in per_sign[low:high].min(axis=0))
        yield f"  {z_m[low] - half_m[low]:7.1f} to {z_m[high - 1] + half_m[high - 1]:6.1f} m  {signs}"


def _sign(n: int) -> str:
    return "." if n == 0 else str(n) if n < 10 else "+"


def _station_lines(outlook: Outlook) -> Iterator[str]:
    yield "  station   azimuth  distance      points  sees  level pulls  worst sigma without it"
    for station in outlook.stations:
        left = station.without
        lost = left.reason if isinstance(left, FitFailure) else f'{left.sigma_worst_arcsec:.2f}"'
        yield (
            f"  {station.site.station:<8} {station.azimuth_deg:7.0f}° {station.distance_m:7.1f} m {station.n_points:11,.0f}"
            f" {station.covered_deg:4.0f}° {station.pull:9.2f}    {lost}"
        )


def _place_line(now: Prediction, place: BestPlace | FitFailure) -> str:
    if isinstance(place, FitFailure):
        return f"one more station: {place.reason}"
    gain = 100.0 * (1.0 - place.lean.sigma_worst / now.sigma_worst)
    return (
        f"one more station: best at azimuth {place.azimuth_deg:.0f}° from the axis, {place.distance_m:.0f} m away; worst "
        f'sigma {place.lean.sigma_worst_arcsec:.2f}" then, {gain:.0f} % less'
    )
