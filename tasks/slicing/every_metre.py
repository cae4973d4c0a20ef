"""Scheme A: a slice every metre."""

from typing import Final

from tasks.slicing.scheme import SlicingScheme

SCHEME: Final = SlicingScheme("A", "every 1 m", interval_m=1.0)
