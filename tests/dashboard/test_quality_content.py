"""Warnings with their consequence, coverage with its gaps, the map of the stations."""

from dataclasses import replace

import numpy as np
import pytest

from dashboard.content.coverage import coverage_grid, gaps
from dashboard.content.quality import Evidence, counted_reasons, warnings
from dashboard.content.stations import station_map
from dashboard.figures.counts import points_of_slices, removal_bars
from dashboard.figures.coverage import coverage_strip
from dashboard.figures.stations import station_plan
from storage.records import CoverageRow, RemovalRow, SliceRow
from tests.storage.campaign import (
    STRUCTURE,
    coverage_row,
    epoch_row,
    scheme_row,
    slice_row,
    station_row,
    tilt_row,
)

RESULT = ("A", "paper")


def evidence(**changed: object) -> Evidence:
    given = {
        "epoch": epoch_row("e1", 1),
        "result": RESULT,
        "tilts": [tilt_row("e1", 1)],
        "schemes": [scheme_row("e1")],
        "stations": [station_row("e1")],
        "slices": [slice_row("e1", index) for index in range(5)],
        "coverage": [],
        "before": epoch_row("e0"),
        "tilts_before": [tilt_row("e0", deviation_sigma_m=0.001)],
        **changed,
    }
    return Evidence(**given)  # type: ignore[arg-type]


def failed_slice(index: int, reason: str) -> SliceRow:
    return replace(
        slice_row("e1", index),
        state="failed",
        reason=reason,
        center_east_m=None,
        center_north_m=None,
        radius_m=None,
    )


def band(low: float, empty: set[int]) -> list[CoverageRow]:
    """A height band of 36 sectors, some of them without a point."""
    rows = []
    for sector in range(36):
        station = None if sector in empty else "ST01"
        row = coverage_row("e1", 10.0 * sector, station)
        rows.append(replace(row, z_low_m=low, z_high_m=low + 5.0))
    return rows


def test_sound_data_give_no_warning() -> None:
    assert warnings(evidence()) == []


def test_a_degraded_epoch_says_how_much_less_certain_it_is() -> None:
    epoch = epoch_row("e1", 1, state="degraded", reason="station ST02: cut short", stations_sigma_arcsec=1.5)
    lost = replace(station_row("e1", "ST02"), state="failed", reason="cut short")
    found = evidence(
        epoch=epoch, stations=[station_row("e1"), lost], before=epoch_row("e0", stations_sigma_arcsec=1.2)
    )
    first, second = warnings(found)
    assert first.what == "The epoch is degraded: 2 of 2 stations entered the result"
    assert "1.50″, 1.20″ in e0" in first.then
    assert "U of the deviation 4.0 mm, 2.0 mm in e0" in first.then
    assert second.what == "Station ST02 is failed: cut short"


def test_a_failed_epoch_names_the_last_whole_one() -> None:
    epoch = epoch_row("e1", 1, state="failed", reason="no scan could be read", n_stations_used=0)
    (mind,) = warnings(evidence(epoch=epoch, tilts=[], slices=[], stations=[], schemes=[]))
    assert mind.tone == "quality"
    assert mind.what.endswith("0 of 2 stations entered the result; no scan could be read")
    assert "The last whole epoch before it is e0: 920.8 ± 2.0 mm" in mind.then
    alone = evidence(epoch=epoch, tilts=[], slices=[], stations=[], schemes=[], before=None, tilts_before=[])
    assert "no other epoch" in warnings(alone)[0].then


def test_one_fault_of_many_scans_is_said_once() -> None:
    lost = [
        replace(station_row("e1", name), state="failed", reason=f"/data/{name}.laz: cut short")
        for name in ("ST01", "ST02", "ST03")
    ]
    (mind,) = warnings(evidence(stations=lost))
    assert mind.what == "Stations ST01, ST02 and ST03 are failed: /data/….laz: cut short"


def test_failed_slices_tell_where_why_and_what_the_axis_rests_on() -> None:
    slices = [
        slice_row("e1", 0),
        failed_slice(1, "needs at least 4 points, got 0"),
        failed_slice(2, "needs at least 4 points, got 3"),
    ]
    (mind,) = warnings(evidence(slices=slices))
    assert mind.tone == "warning"
    assert mind.what == (
        "2 of 3 slices of A/paper failed, between 27.0 and 52.0 m: needs at least 4 points, got 0 to 3 (2 times)"
    )
    assert mind.then == "The axis rests on 5 centres, U 4.0 mm (2.0 mm in e0)."


def test_failed_slices_of_other_schemes_are_one_note() -> None:
    others = [replace(failed_slice(1, "odd"), scheme=scheme) for scheme in ("B", "C")]
    (mind,) = warnings(evidence(slices=[slice_row("e1", 0), *others]))
    assert mind.tone == "note"
    assert "1 of 1 of B/paper, 1 of 1 of C/paper; odd (2 times)" in mind.what
    assert mind.then == "B/paper: no axis; C/paper: no axis."


def test_reasons_that_differ_in_their_last_figure_are_counted_together() -> None:
    assert counted_reasons(["got none", None, "needs 4, got 2", "needs 4, got 2"]) == [
        "needs 4, got 2 (2 times)",
        "got none",
        "no reason is stored",
    ]


