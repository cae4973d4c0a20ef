"""What the stations of an epoch have to say of every slice: for the jackknife and for the poses."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.geometry.faces import normals_of, split_by_face
from tasks.preprocessing import ShaftModel
from tasks.shaft_slices import ShaftCloud, Slice
from tasks.uncertainty import Ring, Skin, sum_by_station, sum_ring_by_station
from tasks.uncertainty.station_sums import COLUMNS

USED_SIGMAS: Final = 4.0
"""Points further from the contour than this do not count."""


def sum_slices(
    cloud: ShaftCloud,
    station_index: NDArray[np.integer],
    n_stations: int,
    slices: Sequence[Slice],
    sections: Sequence[SectionFit],
) -> NDArray[np.float64]:
    """Sums (m, s, 3, 10) of every slice by station (``tasks.uncertainty.sum_by_station``); zeros where it has no centre.

    ``station_index`` (n,) says which station saw each point of the cloud.
    """
    sums = np.zeros((len(sections), n_stations, 3, COLUMNS))
    for number, (cut, section) in enumerate(zip(slices, sections, strict=True)):
        if section.state == "ok":
            points_m, station = cloud.points_m[cut.rows], station_index[cut.rows]
            if cloud.model.is_round:
                sums[number] = sum_ring_by_station(
                    points_m, station, _ring_of(section, cloud.model), n_stations
                )
            else:
                sums[number] = sum_by_station(
                    _skin_on_faces(points_m, station, section, cloud.model), n_stations
                )
    return sums


def _near_m(section: SectionFit) -> float:
    noise = section.noise_m if section.noise_m is not None else section.rmse_m
    return USED_SIGMAS * (noise or 0.0)


def _ring_of(section: SectionFit, model: ShaftModel) -> Ring:
    east, north = section.center_east_m, section.center_north_m
    return Ring(
        center_m=(float(east or 0.0), float(north or 0.0)),
        z_m=section.z_m,
        radius_m=section.radius_m or 0.0,
        lean=(model.lean_east, model.lean_north),
        taper=float(model.taper_at(section.z_m)),
        near_m=_near_m(section),
    )


def _skin_on_faces(
    points_m: NDArray[np.float64], station: NDArray[np.integer], section: SectionFit, model: ShaftModel
) -> Skin:
    rise = points_m[:, 2] - section.z_m
    lean = np.array([model.lean_east, model.lean_north])
    centre = np.array([section.center_east_m, section.center_north_m], dtype=np.float64)
    ray = points_m[:, :2] - centre - rise[:, None] * lean
    taper = float(model.taper_at(section.z_m))
    azimuth = model.face_azimuths_rad(section.z_m)
    split = split_by_face(ray, azimuth, model.face_distances_at(section.z_m))
    out, residual = normals_of(azimuth)[split.face], split.off - taper * rise
    used = np.abs(residual) <= _near_m(section)
    outward = np.column_stack([out, -taper - out @ lean])
    return Skin(points_m[used], outward[used], residual[used], station[used])
