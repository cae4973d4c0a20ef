"""What the charts of the report choose by themselves: factors, runs, the worst slices."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib import font_manager

from dashboard.report.blocks import Document
from dashboard.report.charts import sketch, slices, style
from dashboard.report.parts.worst_slices import worst_of
from tests.storage.campaign import slice_row


def leaning(deviation_m: float, allowable_m: float | None = None) -> sketch.Leaning:
    return sketch.Leaning(100.0, (2.0, 100.0), (5.0, 3.0), deviation_m, 0.001, allowable_m, 90.0)


def test_the_lean_is_drawn_as_large_as_the_sketch_holds() -> None:
    assert sketch.factor_of(leaning(1.0)) == 20
    assert sketch.factor_of(leaning(0.1)) == 200
    assert sketch.factor_of(leaning(0.0)) == 1
    assert sketch.factor_of(leaning(60.0)) == 1


def test_a_limit_that_is_near_enough_has_room_in_the_sketch() -> None:
    assert sketch.factor_of(leaning(0.1, 0.3)) == 100
    assert sketch.factor_of(leaning(0.1, 5.0)) == sketch.factor_of(leaning(0.1)), (
        "one far beyond is not drawn"
    )


def ring(deviation_m: list[float]) -> slices.Ring:
    n = len(deviation_m)
    return slices.Ring("r", 4.0, np.arange(n) * 360.0 / n, np.array(deviation_m), None)


def test_all_rings_are_exaggerated_alike_and_stay_within_their_panels() -> None:
    factor = slices.factor_of([ring([0.001] * 36), ring([0.01] * 36)])
    assert factor == 100
    assert factor * 0.01 / 4.0 <= slices.MOST_OF_RADIUS


def test_the_wall_is_closed_only_where_it_was_seen() -> None:
    nan = float("nan")
    assert len(slices._runs(ring([0.0] * 12))) == 1
    closed = slices._runs(ring([0.0] * 12))[0][0]
    assert closed[-1] - closed[0] == pytest.approx(2.0 * np.pi)
    runs = slices._runs(ring([0.0, 0.0, nan, 0.0, nan, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    spans = sorted(float(np.degrees(run[0, -1] - run[0, 0])) for run in runs)
    assert spans == pytest.approx([0.0, 240.0]), "the run over north is one"
    assert slices._runs(ring([nan] * 12)) == []


def test_the_worst_slices_are_each_worst_in_their_own_way() -> None:
    rows = [slice_row("e0", index) for index in range(5)]
    rows[1] = replace(rows[1], residual_m=0.02)
    rows[3] = replace(rows[3], rmse_m=0.05)
    rows[4] = replace(rows[4], arc_coverage_deg=120.0)
    assert [(each.row.slice_index, each.why) for each in worst_of(rows)] == [
        (1, "residual"),
        (3, "scatter"),
        (4, "gap"),
    ]


def test_a_slice_without_a_centre_is_the_worst_and_a_full_ring_has_no_largest_gap() -> None:
    rows = [slice_row("e0", index) for index in range(4)]
    rows[2] = replace(rows[2], state="failed", reason="no circle", residual_m=None, rmse_m=None)
    assert {each.why for each in worst_of(rows)} == {"failed", "residual", "scatter"}
    rows = [replace(row, residual_m=None) for row in rows[:2]]
    assert {each.why for each in worst_of(rows)} == {"scatter", "few"}
    assert worst_of([]) == []


def test_charts_hold_no_date_and_nothing_outside_of_them(english: Document) -> None:
    assert set(english.charts) == {
        "sketch",
        "stations",
        "coverage",
        "series",
        "plan",
        "profile",
        "slices",
        "schemes",
    }
    for name, svg in english.charts.items():
        assert svg.startswith("<svg")
        assert "dc:date" not in svg
        assert "<text" not in svg, "text is outlines: it looks the same without the fonts"
        assert "<!--" not in svg
        assert f'id="{name}-' in svg


def test_fonts_of_the_machine_never_take_the_place_of_those_shipped(english: Document) -> None:
    names = {font.name for font in font_manager.fontManager.ttflist if str(style.FONTS) in font.fname}
    assert names == {style.LATIN, style.CHINESE}
    others = [font.fname for font in font_manager.fontManager.ttflist if font.name in names]
    assert all(str(style.FONTS) in path for path in others)
    assert "TiltwatchInter-" in english.charts["series"]
