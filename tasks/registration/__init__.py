"""Place the scans of an epoch in the site frame by one joint adjustment that keeps the level."""

from tasks.registration.register import register_stations, registered_cloud
from tasks.registration.station import (
    InstrumentSigmas,
    PairDiagnosis,
    PoseDiagnosis,
    RefusedStation,
    Registration,
    ShaftHint,
    StationPose,
    StationScan,
)

__all__ = [
    "InstrumentSigmas",
    "PairDiagnosis",
    "PoseDiagnosis",
    "RefusedStation",
    "Registration",
    "ShaftHint",
    "StationPose",
    "StationScan",
    "register_stations",
    "registered_cloud",
]
