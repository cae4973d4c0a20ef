"""One lean from one cloud, in a notebook: no Prefect, no database, no campaign file."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.geometry.variants import choose
from tasks.lean import Lean
from tasks.methods import method_of, suited_to
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftOptions, StructurePrior, isolate_shaft
from tasks.registration import InstrumentSigmas, registered_cloud
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.slicing import SCHEMES


def measure_lean(
    points_m: NDArray[np.float64],
    prior: StructurePrior,
    sigmas: InstrumentSigmas,
    scheme: str = "S",
    method: str = "surface",
) -> Lean | FitFailure:
    """Isolate a shaft in a registered cloud, slice it, and fit its axis.

    Parameters
    ----------
    points_m : (n, 3) array
        Points in the site frame (x east, y north, z up), metres.
    prior : StructurePrior
        Rough position, radii and the heights to slice between.
    sigmas : InstrumentSigmas
        How well the cloud is levelled and placed: part of the covariance.
    scheme, method : str
        A slicing scheme of ``tasks.slicing.SCHEMES``; ``paper`` or ``robust``, of scheme S ``surface``.

    Returns
    -------
    Lean or FitFailure
        The lean vector with its (2, 2) covariance, or why there is none.

    Raises
    ------
    InputError
        If the scheme or the method is not known.
    """
    cut = suited_to(choose(SCHEMES, scheme, "slicing scheme"), prior.kind)
    chosen = method_of(cut, method)
    shaft = isolate_shaft(points_m, prior, ShaftOptions())
    if isinstance(shaft, FitFailure):
        return shaft
    registration = registered_cloud("cloud", sigmas)
    kept = PlacedCloud(points_m[shaft.keep], np.zeros(len(shaft.keep), dtype=np.uint16))
    return lean_of_scheme(IsolatedShaft(kept, shaft.model, registration, prior.shaft_z_m), cut, chosen)
