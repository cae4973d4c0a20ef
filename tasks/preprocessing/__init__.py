"""Preprocessing: denoising, redundancy removal, and the shaft apart from everything else, without hand work."""

from tasks.preprocessing.isolation import KEPT, REASONS, Removal, Shaft, isolate_shaft
from tasks.preprocessing.kinds import KINDS
from tasks.preprocessing.model import ShaftModel, ShaftModelJson, model_from_json, model_to_json
from tasks.preprocessing.prior import ShaftOptions, StructurePrior

__all__ = [
    "KEPT",
    "KINDS",
    "REASONS",
    "Removal",
    "Shaft",
    "ShaftModel",
    "ShaftModelJson",
    "ShaftOptions",
    "StructurePrior",
    "isolate_shaft",
    "model_from_json",
    "model_to_json",
]
