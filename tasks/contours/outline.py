"""What is known of a section with straight faces before its points are looked at."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Straight faces around a rough centre at the height of a section.

    Attributes
    ----------
    center_m : (2,) array
        East and north of the centre, site frame, good to a few noises of the points, metres.
    azimuth_rad : (m,) array
        Azimuths of the outward normals, clockwise from grid north, in their order; m is even.
    half_m : (m,) array
        Distances of the faces from the centre, metres.
    taper : (m,) array
        Change of these per metre of height.
    sigma_m : (m,) array
        Standard deviation of half the side that a face and the opposite one bound, metres; infinite where it was
        never measured.
    """

    center_m: NDArray[np.float64]
    azimuth_rad: NDArray[np.float64]
    half_m: NDArray[np.float64]
    taper: NDArray[np.float64]
    sigma_m: NDArray[np.float64]
