"""The kinds of structures, one file each."""

from typing import Final

from tasks.geometry.variants import discover
from tasks.preprocessing.kinds.kind import StructureKind

KINDS: Final = discover(__name__, "KIND", StructureKind)
"""Kinds by name, found by themselves: a module of this folder that has ``KIND``."""

__all__ = ["KINDS", "StructureKind"]
