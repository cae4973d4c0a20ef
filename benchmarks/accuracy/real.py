"""Every estimator on real scans: nine leaning pines of which seven are measured, and a lamp post of 1,771 points.

    .venv/bin/python -m benchmarks.accuracy real [--data ../shared/data]

There is no truth: a cell is how far a lean lies from the median lean of that object, minutes of arc, with the share of the
slices that gave a centre where it is not all; letters stand for refusals. Slices of 5 cm at every 20 cm.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import laspy
import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.known_campaign import NOTHING
from benchmarks.accuracy.markdown import print_table
from tasks.axis import AXES
from tasks.contours import CONTOURS
from tasks.conventions import azimuth_deg
from tasks.epoch_shaft import isolate_epoch
from tasks.geometry.failure import FitFailure
from tasks.lean import evidence_of
from tasks.methods import Method
from tasks.preprocessing import ShaftOptions, StructurePrior
from tasks.registration import registered_cloud
from tasks.scheme_lean import IsolatedShaft, Sliced, lean_of_scheme, lean_of_slices, slice_isolated
from tasks.slicing import SlicingScheme
from tasks.surface import SURFACES

SCHEME: Final = SlicingScheme("G", "every 20 cm", interval_m=0.2, thickness_m=0.05)
STEMS: Final = (
    (11.03, 4.41),
    (3.06, 5.10),
    (3.83, 1.34),
    (7.14, 2.29),
    (8.67, 3.86),
    (5.02, 7.07),
    (0.78, 7.14),
)
MINUTES_PER_RAD: Final = float(np.degrees(1.0) * 60.0)


@dataclass(frozen=True, slots=True)
class Found:
    """A lean (2,) of an object, or the reason why there is none; ``share`` of the slices have a centre."""

    lean: NDArray[np.float64] | None
    reason: str
    share: float


def main(arguments: Sequence[str]) -> None:
    """Print the table and the reasons."""
    wanted = argparse.ArgumentParser(prog="real", description=__doc__)
    wanted.add_argument("--data", type=Path, default=Path(__file__).resolve().parents[3] / "shared" / "data")
    folder = wanted.parse_args(arguments).data
    table = {name: dict(_found(shaft)) for name, shaft in _shafts(folder)}
    medians = {name: _median(found) for name, found in table.items()}
    estimators = list(next(iter(table.values())))
    reasons: dict[str, str] = {}
    rows = [
        [one, *(_cell(found[one], medians[name], reasons) for name, found in table.items())]
        for one in estimators
    ]
    rows.append(["median tilt (deg)", *(f"{_tilt_deg(lean):.3f}" for lean in medians.values())])
    rows.append(["its azimuth (deg)", *(f"{azimuth_deg(*lean):.1f}" for lean in medians.values())])
    rows.append(["median distance (')", *(_scatter(found, medians[name]) for name, found in table.items())])
    print_table(["estimator", *table], rows)
    for reason, letter in reasons.items():
        print(f"- {letter}: {reason}")


def _shafts(folder: Path) -> Iterator[tuple[str, IsolatedShaft]]:
    cloud = laspy.read(folder / "stems" / "LPine1_demo.laz")
    points = np.column_stack([cloud.x, cloud.y, cloud.z]).astype(np.float64)
    for east, north in STEMS:
        prior = StructurePrior("stem", (1.0, 6.0), (east, north), (0.15, 0.12))
        yield f"stem {east:g} {north:g}", _isolated(points, prior)
    # the file is text: eleven lines of header, then x y z
    post = np.loadtxt(folder / "pole" / "lamppost.pcd", skiprows=11)
    yield "lamp post", _isolated(post, StructurePrior("mast", (-5.3, -0.2), (-9.85, 0.03), (0.08, 0.06)))


def _isolated(points_m: NDArray[np.float64], prior: StructurePrior) -> IsolatedShaft:
    registration = registered_cloud("merged", NOTHING)
    shaft = isolate_epoch([points_m], registration, prior, ShaftOptions())
    if isinstance(shaft, FitFailure):
        raise SystemExit(f"{prior.kind} at {prior.base_xy_m}: {shaft.reason}")
    sigma = np.full(len(shaft.cloud.points_m), shaft.model.noise_sigma_m)
    return IsolatedShaft(shaft.cloud, shaft.model, registration, prior.shaft_z_m, sigma_m=sigma)


def _found(shaft: IsolatedShaft) -> Iterator[tuple[str, Found]]:
    sliced = {
        name: slice_isolated(shaft, SCHEME, _method(name, "robust_line"))
        for name in CONTOURS
        if name != "polygon"
    }
    yield "paper: kasa + irls", _of_slices(shaft, sliced["kasa"], _method("kasa", "irls"))
    for name, slices in sliced.items():
        yield f"{name} + robust_line", _of_slices(shaft, slices, _method(name, "robust_line"))
    for axis in AXES:
        if axis != "robust_line":
            yield (
                f"robust_circle + {axis}",
                _of_slices(shaft, sliced["robust_circle"], _method("robust_circle", axis)),
            )
    for model in SURFACES:
        scheme = SlicingScheme("S", model, surface=model)
        found = lean_of_scheme(shaft, scheme, Method("surface", "", model, 0.05))
        if isinstance(found, FitFailure):
            yield f"surface {model}", Found(None, found.reason, 0.0)
        else:
            yield f"surface {model}", Found(found.lean, "", 1.0)


def _method(contour: str, axis: str) -> Method:
    return Method("robust", contour, axis, SCHEME.thickness_m)


def _of_slices(shaft: IsolatedShaft, sliced: Sliced, method: Method) -> Found:
    bad = [section.reason or "" for section in sliced.sections if section.state != "ok"]
    share = 1.0 - len(bad) / len(sliced.sections)
    evidence = evidence_of(sliced.sums, shaft.registration)
    found = lean_of_slices(sliced.sections, method, evidence, shaft.model, shaft.round_cut)
    if isinstance(found, FitFailure):
        return Found(None, bad[0] if share == 0.0 else found.reason, share)
    return Found(found.lean, "", share)


def _median(found: Mapping[str, Found]) -> NDArray[np.float64]:
    return np.asarray(np.median([one.lean for one in found.values() if one.lean is not None], axis=0))


def _cell(found: Found, median: NDArray[np.float64], reasons: dict[str, str]) -> str:
    if found.lean is None:
        reason = found.reason.partition(":")[0]
        return reasons.setdefault(reason, f"[{chr(ord('a') + len(reasons))}]")
    away = float(np.hypot(*(found.lean - median))) * MINUTES_PER_RAD
    return f"{away:.1f}" if found.share == 1.0 else f"{away:.1f} ({100.0 * found.share:.0f} %)"


def _scatter(found: Mapping[str, Found], median: NDArray[np.float64]) -> str:
    away = [np.hypot(*(one.lean - median)) for one in found.values() if one.lean is not None]
    return f"{np.median(away) * MINUTES_PER_RAD:.1f}"


def _tilt_deg(lean: NDArray[np.float64]) -> float:
    return float(np.degrees(np.arctan(np.hypot(*lean))))
