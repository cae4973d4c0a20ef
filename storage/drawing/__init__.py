"""Results as geometry for other programs: axis, slices and shaft as DXF, GeoJSON, LAS, LAZ, CSV and Parquet."""

from storage.drawing.chosen import DrawingChoice
from storage.drawing.content import DrawingFrame
from storage.drawing.export import Exported, export_geometry
from storage.drawing.formats import GEOMETRY, formats_of

__all__ = ["GEOMETRY", "DrawingChoice", "DrawingFrame", "Exported", "export_geometry", "formats_of"]
