"""Scheme S: no slices, all points of the surface at once."""

from typing import Final

from tasks.slicing.scheme import SlicingScheme

SCHEME: Final = SlicingScheme("S", "whole surface, all points at once", surface="shaft")
