"""Which EPSG codes a frame can have: x east and y north in metres, nothing else."""

from functools import lru_cache
from typing import TYPE_CHECKING

from storage.errors import InputError

if TYPE_CHECKING:
    from pyproj import CRS

WAY_OUT = (
    "write the code of a projected system in metres with axes east and north (as EPSG:32650, UTM 50 north) under "
    'horizontal in [frame] of the campaign file, or "local", and run'
)


@lru_cache(maxsize=16)
def projected_system(code: int) -> "CRS":
    """The system with an EPSG code.

    Raises
    ------
    InputError
        If there is none, or it is not projected, not in metres, or its axes are not east and north.
    """
    from pyproj import CRS  # noqa: PLC0415 (slow to import)
    from pyproj.exceptions import CRSError  # noqa: PLC0415 (slow to import)

    try:
        system = CRS.from_epsg(code)
    except CRSError as fault:
        raise InputError(f"EPSG:{code} is no system that PROJ knows; {WAY_OUT}") from fault
    what = _why_unfit(system)
    if what:
        raise InputError(
            f"EPSG:{code} ({system.name}) {what}; a frame has x east, y north in metres; {WAY_OUT}"
        )
    return system


def _why_unfit(system: "CRS") -> str:
    if not system.is_projected:
        return f"is a {system.type_name}, not a projected system"
    units = {axis.unit_name for axis in system.axis_info if axis.unit_conversion_factor != 1.0}
    if units:
        return f"counts in {' and '.join(sorted(units))}, not metres"
    directions = [axis.direction for axis in system.axis_info]
    if set(directions[:2]) != {"east", "north"} or directions[2:] not in ([], ["up"]):
        return f"has axes to the {' and '.join(directions)}"
    return ""
