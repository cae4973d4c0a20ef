"""Preprocessing: denoising, redundancy removal, and the shaft apart from everything else, without hand work."""

from tasks.preprocessing.isolation import Shaft, isolate_shaft
from tasks.preprocessing.kinds import KINDS
from tasks.preprocessing.model import ShaftFace, ShaftModel
from tasks.preprocessing.prior import ShaftOptions, StructurePrior
from tasks.preprocessing.reasons import KEPT, NOT_NEEDED, REASONS, Removal
from tasks.preprocessing.scans import SEARCH_POINTS, Scan, ScannedShaft, isolate_scans
from tasks.preprocessing.units import OTHER_UNITS, LengthUnit

__all__ = [
    "KEPT",
    "KINDS",
    "NOT_NEEDED",
    "OTHER_UNITS",
    "REASONS",
    "SEARCH_POINTS",
    "LengthUnit",
    "Removal",
    "Scan",
    "ScannedShaft",
    "Shaft",
    "ShaftFace",
    "ShaftModel",
    "ShaftOptions",
    "StructurePrior",
    "isolate_scans",
    "isolate_shaft",
]
