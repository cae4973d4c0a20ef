"""The campaign of another generator: the lean vector by true poses against that by ours, both epochs.

.venv/bin/python -m benchmarks.registration shared [--campaign ../shared/data/campaign]
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Final, TypedDict

import numpy as np

from benchmarks.registration.known import KnownEpoch, KnownStation, heading_rad
from benchmarks.registration.methods import chosen
from benchmarks.registration.outcome import evaluate, moved
from tasks.conventions import ARCSEC_RAD, rotation_site_scanner
from tasks.ingest import read_scan
from tasks.plan import PlannedScan, plan_prior, plan_scans, plan_sigmas
from tasks.registration import StationPose, StationScan
from tasks.settings import Campaign, Epoch, load_campaign

CAMPAIGN: Final = Path(__file__).resolve().parents[3] / "shared" / "data" / "campaign"
AGREEMENT_RAD: Final = float(np.radians(1.0))
"""Stated and true heading agree that well, or an angle is misread here: the crew's sigma is 0.15 deg."""


class TrueStation(TypedDict):
    """What is used of a station of truth.json."""

    id: str
    true_position: list[float]
    true_heading_deg: float


def main(arguments: Sequence[str] | None = None) -> None:
    """Print one row an epoch and method."""
    wanted = argparse.ArgumentParser(prog="shared", description=__doc__)
    wanted.add_argument("--campaign", type=Path, default=CAMPAIGN)
    wanted.add_argument("--methods", type=chosen, default="true,ours")
    asked = wanted.parse_args(arguments)
    campaign = load_campaign(asked.campaign / "campaign.toml")
    print('epoch  method   error E, N (")    length   moved E, N (")   length   heading (")  time (s)  notes')
    for stated in campaign.epochs:
        epoch = _read_epoch(campaign, stated, asked.campaign)
        several = [evaluate(epoch, method) for method in asked.methods]
        for outcome in several:
            error, away = (_vector(v) for v in (outcome.error, moved(outcome, several[0])))
            heading = "-" if outcome.poses is None else f"{outcome.poses.heading_rms_arcsec:.1f}"
            notes = outcome.failure or "; ".join(outcome.notes)
            print(
                f"{epoch.label:6s} {outcome.method:7s} {error}  {away} {heading:>11s} {outcome.seconds:9.2f}  {notes}"
            )


def _vector(lean: object) -> str:
    if not isinstance(lean, np.ndarray):
        return f"{'-':>15s} {'-':>8s}"
    east, north = lean / ARCSEC_RAD
    return f"{east:+7.2f} {north:+7.2f} {np.hypot(east, north):8.2f}"


def _read_epoch(campaign: Campaign, stated: Epoch, folder: Path) -> KnownEpoch:
    truth = json.loads((folder / stated.id / "truth.json").read_text())
    true_poses = {one["id"]: _true_pose(one) for one in truth["stations"]}
    return KnownEpoch(
        stated.id,
        tuple(
            _read_station(planned, true_poses[planned.station]) for planned in plan_scans(campaign, stated)
        ),
        np.array(truth["lean_fit"]),
        plan_sigmas(campaign),
        plan_prior(campaign),
    )


def _true_pose(truth: TrueStation) -> StationPose:
    # the angle runs counter-clockwise from east to the scanner's x axis, which a heading of 0 points east
    rotation = rotation_site_scanner(float(np.radians(-truth["true_heading_deg"])))
    return StationPose(truth["id"], rotation, np.array(truth["true_position"]))


def _read_station(planned: PlannedScan, true: StationPose) -> KnownStation:
    position_m = None if planned.position_m is None else np.array(planned.position_m)
    points_m = read_scan(planned.path, planned.request).points_m
    station = KnownStation(StationScan(planned.station, points_m, position_m, planned.heading_rad), true)
    if planned.heading_rad is not None:
        off_rad = (planned.heading_rad - heading_rad(true) + np.pi) % (2.0 * np.pi) - np.pi
        if abs(off_rad) > AGREEMENT_RAD:
            raise SystemExit(
                f"{planned.station}: stated and true heading are {np.degrees(off_rad):.2f} deg apart"
            )
    return station
