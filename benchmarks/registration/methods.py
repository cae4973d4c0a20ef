"""The ways to place the scans of an epoch that are compared, by name."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

from benchmarks.registration.known import KnownEpoch
from benchmarks.registration.pose_graph import place_by_pose_graph
from benchmarks.registration.sequential import place_one_after_the_other
from benchmarks.registration.unadjusted import stated_poses, unadjusted
from tasks.geometry.failure import FitFailure
from tasks.registration import Registration, register_stations

Placement = Callable[[KnownEpoch], Registration | FitFailure]


def place_truly(epoch: KnownEpoch) -> Registration:
    """True positions and headings, plumb: the floor that the levelling of the instruments leaves."""
    return unadjusted([station.plumb_pose for station in epoch.stations], epoch.sigmas)


def place_by_adjustment(epoch: KnownEpoch) -> Registration | FitFailure:
    """Ours: one joint adjustment that keeps the level."""
    return register_stations(epoch.scans, epoch.sigmas, hint=epoch.hint)


def place_as_stated(epoch: KnownEpoch) -> Registration:
    """GNSS position and heading as the crew states them."""
    return unadjusted(stated_poses(epoch), epoch.sigmas)


METHODS: Final[Mapping[str, Placement]] = {
    "true": place_truly,
    "ours": place_by_adjustment,
    "coarse": place_as_stated,
    "gicp": place_one_after_the_other,
    "open3d": place_by_pose_graph,
}


def chosen(names: str) -> Sequence[str]:
    """Names of a comma list; ``true`` comes first, because the others are compared with it."""
    wanted = [name.strip() for name in names.split(",")]
    unknown = [name for name in wanted if name not in METHODS]
    if unknown:
        raise SystemExit(f"unknown methods {', '.join(unknown)}; known: {', '.join(METHODS)}")
    return ["true", *(name for name in wanted if name != "true")]
