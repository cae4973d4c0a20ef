"""How well the stations of an epoch cover the shaft, and where one more would help most."""

from dataclasses import dataclass

from storage.records import CoverageCell
from tasks.coverage import count_coverage, coverage_cells
from tasks.geometry.failure import FitFailure
from tasks.next_station import NextStation, suggest_station
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.registration import InstrumentSigmas, Registration


@dataclass(frozen=True, slots=True)
class Outlook:
    """What the coverage says of an epoch as a whole; ``next_station`` is None where ``why_none`` says why."""

    covered_deg: float
    next_station: NextStation | None
    why_none: str | None


@dataclass(frozen=True, slots=True)
class EpochQuality:
    """The pieces of the shaft's surface with who saw them, and the outlook."""

    cells: tuple[CoverageCell, ...]
    outlook: Outlook


def rate_quality(
    cloud: PlacedCloud,
    model: ShaftModel,
    registration: Registration,
    sigmas: InstrumentSigmas,
    shaft_z_m: tuple[float, float],
) -> EpochQuality:
    """Rate the coverage of the isolated shaft; the cloud's stations are in the order of the registration's poses."""
    names = [pose.station for pose in registration.poses]
    coverage = count_coverage(cloud.points_m, cloud.station_index, model, shaft_z_m, len(names))
    suggested = suggest_station(coverage, model, registration, sigmas)
    if isinstance(suggested, FitFailure):
        outlook = Outlook(coverage.covered_deg, None, suggested.reason)
    else:
        outlook = Outlook(coverage.covered_deg, suggested, None)
    return EpochQuality(coverage_cells(coverage, names), outlook)
