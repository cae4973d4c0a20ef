"""Simulated scans with known truth: a structure, its site, scanners that stand around it, and their errors."""

from tasks.simulation.attachments import Annex, Antenna, Attachments, attachment_meshes
from tasks.simulation.campaign import (
    REFERENCE_SIGMA,
    SimulatedCampaignRequest,
    SimulatedEpoch,
    draw_epochs,
    scan_epochs,
)
from tasks.simulation.epoch import Body, SimulatedStation, epoch_scene, set_up_epoch, simulate_epoch
from tasks.simulation.layout import Layout
from tasks.simulation.mesh import Mesh, Surface
from tasks.simulation.movement import Movement
from tasks.simulation.raycasting import Hits, RayScene, build_scene
from tasks.simulation.scan import SimulatedScan, scan_windows, simulate_station
from tasks.simulation.scanner import PERFECT_SCANNER, Scanner, Window
from tasks.simulation.shape import AxisTruth, Horizontal, ShaftShape, axis_truth
from tasks.simulation.site import Site, Surroundings, Terrain, build_site, draw_terrain
from tasks.simulation.station import Setup, draw_station_places, set_up_station
from tasks.simulation.structure import Fittings, structure_meshes
from tasks.simulation.wall import Bumps, Wall, wall_mesh

__all__ = [
    "PERFECT_SCANNER",
    "REFERENCE_SIGMA",
    "Annex",
    "Antenna",
    "Attachments",
    "AxisTruth",
    "Body",
    "Bumps",
    "Fittings",
    "Hits",
    "Horizontal",
    "Layout",
    "Mesh",
    "Movement",
    "RayScene",
    "Scanner",
    "Setup",
    "ShaftShape",
    "SimulatedCampaignRequest",
    "SimulatedEpoch",
    "SimulatedScan",
    "SimulatedStation",
    "Site",
    "Surface",
    "Surroundings",
    "Terrain",
    "Wall",
    "Window",
    "attachment_meshes",
    "axis_truth",
    "build_scene",
    "build_site",
    "draw_epochs",
    "draw_station_places",
    "draw_terrain",
    "epoch_scene",
    "scan_epochs",
    "scan_windows",
    "set_up_epoch",
    "set_up_station",
    "simulate_epoch",
    "simulate_station",
    "structure_meshes",
    "wall_mesh",
]
