"""The stages as cached tasks: load by reference, call one pure function, store, return a reference.

Arguments are plain JSON: references to artifacts and parameters. ``workspace`` and ``path`` say where
things lie and do not count in the cache key.
"""

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from storage.artifacts import ArtifactRef, get_rows, put_array, put_json, put_rows
from storage.errors import InputError
from storage.places import workspace_at
from storage.records import AccuracyRow, CoverageCell, SectionFit, SurfaceMapCell, TiltRow
from storage.scan_files import scan_at
from storage.workspace import Workspace
from tasks.caching import lasting, stage
from tasks.conventions import azimuth_deg
from tasks.epoch_quality import rate_quality
from tasks.epoch_shaft import isolate_epoch
from tasks.evaluation import NamedLean, Occasion, Standard, evaluate
from tasks.exchange import plain, rebuild
from tasks.geometry.failure import FitFailure
from tasks.ingest import ScanFacts, ScanRequest
from tasks.lean import Lean, evidence_of
from tasks.map_shapes import StraightAxis
from tasks.methods import FACES, Method
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel, ShaftOptions, StructurePrior
from tasks.produced import Json, Outcome
from tasks.registration import (
    InstrumentSigmas,
    ShaftHint,
    StableBox,
    register_stations,
    registered_cloud,
    stable_surroundings,
)
from tasks.scheme_lean import lean_of_slices
from tasks.sections import fit_slices
from tasks.shaft_slices import ShaftCloud, slice_cloud
from tasks.sight_noise import ScannerNoise, sight_sigmas
from tasks.slice_evidence import sum_slices
from tasks.slicing import SlicingScheme
from tasks.stage_inputs import (
    JsonRef,
    array_of,
    cloud_of,
    json_of,
    registration_of,
    room_for_ingest,
    room_for_isolation,
    room_for_registration,
    room_for_shaft,
    shaft_cloud_of,
    shaft_model_of,
    stable_of,
    station_scan_of,
)
from tasks.stored_scan import store_scan
from tasks.surface_map import MapQuestion, map_surface
from tasks.whole_surface import SurfaceQuestion, lean_of_surface, round_cut_named


@stage("ingest")
def ingest_scan(
    workspace: str, path: str, digest: str, suffix: str, request: dict[str, Json]
) -> Outcome | FitFailure:
    """Read a scan file; why it is refused is said without its path, which another file of these bytes has not."""
    here = scan_at(_at(workspace), Path(path), digest, suffix)
    try:
        with room_for_ingest(here, suffix):
            scan = store_scan(_at(workspace), here, rebuild(ScanRequest, request))
    except InputError as fault:
        return FitFailure(str(lasting(fault)).removeprefix(f"{here}: "))
    facts: dict[str, Json] = {
        "n_points": len(scan.cloud),
        "fingerprint": scan.cloud.fingerprint(),
        "notes": list(scan.facts.notes),
        **_pose_facts(scan.facts),
    }
    return Outcome({"points": scan.ref}, facts, len(scan.cloud))


def _pose_facts(scan: ScanFacts) -> dict[str, Json]:
    """Position and heading that the file states, in its own coordinates, where it states a pose."""
    if scan.pose is None:
        return {}
    forward = scan.pose.rotation[:, 1]
    return {
        "position_m": plain(scan.pose.translation),
        "heading_deg": azimuth_deg(forward[0], forward[1]),
    }


@stage("stable surroundings")
def take_stable_surroundings(
    workspace: str, clouds: list[JsonRef], registration: JsonRef, boxes: list[dict[str, Json]]
) -> Outcome | FitFailure:
    """Take what does not move out of the scans of the reference epoch."""
    scans = [cloud_of(workspace, ref) for ref in clouds]
    named = [rebuild(StableBox, box) for box in boxes]
    with room_for_registration(scans):
        stable = stable_surroundings(scans, registration_of(workspace, registration), named)
    if isinstance(stable, FitFailure):
        return stable
    arrays = {field.name: getattr(stable, field.name) for field in fields(stable)}
    refs = {name: put_array(_at(workspace), f"stable-{name}", array) for name, array in arrays.items()}
    return Outcome(refs, {}, sum(len(scan) for scan in scans))


