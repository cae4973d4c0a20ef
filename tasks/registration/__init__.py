"""Place the scans of an epoch in the site frame by one joint adjustment that keeps the level."""

from tasks.registration.cloud_motion import RigidMotion
from tasks.registration.cloud_pair import register_pair
from tasks.registration.cloud_result import PairRegistration
from tasks.registration.even_sample import Cloud, sampled
from tasks.registration.register import register_stations, registered_cloud
from tasks.registration.stable import StableBox, StableSurroundings, stable_surroundings
from tasks.registration.station import (
    InstrumentSigmas,
    PairDiagnosis,
    PoseDiagnosis,
    RefusedStation,
    Registration,
    ShaftHint,
    StationPose,
    StationScan,
    Ties,
)

__all__ = [
    "Cloud",
    "InstrumentSigmas",
    "PairDiagnosis",
    "PairRegistration",
    "PoseDiagnosis",
    "RefusedStation",
    "Registration",
    "RigidMotion",
    "ShaftHint",
    "StableBox",
    "StableSurroundings",
    "StationPose",
    "StationScan",
    "Ties",
    "register_pair",
    "register_stations",
    "registered_cloud",
    "sampled",
    "stable_surroundings",
]
