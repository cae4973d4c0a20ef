"""The pages of slices, of the surface and of points, filled from a small workspace with points."""

from collections.abc import Mapping
from dataclasses import replace

import pytest

from dashboard.address import Address
from dashboard.page import pages
from dashboard.panel import Panel
from dashboard.reader import Reader
from dashboard.view import Site, View, open_view
from storage.artifacts import artifact_path
from storage.errors import UsageError
from storage.records import SliceRow
from storage.views import slice_rows, surface_map_rows
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, slice_row, surface_map_row
from tests.storage.stored_points import keep_isolation, publish, wall

N = 40_000


def rows() -> list[SliceRow]:
    """Four slices where the wall is, and one that failed."""
    good = []
    for index in range(5):
        z_m = 2.0 + 25.0 * index
        good.append(
            replace(
                slice_row("e0", index),
                thickness_m=1.0,
                center_east_m=0.01 + 0.007 * z_m,
                center_north_m=-0.02 - 0.0057 * z_m,
            )
        )
    bare = {"center_east_m": None, "center_north_m": None, "radius_m": None, "rmse_m": None}
    good[3] = replace(good[3], state="failed", reason="too few <points>", **bare)
    return good


@pytest.fixture
def stored(ws: Workspace) -> Workspace:
    keep_isolation(ws, *wall(N), ("ST01", "ST02"))
    cells = [surface_map_row("e0", 10.0 * i + 5.0, 1e-4 * i if i else None) for i in range(36)]
    publish(ws, "", n_points_used=N, slices=rows(), surface_map=cells)
    return ws


def view_of(ws: Workspace, page: str, **more: str) -> View:
    view = open_view(Reader(ws), Address(page=page, more=more), {STRUCTURE: Site("Chimney", ("A", "paper"))})
    assert view is not None
    return view


def panels(ws: Workspace, page: str, **more: str) -> Mapping[str, Panel]:
    return {panel.name: panel for panel in pages()[page].fill(view_of(ws, page, **more))}


def test_the_middle_slice_is_shown_to_who_asks_for_none(stored: Workspace) -> None:
    assert panels(stored, "slice")["place"].title.startswith("Slice 2 (0 to 4), z = 52.00 m")


@pytest.mark.parametrize(("more", "index"), [({"slice": "4"}, 4), ({"z": "28.3"}, 1), ({"z": "-900"}, 0)])
def test_a_slice_is_asked_for_by_number_or_height(
    stored: Workspace, more: dict[str, str], index: int
) -> None:
    assert panels(stored, "slice", **more)["place"].title.startswith(f"Slice {index} ")


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        ({"slice": "5"}, "unknown slice '5' of A/paper in epoch e0; known: 0 to 4"),
        ({"slice": "<b>"}, "unknown slice '<b>'"),
        ({"z": "nan"}, "z needs a height in metres; got 'nan'"),
        ({"z": "high"}, "z needs a height in metres; got 'high'"),
        ({"times": "3"}, "times needs one of 1, 10, 50, 100, 200; got '3'"),
    ],
)
def test_a_slice_that_is_not_there_is_refused_with_those_that_are(
    stored: Workspace, more: dict[str, str], reason: str
) -> None:
    with pytest.raises(UsageError, match=reason.replace("(", r"\(")):
        panels(stored, "slice", **more)


def test_the_tables_of_a_slice_have_the_numbers_of_the_catalog(stored: Workspace) -> None:
    found = panels(stored, "slice", slice="2")
    table = found["heights"].table
    assert table is not None
    catalog = slice_rows(stored, STRUCTURE, "e0", "A", "paper")
    assert [list(row) for row in table.rows] == [
        [getattr(row, name) for name in table.columns] for row in catalog
    ]
    rose = found["rose"].table
    assert rose is not None
    assert len(rose.rows) == 36
    inside = [row for row in wall(N)[0] if 51.5 <= row[2] <= 52.5]
    assert sum(int(row[2]) for row in rose.rows if isinstance(row[2], int)) == len(inside)


def test_the_keys_lead_to_the_slices_above_and_below_and_keep_the_exaggeration(stored: Workspace) -> None:
    tools = panels(stored, "slice", slice="2", times="50")["place"].tools
    assert [(tool.id, tool.href) for tool in tools] == [
        ("key-down", "/slice?slice=1&times=50"),
        ("key-up", "/slice?slice=3&times=50"),
    ]


def test_at_the_ends_there_is_no_step_further(stored: Workspace) -> None:
    below, above = panels(stored, "slice", slice="0")["place"].tools
    assert getattr(below, "href", None) is None
    assert above.href == "/slice?slice=1"


def test_a_slice_that_failed_is_shown_from_the_axis_with_its_reason(stored: Workspace) -> None:
    found = panels(stored, "slice", slice="3")
    assert "seen from the axis" in (found["contour"].note or "")
    assert "rejected: too few <points>" in str(found["numbers"].content)
    assert "0.00 mm" not in str(found["numbers"].content)


def test_without_points_the_numbers_are_still_there(ws: Workspace) -> None:
    ref = keep_isolation(ws, *wall(N), ("ST01", "ST02"))
    publish(ws, "", n_points_used=N, slices=rows())
    artifact_path(ws, ref).unlink()
    found = panels(ws, "slice", slice="2")
    for name in ("contour", "rose", "harmonics"):
        assert "tiltwatch run FILE --epoch" in (found[name].missing or "")
    assert "4.0000 m" in str(found["numbers"].content)
    assert "tiltwatch run FILE --epoch" in (panels(ws, "cloud")["cloud"].missing or "")


def test_an_epoch_without_slices_says_why(ws: Workspace) -> None:
    publish(ws, n_points_used=0, state="failed", slices=[], surface_map=[])
    assert [panel.missing for panel in panels(ws, "slice").values()] == ["no scan"]
    assert panels(ws, "surface")["map"].missing == "no scan"


def test_one_epoch_has_a_map_and_no_change(stored: Workspace) -> None:
    found = panels(stored, "surface")
    table = found["map"].table
    assert table is not None
    catalog = surface_map_rows(stored, STRUCTURE, "e0")
    assert [list(row) for row in table.rows] == [
        [getattr(row, name) for name in table.columns] for row in catalog
    ]
    assert found["change"].missing == "a change needs a second epoch"


def test_the_page_of_points_holds_the_page_of_three_js(stored: Workspace) -> None:
    assert panels(stored, "cloud")["cloud"].content.src == "/3d?"