@stage("registration")
def register_epoch(
    workspace: str,
    stations: list[dict[str, Any]],
    sigmas: dict[str, Json],
    shaft: dict[str, Json],
    stable: dict[str, JsonRef] | None,
) -> Outcome | FitFailure:
    """Adjust the poses of all stations of an epoch jointly; stable surroundings hold them beside GNSS."""
    scans = [station_scan_of(workspace, station) for station in stations]
    with room_for_registration([cloud_of(workspace, station["points"]) for station in stations]):
        registration = register_stations(
            scans,
            rebuild(InstrumentSigmas, sigmas),
            hint=rebuild(ShaftHint, shaft),
            stable=None if stable is None else stable_of(workspace, stable),
        )
    if isinstance(registration, FitFailure):
        return registration
    ref = put_json(_at(workspace), "registration", plain(registration))
    return Outcome({"registration": ref}, {}, sum(len(scan.points_m) for scan in scans))


@stage("take registered")
def take_registered(workspace: str, station: str, sigmas: dict[str, Json]) -> Outcome:
    """Take a cloud that lies in the site frame already."""
    registration = registered_cloud(station, rebuild(InstrumentSigmas, sigmas))
    return Outcome({"registration": put_json(_at(workspace), "registration", plain(registration))})


@stage("preprocessing")
def isolate_epoch_shaft(
    workspace: str,
    clouds: list[JsonRef],
    registration: JsonRef,
    prior: dict[str, Json],
    options: dict[str, Json],
) -> Outcome | FitFailure:
    """Place the scans and take the shaft out of its surroundings."""
    scans = [cloud_of(workspace, ref) for ref in clouds]
    known, how = rebuild(StructurePrior, prior), rebuild(ShaftOptions, options)
    with room_for_isolation(scans, how.most_points):
        shaft = isolate_epoch(scans, registration_of(workspace, registration), known, how)
        if isinstance(shaft, FitFailure):
            return shaft
        refs = {
            "points": put_array(_at(workspace), "shaft", shaft.cloud.points_m),
            "stations": put_array(_at(workspace), "shaft-stations", shaft.cloud.station_index),
            "model": put_json(_at(workspace), "shaft-model", plain(shaft.model)),
        }
    facts: dict[str, Json] = {
        "removed": plain(shaft.removed),
        "n_points_used": len(shaft.cloud.points_m),
        "shares": plain(shaft.shares),
        "levels": plain(shaft.levels),
    }
    return Outcome(refs, facts, shaft.n_points_in)


@stage("coverage")
def rate_coverage(
    workspace: str,
    shaft: dict[str, JsonRef],
    registration: JsonRef,
    sigmas: dict[str, Json],
    shaft_z_m: list[float],
) -> Outcome:
    """Count who saw which part of the shaft, and find where one more station would help most."""
    model = shaft_model_of(workspace, shaft["model"])
    known, stated = registration_of(workspace, registration), rebuild(InstrumentSigmas, sigmas)
    low, high = shaft_z_m
    with room_for_shaft(shaft, "coverage"):
        cloud = shaft_cloud_of(workspace, shaft)
        quality = rate_quality(cloud, model, known, stated, (low, high))
    ref = put_rows(_at(workspace), "coverage", CoverageCell, quality.cells)
    return Outcome({"coverage": ref}, {"outlook": plain(quality.outlook)}, len(cloud.points_m))


@stage("slicing")
def slice_shaft(
    workspace: str,
    shaft: dict[str, Any],
    sights: dict[str, Any] | None,
    scheme: dict[str, Json],
    method: dict[str, Json],
    shaft_z_m: list[float],
) -> Outcome:
    """Cut the shaft by one scheme and fit the method's contour to every slice.

    ``sights`` are the registration and the noise of the scanner where the sigma of every point counts.
    """
    model, how = shaft_model_of(workspace, shaft["model"]), rebuild(Method, method)
    low, high = shaft_z_m
    with room_for_shaft(shaft, "slicing"):
        placed = shaft_cloud_of(workspace, shaft)
        sigma_m = None if sights is None else _sight_sigmas(workspace, placed, model, sights)
        cloud = ShaftCloud(placed.points_m, model, sigma_m)
        slices = slice_cloud(cloud, rebuild(SlicingScheme, scheme), how, (low, high))
        sections = fit_slices(cloud, slices, how)
        sums = sum_slices(cloud, placed.station_index, shaft["n_stations"], slices, sections)
    refs = {
        "sections": put_rows(_at(workspace), "sections", SectionFit, sections),
        "stations": put_array(_at(workspace), "slice-stations", sums),
    }
    return Outcome(refs, {}, len(placed.points_m))


