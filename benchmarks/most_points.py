"""What is lost where only an even sample of the points on the shaft is kept: `[preprocessing] most_points`.

`.venv/bin/python -m benchmarks.most_points --points 100000000`: one simulated epoch of 8 stations, registered
once; leans from all points on the shaft, and how far those of samples are off them.
"""

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.results.whole_run import campaign_of
from storage.clouds import StoredCloud
from storage.workspace import open_workspace
from tasks.conventions import ARCSEC_RAD
from tasks.epoch_shaft import isolate_epoch
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.methods import method_of
from tasks.plan import plan_options, plan_prior, plan_scans, plan_shaft_hint, plan_sigmas
from tasks.registration import Registration, StationScan, register_stations
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.settings import Campaign, load_campaign
from tasks.slicing import SCHEMES
from tasks.stated_pose import stated_pose
from tasks.stored_scan import store_scan

METHODS = (("S", "surface"), ("A", "robust"), ("A", "paper"), ("D", "paper"))
ALL = 10**9


@dataclass(frozen=True)
class Registered:
    """An epoch whose scans are placed."""

    campaign: Campaign
    clouds: Sequence[StoredCloud]
    registration: Registration


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser("python -m benchmarks.most_points", description=__doc__)
    parser.add_argument("--points", type=int, default=100_000_000)
    parser.add_argument("--kept", type=int, nargs="+", default=[16_000_000, 8_000_000, 4_000_000, 1_000_000])
    parser.add_argument("--folder", type=Path, help="keeps simulated scans; a temporary one where missing")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        campaign = load_campaign(campaign_of(asked.folder or Path(name), asked.points))
        epoch = _registered(campaign, Path(name) / "ws")
        print(
            "| points kept | " + " | ".join(f'{s}/{m}: moved, sigma, "' for s, m in METHODS) + " |",
            flush=True,
        )
        print("|---|" + "---|" * len(METHODS), flush=True)
        whole: dict[str, Lean] = {}
        for most in (ALL, *asked.kept):
            n_points, leans = _leans(epoch, most)
            whole = whole or leans
            print(
                f"| {n_points:,} | "
                + " | ".join(_told(lean, whole[key]) for key, lean in leans.items())
                + " |",
                flush=True,
            )


def _registered(campaign: Campaign, folder: Path) -> Registered:
    workspace, epoch = open_workspace(folder), campaign.epochs[0]
    clouds, scans = [], []
    for plan in plan_scans(campaign, epoch):
        clouds.append(store_scan(workspace, plan.path, plan.request).cloud)
        pose = stated_pose(campaign, plan, {})
        at_m = None if pose.position_m is None else np.array(pose.position_m)
        scans.append(StationScan(plan.station, clouds[-1], at_m, pose.heading_rad))
    found = register_stations(scans, plan_sigmas(campaign), hint=plan_shaft_hint(campaign), stable=None)
    if isinstance(found, FitFailure):
        raise SystemExit(found.reason)
    return Registered(campaign, clouds, found)


def _leans(epoch: Registered, most: int) -> tuple[int, dict[str, Lean]]:
    campaign = epoch.campaign
    options = replace(plan_options(campaign), most_points=most)
    shaft = isolate_epoch(epoch.clouds, epoch.registration, plan_prior(campaign), options)
    if isinstance(shaft, FitFailure):
        raise SystemExit(shaft.reason)
    isolated = IsolatedShaft(shaft.cloud, shaft.model, epoch.registration, campaign.structure.shaft_z_m)
    leans = {}
    for scheme, method in METHODS:
        found = lean_of_scheme(isolated, SCHEMES[scheme], method_of(SCHEMES[scheme], method))
        if isinstance(found, FitFailure):
            raise SystemExit(f"{scheme}/{method}: {found.reason}")
        leans[f"{scheme}/{method}"] = found
    return len(shaft.cloud.points_m), leans


def _told(lean: Lean, whole: Lean) -> str:
    moved = np.hypot(*(lean.lean - whole.lean)) / ARCSEC_RAD
    sigma = np.sqrt(np.trace(lean.covariance) / 2.0) / ARCSEC_RAD
    return f"{moved:.2f}, {sigma:.2f}"


if __name__ == "__main__":
    main()
