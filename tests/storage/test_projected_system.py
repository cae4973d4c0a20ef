"""A frame is a projected system with x east and y north in metres; every other code is refused with what it is."""

import pytest

from storage.drawing import DrawingFrame
from storage.drawing.projected_system import projected_system
from storage.errors import InputError
from storage.workspace import Workspace
from tests.storage.drawn import choice, drawn, fill_drawn


@pytest.mark.parametrize("code", [32650, 31467, 4549, 2154, 7415])
def test_metres_east_and_north_in_either_order_are_taken(code: int) -> None:
    assert projected_system(code).is_projected


@pytest.mark.parametrize(
    ("code", "what"),
    [
        (2263, "counts in US survey foot, not metres"),
        (4617, "is a Geographic 2D CRS, not a projected system"),
        (5773, "is a Vertical CRS, not a projected system"),
        (9518, "is a Compound CRS, not a projected system"),
        (2048, "has axes to the west and south"),
        (3031, "has axes to the north and north"),
        (9999, "is no system that PROJ knows"),
    ],
)
def test_what_would_lie_elsewhere_is_refused_with_what_to_do(code: int, what: str) -> None:
    with pytest.raises(InputError, match=rf"EPSG:{code} .*{what}; .*under horizontal in \[frame\]"):
        projected_system(code)


@pytest.mark.parametrize("file_format", ["csv", "dxf", "geojson", "parquet"])
def test_no_format_takes_such_a_frame(ws: Workspace, file_format: str) -> None:
    fill_drawn(ws)
    with pytest.raises(InputError, match="US survey foot"):
        drawn(ws, "axis", file_format, choice(DrawingFrame(epsg=2263)))