def _sight_sigmas(workspace: str, placed: PlacedCloud, model: ShaftModel, sights: dict[str, Any]) -> Any:
    poses = registration_of(workspace, sights["registration"]).poses
    return sight_sigmas(
        placed.points_m,
        placed.station_index,
        np.array([pose.position_m for pose in poses]),
        model,
        rebuild(ScannerNoise, sights["noise"]),
    )


@stage("axis")
def fit_scheme_axis(
    workspace: str,
    slices: dict[str, JsonRef],
    method: dict[str, Json],
    registration: JsonRef,
    model: JsonRef,
    round_cut: str,
) -> Outcome | FitFailure:
    """Fit the axis of one scheme and method, with the covariance of its lean vector."""
    rows = tuple(get_rows(_at(workspace), ArtifactRef.from_json(slices["sections"]), SectionFit))
    evidence = evidence_of(array_of(workspace, slices["stations"]), registration_of(workspace, registration))
    shaft = shaft_model_of(workspace, model)
    lean = lean_of_slices(rows, rebuild(Method, method), evidence, shaft, round_cut_named(round_cut))
    if isinstance(lean, FitFailure):
        return lean
    return Outcome({"lean": put_json(_at(workspace), "lean", plain(lean))})


@stage("surface")
def fit_whole_surface(
    workspace: str, shaft: dict[str, JsonRef], registration: JsonRef, question: dict[str, Json]
) -> Outcome | FitFailure:
    """Fit axis and radius profile to all points of the shaft at once."""
    model, known = shaft_model_of(workspace, shaft["model"]), registration_of(workspace, registration)
    asked = rebuild(SurfaceQuestion, question)
    with room_for_shaft(shaft, "the whole surface", by_faces=asked.model == FACES):
        cloud = shaft_cloud_of(workspace, shaft)
        found = lean_of_surface(cloud, model, known, asked)
    if isinstance(found, FitFailure):
        return found
    refs = {
        "lean": put_json(_at(workspace), "lean", plain(found.lean)),
        "sections": put_rows(_at(workspace), "sections", SectionFit, found.bands),
    }
    return Outcome(refs, {}, len(cloud.points_m))


@stage("surface map")
def map_whole_surface(
    workspace: str, shaft: dict[str, JsonRef], registration: JsonRef, lean: JsonRef, question: dict[str, Json]
) -> Outcome | FitFailure:
    """Map what the surface of the shaft is off a straight shaft, and off its design."""
    model, known = shaft_model_of(workspace, shaft["model"]), registration_of(workspace, registration)
    measured = rebuild(Lean, json_of(workspace, lean))
    axis = StraightAxis(measured.axis.point_m, measured.lean)
    with room_for_shaft(shaft, "the surface map"):
        cloud = shaft_cloud_of(workspace, shaft)
        cells = map_surface(cloud, model, axis, known, rebuild(MapQuestion, question))
    if isinstance(cells, FitFailure):
        return cells
    return Outcome(
        {"surface map": put_rows(_at(workspace), "surface-map", SurfaceMapCell, cells)},
        {},
        len(cloud.points_m),
    )


@stage("evaluation")
def evaluate_epoch(
    workspace: str, occasion: dict[str, Json], leans: list[dict[str, Any]], standard: dict[str, Json]
) -> Outcome:
    """Make the rows of tilt and accuracy of an epoch from the leans of its schemes."""
    named = [
        NamedLean(item["scheme"], item["method"], rebuild(Lean, json_of(workspace, item["lean"])))
        for item in leans
    ]
    done = evaluate(rebuild(Occasion, occasion), named, rebuild(Standard, standard))
    refs = {
        "tilt": put_rows(_at(workspace), "tilt", TiltRow, done.tilt),
        "accuracy": put_rows(_at(workspace), "accuracy", AccuracyRow, done.comparison.accuracy),
    }
    return Outcome(refs)


def _at(workspace: str) -> Workspace:
    return workspace_at(workspace)
