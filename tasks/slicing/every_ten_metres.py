"""Scheme C: a slice every ten metres."""

from typing import Final

from tasks.slicing.scheme import SlicingScheme

SCHEME: Final = SlicingScheme("C", "every 10 m", interval_m=10.0)
