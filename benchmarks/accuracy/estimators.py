"""Ways from the points of a trial to a lean, by name."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.known_campaign import START_OFF_RAD
from benchmarks.accuracy.sliced_shaft import BASE_RADIUS_M, HEIGHT_M, LEAN, TAPER, THICKNESS_M, Drawn
from tasks.axis import AXES, fit_axis
from tasks.contours import CONTOURS, Contour, fit_contour
from tasks.geometry.failure import FitFailure
from tasks.geometry.variants import choose
from tasks.surface import SURFACES, SurfacePoints, SurfaceRequest, SurfaceStart, fit_surface

Found = NDArray[np.float64] | FitFailure

PAPER: Final = "kasa + irls"

SETS: Final[Mapping[str, Sequence[str]]] = {
    "key": (
        PAPER,
        "geometric_circle + weighted_line",
        "robust_circle + weighted_line",
        "robust_circle + robust_line",
        "robust_circle + tukey_line",
        "robust_circle + mm_line",
        "robust_circle + huber_line",
        "surface shaft",
        "surface cone",
    ),
    "contours": tuple(
        f"{name} + weighted_line" for name in CONTOURS if name not in ("vertex_mean", "polygon")
    ),
    "axes": tuple(f"robust_circle + {name}" for name in AXES if name != "two_points"),
}


def chosen(names: str) -> Sequence[str]:
    """Estimators of a comma list of names and sets, each once."""
    listed: dict[str, None] = {}
    for asked in (name.strip() for name in names.split(",")):
        listed.update(dict.fromkeys(SETS.get(asked, (asked,))))
    for name in listed:
        _check(name)
    return list(listed)


def leans_of(drawn: Drawn, names: Sequence[str]) -> Iterator[tuple[str, Found]]:
    """The lean (2,) by every estimator; every contour model is fitted once."""
    sections = drawn.sections()
    fits: dict[str, list[Contour | FitFailure]] = {}
    for name in names:
        if name.startswith("surface "):
            yield name, _surface_lean(drawn, name.removeprefix("surface "))
            continue
        contour, axis = name.split(" + ")
        if contour not in fits:
            fits[contour] = [fit_contour(contour, section) for section in sections]
        yield name, _axis_lean(drawn, fits[contour], axis)


def _check(name: str) -> None:
    if name.startswith("surface "):
        choose(SURFACES, name.removeprefix("surface "), "surface model")
        return
    parts = name.split(" + ")
    if len(parts) != 2:
        raise SystemExit(f"needs 'CONTOUR + AXIS', 'surface MODEL' or one of {', '.join(SETS)}, got {name!r}")
    choose(CONTOURS, parts[0], "contour model")
    choose(AXES, parts[1], "axis estimator")


def _axis_lean(drawn: Drawn, fits: Sequence[Contour | FitFailure], axis: str) -> Found:
    good = [(fit, z) for fit, z in zip(fits, drawn.z_m, strict=True) if isinstance(fit, Contour)]
    if not good:
        return next(fit for fit in fits if isinstance(fit, FitFailure))
    centres = np.array([[fit.center_east_m, fit.center_north_m, z] for fit, z in good])
    found = fit_axis(axis, centres, np.array([fit.covariance_m2 for fit, _ in good]))
    return found if isinstance(found, FitFailure) else found.lean


def _surface_lean(drawn: Drawn, model: str) -> Found:
    points = drawn.points_m.reshape(-1, 3)
    knots = np.linspace(0.0, HEIGHT_M, 11)
    start = SurfaceStart(
        knots,
        (LEAN[0] + START_OFF_RAD) * knots,
        (LEAN[1] - START_OFF_RAD) * knots,
        BASE_RADIUS_M + TAPER * knots,
        (-THICKNESS_M / 2, HEIGHT_M + THICKNESS_M / 2),
    )
    cloud = SurfacePoints(points, np.zeros(len(points), dtype=np.uint16), 1)
    found = fit_surface(model, SurfaceRequest(cloud, start, "horizontal", None))
    return found if isinstance(found, FitFailure) else found.lean
