"""Lean of a cloud (n, 3) by us and by other packages; a package that is not installed is left out by name."""

import importlib
import random
from collections.abc import Callable, Mapping
from functools import partial
from types import ModuleType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.known_campaign import NOTHING
from benchmarks.accuracy.peer_clouds import HEIGHT_M, RADII_M, SLICES, THICKNESS_M, cut
from tasks.axis import fit_axis
from tasks.contours import Contour, Section, fit_contour
from tasks.epoch_shaft import isolate_epoch
from tasks.geometry.failure import FitFailure
from tasks.methods import method_of
from tasks.preprocessing import ShaftOptions, StructurePrior
from tasks.registration import registered_cloud
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.slicing import SCHEMES

Cloud = NDArray[np.float64]
Lean = NDArray[np.float64]
Method = Callable[[Cloud], Lean]
Centre = Callable[[NDArray[np.float64]], tuple[float, float]]

KINDEST_RADIUS_M: Final = 6.0
"""dendromatics takes sections for bad whose circle is larger than 0.5 m: opened for a chimney."""

KINDEST_GAP_M: Final = 0.5
RANSAC_POINTS: Final = 20_000
RANSAC_STEPS: Final = 1000
RANSAC_WITHIN_M: Final = 0.03


class NoLeanError(Exception):
    """A method gave none."""


def ours_sliced(contour: str, axis: str, cloud_m: Cloud) -> Lean:
    """Contours and axis on the slices that the others get, nothing isolated, no lean or taper known."""
    fits = []
    for band in cut(cloud_m):
        fit = fit_contour(contour, Section(band.points_m, band.z_m, THICKNESS_M))
        if isinstance(fit, Contour):
            fits.append((fit, band.z_m))
    centres = np.array([[fit.center_east_m, fit.center_north_m, z] for fit, z in fits])
    found = fit_axis(axis, centres, np.array([fit.covariance_m2 for fit, _ in fits]))
    if isinstance(found, FitFailure):
        raise NoLeanError(found.reason)
    return found.lean


def ours_whole(scheme_name: str, method_name: str, cloud_m: Cloud) -> Lean:
    """Isolate the shaft and measure it by a scheme, as a campaign does."""
    registration = registered_cloud("merged", NOTHING)
    prior = StructurePrior("chimney", (0.0, HEIGHT_M), (0.0, 0.0), RADII_M)
    shaft = isolate_epoch([cloud_m], registration, prior, ShaftOptions())
    if isinstance(shaft, FitFailure):
        raise NoLeanError(shaft.reason)
    scheme = SCHEMES[scheme_name]
    isolated = IsolatedShaft(shaft.cloud, shaft.model, registration, prior.shaft_z_m)
    found = lean_of_scheme(isolated, scheme, method_of(scheme, method_name))
    if isinstance(found, FitFailure):
        raise NoLeanError(found.reason)
    return found.lean


def _by_centres(centre: Centre, cloud_m: Cloud) -> Lean:
    """A circle for every slice, and a line of least squares through the centres."""
    bands = list(cut(cloud_m))
    centres = np.array([centre(band.points_m) for band in bands])
    heights = np.array([band.z_m for band in bands])
    return np.asarray(np.polyfit(heights, centres, 1)[0])


def _circle_fit(name: str, circle_fit: ModuleType, cloud_m: Cloud) -> Lean:
    def centre(points_m: NDArray[np.float64]) -> tuple[float, float]:
        east, north, *_ = getattr(circle_fit, name)(points_m[:, :2])
        return float(east), float(north)

    return _by_centres(centre, cloud_m)


def _dendromatics_circle(dendromatics: ModuleType, cloud_m: Cloud) -> Lean:
    def centre(points_m: NDArray[np.float64]) -> tuple[float, float]:
        found, _ = dendromatics.fit_circle(points_m[:, 0], points_m[:, 1])
        return float(found[0]), float(found[1])

    return _by_centres(centre, cloud_m)


def _dendromatics_sections(dendromatics: ModuleType, cloud_m: Cloud) -> Lean:
    spacing = HEIGHT_M / SLICES
    low_m = (np.arange(SLICES) + 0.5) * spacing - THICKNESS_M / 2.0
    stem = np.column_stack([cloud_m, cloud_m[:, 2], np.zeros(len(cloud_m))])
    east, north, radius, *_ = dendromatics.compute_sections(
        stem, low_m, section_width=THICKNESS_M, R_max=KINDEST_RADIUS_M, max_dist=KINDEST_GAP_M
    )
    good = radius[0] > 0.0
    if np.count_nonzero(good) < 2:
        raise NoLeanError("no section passes its own checks")
    centres = np.column_stack([east[0], north[0]])[good]
    return np.asarray(np.polyfit(low_m[good] + THICKNESS_M / 2.0, centres, 1)[0])


def _pyransac_cylinder(pyransac3d: ModuleType, cloud_m: Cloud) -> Lean:
    random.seed(1)
    some = cloud_m[:: max(len(cloud_m) // RANSAC_POINTS, 1)]
    axis = np.asarray(pyransac3d.Cylinder().fit(some, RANSAC_WITHIN_M, RANSAC_STEPS).axis, dtype=np.float64)
    if abs(axis[2]) < 1e-6:
        raise NoLeanError("the axis lies")
    return np.asarray(axis[:2] / axis[2])


def methods() -> Mapping[str, Method | None]:
    """The methods by name; None where the package is not installed."""
    return {
        "ours, scheme S": partial(ours_whole, "S", "surface"),
        "ours, scheme A robust": partial(ours_whole, "A", "robust"),
        "ours, robust_circle + robust_line": partial(ours_sliced, "robust_circle", "robust_line"),
        "ours, robust_circle + weighted_line": partial(ours_sliced, "robust_circle", "weighted_line"),
        "ours, geometric_circle + weighted_line": partial(ours_sliced, "geometric_circle", "weighted_line"),
        "paper: kasa + irls": partial(ours_sliced, "kasa", "irls"),
        "circle-fit taubinSVD + LSQ": _of_package("circle_fit", partial(_circle_fit, "taubinSVD")),
        "circle-fit hyperLSQ + LSQ": _of_package("circle_fit", partial(_circle_fit, "hyperLSQ")),
        "dendromatics fit_circle + LSQ": _of_package("dendromatics", _dendromatics_circle),
        "dendromatics compute_sections + LSQ": _of_package("dendromatics", _dendromatics_sections),
        "pyransac3d Cylinder": _of_package("pyransac3d", _pyransac_cylinder),
    }


def _of_package(name: str, method: Callable[[ModuleType, Cloud], Lean]) -> Method | None:
    try:
        package = importlib.import_module(name)
    except ModuleNotFoundError:
        return None
    return partial(method, package)
