"""Preprocessing: denoising, redundancy removal, and the shaft apart from everything else, without hand work."""

from tasks.preprocessing.isolation import KEPT, REASONS, Removal, Shaft, isolate_shaft
from tasks.preprocessing.kinds import KINDS
from tasks.preprocessing.model import ShaftFace, ShaftModel
from tasks.preprocessing.prior import ShaftOptions, StructurePrior
from tasks.preprocessing.units import OTHER_UNITS, LengthUnit

__all__ = [
    "KEPT",
    "KINDS",
    "OTHER_UNITS",
    "REASONS",
    "LengthUnit",
    "Removal",
    "Shaft",
    "ShaftFace",
    "ShaftModel",
    "ShaftOptions",
    "StructurePrior",
    "isolate_shaft",
]