def test_a_covariance_of_leaving_out_says_what_propagation_gave() -> None:
    tilt = tilt_row(
        "e1", 1, lean=(0.007, 0.0), warning="the stations disagree (p = 0.001): look", covariance_source="jackknife",
        propagated_cov_ee=1e-10, propagated_cov_en=0.0, propagated_cov_nn=1e-10,
    )  # fmt: skip
    (mind,) = warnings(evidence(tilts=[tilt]))
    assert mind.what == "A/paper: the stations disagree (p = 0.001): look"
    assert mind.then == "U of the deviation: A/paper 4.0 mm rather than 2.0 mm."


def test_without_a_covariance_no_change_can_be_stated() -> None:
    (mind,) = warnings(evidence(tilts=[tilt_row("e1", 1, deviation_sigma_m=None)]))
    assert mind.what == "A/paper has no covariance"


def test_what_was_not_seen_is_told_with_the_centres_there() -> None:
    slices = [
        replace(slice_row("e1", index), sigma_center_m=0.001 if index == 0 else 0.0005) for index in range(5)
    ]
    found = evidence(
        coverage=[*band(2.0, {0, 1, 35}), *band(7.0, {0, 1, 35}), *band(12.0, set())], slices=slices
    )
    (mind,) = warnings(found)
    assert mind.what == "2.0 to 12.0 m lacks 30°: nothing was seen from 350° to 20°"
    assert mind.then == "U of a centre of A/paper there: 2.00 mm; where all sides were seen: 1.00 mm."


def test_one_more_station_is_worth_the_way_or_not() -> None:
    epoch = epoch_row(
        "e1", 1, stations_sigma_arcsec=2.0, next_station_sigma_arcsec=1.9, next_station_azimuth_deg=170.0
    )
    (little,) = warnings(evidence(epoch=epoch))
    assert little.tone == "note"
    assert little.then.endswith("5 % less: not worth the way.")
    (much,) = warnings(evidence(epoch=replace(epoch, next_station_sigma_arcsec=1.0)))
    assert much.tone == "warning"
    assert much.then == "Predicted sigma of the lean 2.00″ would become 1.00″, 50 % less."


def test_sectors_that_touch_are_one_gap_and_bands_that_differ_two() -> None:
    found = gaps([*band(2.0, {3, 4, 20}), *band(7.0, {3, 4})])
    assert [(gap.z_low_m, gap.z_high_m, gap.lacking_deg) for gap in found] == [
        (2.0, 7.0, 30.0),
        (7.0, 12.0, 20.0),
    ]
    assert found[0].sectors == ((30.0, 50.0), (200.0, 210.0))
    assert gaps(band(2.0, set())) == []
    (all_round,) = gaps(band(2.0, set(range(36))))
    assert (all_round.lacking_deg, all_round.sectors) == (360.0, ((0.0, 360.0),))


def test_pieces_without_a_point_have_no_colour() -> None:
    rows = band(2.0, {7})
    grid = coverage_grid(rows)
    assert grid.points.shape == (1, 36)
    assert grid.first[0, 6] == "ST01"
    for by_stations in (False, True):
        drawn = coverage_strip(grid, by_stations).data[0]
        assert drawn.z[0][7] is None
        assert drawn.z[0][6] == pytest.approx(1.0 if by_stations else np.log10(300))
    assert "no point" in drawn.text[0][7]


def test_stations_without_a_position_are_named_and_not_drawn() -> None:
    lost = replace(
        station_row("e1", "<b>ST02</b>"), position_east_m=None, position_north_m=None, state="failed"
    )
    shown = station_map([station_row("e1"), lost], (1.0, -2.0), 4.0, 90.0)
    assert shown.nowhere == ["<b>ST02</b>"]
    (pin,) = shown.pins
    assert pin.distance_m == pytest.approx(np.hypot(230.4, -10.9))
    assert pin.azimuth_deg == pytest.approx(np.degrees(np.arctan2(230.4, -10.9)))
    assert "one more would help most at 90°" in [trace.name for trace in station_plan(shown).data]


def test_suspect_stations_are_crosses_and_names_are_no_markup() -> None:
    odd = replace(
        station_row("e1", "<b>x</b>"), state="suspect", reason="it leans", weakest_direction="shift north"
    )
    figure = station_plan(station_map([odd], None, None, None))
    pins = figure.data[-1]
    assert pins.marker.symbol == ("x",)
    assert pins.text == ("&lt;b&gt;x&lt;/b&gt;",)
    assert "it leans" in pins.customdata[0][0]


def test_bars_and_points_say_the_numbers_of_the_rows() -> None:
    removals = [RemovalRow(STRUCTURE, "e1", 0, "ground", 300), RemovalRow(STRUCTURE, "e1", 1, "kept", 700)]
    bars = removal_bars(removals).data[0]
    assert list(bars.x) == [300, 700]
    assert bars.text == ("300  (30.0 %)", "700  (70.0 %)")
    drawn = points_of_slices([slice_row("e1", 0), replace(failed_slice(1, "none"), n_points=0)])
    assert list(drawn.data[0].x) == [200]
    assert drawn.data[1].marker.symbol == "x"
    assert "failed: none" in drawn.data[1].customdata[0][0]
