"""The lean of one isolated shaft under one scheme and method, in one call: no Prefect, no database."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean, StationEvidence, evidence_of, lean_of_sections, without_cone
from tasks.methods import Method
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.registration import Registration
from tasks.sections import fit_slices
from tasks.shaft_slices import ShaftCloud, slice_cloud
from tasks.slice_evidence import sum_slices
from tasks.slicing import SlicingScheme
from tasks.whole_surface import RoundCut, SurfaceQuestion, lean_of_surface


@dataclass(frozen=True, slots=True)
class IsolatedShaft:
    """The points of a shaft with their stations, its rough model, the poses, and the part that is measured.

    ``round_cut`` says which cut is round, ``sigma_m`` (n,) is the sigma of every point across the surface or None.
    """

    cloud: PlacedCloud
    model: ShaftModel
    registration: Registration
    shaft_z_m: tuple[float, float]
    round_cut: RoundCut = "horizontal"
    sigma_m: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Sliced:
    """The slices of a shaft, and what every station has to say of them (m, s, 3, 10)."""

    sections: tuple[SectionFit, ...]
    sums: NDArray[np.float64]


def slice_isolated(shaft: IsolatedShaft, scheme: SlicingScheme, method: Method) -> Sliced:
    """Cut a shaft and fit the method's contour to every slice."""
    cloud = ShaftCloud(shaft.cloud.points_m, shaft.model, shaft.sigma_m)
    slices = slice_cloud(cloud, scheme, method, shaft.shaft_z_m)
    sections = fit_slices(cloud, slices, method)
    n_stations = len(shaft.registration.poses)
    return Sliced(sections, sum_slices(cloud, shaft.cloud.station_index, n_stations, slices, sections))


def lean_of_scheme(shaft: IsolatedShaft, scheme: SlicingScheme, method: Method) -> Lean | FitFailure:
    """Measure the lean of a shaft under a scheme and method.

    Raises
    ------
    InputError
        If the scheme names a surface model that is not known.
    """
    if scheme.surface is not None:
        question = SurfaceQuestion(scheme.surface, shaft.shaft_z_m, shaft.round_cut)
        found = lean_of_surface(shaft.cloud, shaft.model, shaft.registration, question)
        return found if isinstance(found, FitFailure) else found.lean
    sliced = slice_isolated(shaft, scheme, method)
    evidence = evidence_of(sliced.sums, shaft.registration)
    return lean_of_slices(sliced.sections, method, evidence, shaft.model, shaft.round_cut)


def lean_of_slices(
    sections: tuple[SectionFit, ...],
    method: Method,
    evidence: StationEvidence,
    model: ShaftModel,
    round_cut: RoundCut,
) -> Lean | FitFailure:
    """Fit the axis of slices; the paper's method knows no cone."""
    lean = lean_of_sections(sections, method, evidence, model)
    if isinstance(lean, FitFailure) or round_cut == "horizontal" or method.name == "paper":
        return lean
    taper = float(np.polyfit(model.radius_z_m, model.radius_m, 1)[0])
    return without_cone(lean, taper)
