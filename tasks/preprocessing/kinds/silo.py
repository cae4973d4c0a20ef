"""Silos: position read off a plan, good to a metre."""

from typing import Final

from tasks.preprocessing.kinds.kind import StructureKind

KIND: Final = StructureKind(name="silo", position_slack_m=1.5, max_lean=0.05)
