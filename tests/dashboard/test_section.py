"""A slice as it is shown: its points, its circle, and what is said where one of them is missing."""

from dataclasses import replace

import numpy as np
import pytest

from dashboard.content.section import (
    EXAGGERATIONS,
    NoSection,
    Section,
    exaggeration_for,
    section_of,
    taper_at,
)
from storage.records import SliceRow
from storage.views.shaft_points import ShaftPoints
from tests.storage.campaign import STRUCTURE, slice_row, tilt_row
from tests.storage.stored_points import wall

N = 100_000
TILT = tilt_row("e0")


def shaft() -> ShaftPoints:
    return ShaftPoints(STRUCTURE, "e0", *wall(N), ("ST01", "ST02"))


def row(**changed: object) -> SliceRow:
    """A slice at 52 m, with the centre that the wall has there."""
    at = replace(slice_row("e0", 2), center_east_m=0.01 + 0.007 * 52.0, center_north_m=-0.02 - 0.0057 * 52.0)
    return replace(at, thickness_m=2.0, **changed)


def shown(row_: SliceRow, slices: list[SliceRow] | None = None) -> Section:
    section = section_of(row_, slices or [row_], shaft(), TILT)
    assert isinstance(section, Section)
    return section


def test_a_round_wall_is_seen_round_from_its_centre() -> None:
    section = shown(row())
    assert section.has_centre
    assert np.abs(section.rose.deviation_m).max() < 5 * 1.25 * 0.002 / np.sqrt(N / 50 / 36)
    assert section.axis_m == pytest.approx([0.0, 0.0], abs=1e-9)
    assert len(section.points.radial_m) <= 3000


def test_a_slice_that_failed_is_seen_from_the_axis() -> None:
    failed = row(center_east_m=None, center_north_m=None, radius_m=None, state="failed", reason="too few")
    section = shown(failed)
    assert not section.has_centre
    assert section.centre_m == pytest.approx([0.01 + 0.007 * 52.0, -0.02 - 0.0057 * 52.0])
    assert section.contour.radius_m == pytest.approx(4.0, abs=1e-3)


def test_without_centre_and_axis_the_reason_is_said() -> None:
    failed = row(center_east_m=None, center_north_m=None, radius_m=None, state="failed", reason="too few")
    section = section_of(failed, [failed], shaft(), None)
    assert section == NoSection("the slice has no centre (too few), and there is no axis to see it from")


def test_a_height_without_points_is_said() -> None:
    section = section_of(row(z_m=400.0), [row()], shaft(), TILT)
    assert section == NoSection("no point of the shaft lies between the ends of this slice at 400.00 m")


def test_flat_faces_have_no_waves_and_are_not_exaggerated() -> None:
    section = shown(row(contour="polygon"))
    assert section.is_flat
    assert section.harmonics == ()
    assert exaggeration_for(section) == 1


@pytest.mark.parametrize("times", EXAGGERATIONS)
def test_the_contour_stays_in_sight(times: int) -> None:
    """With waves of a size that this exaggeration just bears, it or a smaller one is chosen."""
    section = shown(row())
    amplitude_m = 0.19 * 4.0 / times
    radial_m = 4.0 + amplitude_m * np.cos(2.0 * np.radians(section.contour.azimuth_deg))
    waved = replace(section, contour=replace(section.contour, radial_m=radial_m))
    chosen = exaggeration_for(waved)
    assert chosen == times
    assert chosen * np.quantile(np.abs(waved.contour.deviation_m), 0.95) <= 0.2 * 4.0


def test_the_taper_is_that_of_the_neighbours_without_a_step() -> None:
    radii = [4.0 - 0.02 * z for z in range(10)]
    slices = [
        replace(slice_row("e0", i), z_m=float(i), radius_m=r - (0.3 if i > 5 else 0.0))
        for i, r in enumerate(radii)
    ]
    for each in slices:
        assert taper_at(each, slices) == pytest.approx(-0.02, abs=1e-9)


def test_slices_without_radii_have_no_taper() -> None:
    slices = [replace(slice_row("e0", i), radius_m=None) for i in range(3)]
    assert taper_at(slices[0], slices) == 0.0
    assert taper_at(slices[0], []) == 0.0


def test_a_round_wall_has_no_waves_however_far_off_its_centre_is_taken() -> None:
    """Seen from 0.4 m beside its middle, a circle of 4 m would have a second wave of 10 mm."""
    off = row(center_east_m=0.01 + 0.007 * 52.0 + 0.4)
    for harmonic in shown(off).harmonics:
        assert harmonic.amplitude_m == pytest.approx(0.0, abs=6e-4)
