"""What hides, limits and helps a planned survey."""

from dataclasses import replace

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.conventions import ARCSEC_RAD
from tasks.design import (
    BestPlace,
    Errors,
    Hidden,
    Outlook,
    Prediction,
    Scanning,
    Shaft,
    Site,
    Survey,
    best_place,
    foresee,
    predict_survey,
    sites_at,
    slices,
    whole_surface,
)
from tasks.design import prediction as stated
from tasks.geometry.failure import FitFailure
from tasks.geometry.plane_vectors import DETECTABLE_FACTOR

SHAFT = Shaft((2.0, 102.0), (4.6, 2.7))
ERRORS = Errors(0.005, float(np.radians(0.001)), 3.0 * ARCSEC_RAD, (0.015, 0.0225), 0.0026, 0.003)


def survey(*azimuths_deg: float, errors: Errors = ERRORS, shaft: Shaft = SHAFT) -> Survey:
    sites = sites_at(shaft, azimuths_deg, 230.0, 1.6)
    return Survey(shaft, whole_surface(shaft), sites, Scanning(float(np.radians(0.05))), errors)


def outlook(planned: Survey) -> Outlook:
    found = foresee(planned)
    assert isinstance(found, Outlook)
    return found


def lean(planned: Survey) -> Prediction:
    found = predict_survey(planned)
    assert isinstance(found, Prediction)
    return found


def test_a_station_sees_the_arc_that_the_limit_of_incidence_leaves() -> None:
    """From afar 160 of 360 degrees at a limit of 80; a cell has 2.5 degrees, and 230 m are 1 degree less than afar."""
    assert outlook(survey(0.0)).sighted.covered_deg == pytest.approx(np.full(40, 160.0), abs=5.0)


def test_what_is_hidden_lowers_the_coverage_where_it_is_hidden() -> None:
    planned = replace(survey(0.0, 90.0, 180.0, 270.0), hidden=(Hidden(None, (350.0, 20.0), 30.0),))
    found = outlook(planned).sighted
    is_low = found.bands.z_m < 30.0
    assert found.covered_deg[is_low] == pytest.approx(330.0)
    assert found.covered_deg[~is_low] == pytest.approx(360.0)


def test_what_is_hidden_from_one_station_is_seen_by_the_others() -> None:
    planned = survey(0.0, 40.0, 180.0)
    hidden = replace(planned, hidden=(Hidden("ST01", None, 50.0),))
    assert outlook(hidden).stations[0].n_points < 0.8 * outlook(planned).stations[0].n_points
    assert outlook(hidden).stations[1].n_points == pytest.approx(outlook(planned).stations[1].n_points)


def test_a_leaning_mirror_image_has_the_mirrored_covariance() -> None:
    """East for west: variances stay, the covariance of east and north changes its sign."""
    leaning = replace(SHAFT, lean=(0.01, 0.004))
    mirrored = replace(SHAFT, lean=(-0.01, 0.004))
    ours = lean(survey(10.0, 80.0, 200.0, shaft=leaning)).covariance
    theirs = lean(survey(350.0, 280.0, 160.0, shaft=mirrored)).covariance
    assert theirs == pytest.approx(ours * [[1.0, -1.0], [-1.0, 1.0]], rel=1e-6)


def test_more_points_help_against_noise_and_not_against_levels() -> None:
    few, many = (
        lean(replace(survey(0.0, 120.0, 240.0), points_per_station=n)) for n in (10_000.0, 1_000_000.0)
    )
    assert np.trace(many.noise) == pytest.approx(np.trace(few.noise) / 100.0, rel=1e-3)
    assert np.trace(many.level) == pytest.approx(np.trace(few.level), rel=1e-3)
    assert max(many.shares, key=lambda name: many.shares[name]) == "level"


def test_form_does_not_fall_with_the_number_of_points() -> None:
    dented = replace(ERRORS, form_m=0.005)
    few, many = (
        lean(replace(survey(0.0, 120.0, 240.0, errors=dented), points_per_station=n))
        for n in (10_000.0, 1_000_000.0)
    )
    assert np.trace(many.form) == pytest.approx(np.trace(few.form), rel=1e-3)
    assert np.trace(lean(survey(0.0, 120.0, 240.0)).form) == 0.0


def test_slices_cost_what_their_points_and_their_lever_say() -> None:
    """Of N points evenly on L: slices of 1 cm every metre use N / 100, two at the ends N / 5000 at three times the S."""
    cylinder = Shaft((2.0, 102.0), (4.0, 4.0))
    sites = sites_at(cylinder, (0.0, 120.0, 240.0), 5000.0, 50.0)
    scanning, errors = Scanning(1e-4), Errors(range_m=0.0, roughness_m=0.01)
    whole = Survey(cylinder, whole_surface(cylinder), sites, scanning, errors)
    hundred = replace(whole, bands=slices(np.arange(2.5, 102.0, 1.0), 0.01))
    two = replace(whole, bands=slices(np.array([2.0, 102.0]), 0.01))
    noise = [float(np.trace(lean(one).noise)) for one in (whole, hundred, two)]
    assert noise[1] / noise[0] == pytest.approx(100.0, rel=2e-3)
    assert noise[2] / noise[1] == pytest.approx(100.0 / 2.0 / 3.0, rel=2e-3)


def test_joined_slices_give_what_single_ones_give() -> None:
    whole = survey(0.0, 120.0, 240.0)
    heights_m = np.arange(2.1, 101.9, 0.2)
    joined = replace(whole, bands=slices(heights_m, 0.01))
    assert len(joined.bands.z_m) < len(heights_m)
    every_metre = replace(whole, bands=slices(np.arange(2.5, 102.0, 1.0), 0.05))
    assert lean(joined).covariance == pytest.approx(lean(every_metre).covariance, rel=0.01, abs=1e-14)


def test_one_more_station_goes_to_the_side_that_nobody_sees() -> None:
    planned = survey(330.0, 0.0, 30.0)
    place = best_place(planned)
    assert isinstance(place, BestPlace)
    assert 140.0 <= place.azimuth_deg <= 220.0
    assert place.lean.sigma_worst < lean(planned).sigma_worst


def test_the_prediction_with_one_more_station_is_that_of_the_larger_survey() -> None:
    planned = survey(0.0, 120.0)
    place = best_place(planned)
    assert isinstance(place, BestPlace)
    larger = replace(planned, sites=(*planned.sites, place.site))
    assert place.lean.covariance == pytest.approx(lean(larger).covariance)


def test_the_cost_of_leaving_a_station_out_is_the_prediction_without_it() -> None:
    planned = survey(0.0, 120.0, 240.0)
    without = outlook(planned).stations[1].without
    assert isinstance(without, Prediction)
    assert without.covariance == pytest.approx(lean(survey(0.0, 240.0)).covariance)


def test_a_single_station_cannot_be_left_out() -> None:
    without = outlook(survey(0.0)).stations[0].without
    assert without == FitFailure("needed a station that sees the shaft, none does")


def test_a_shaft_out_of_reach_has_no_prediction() -> None:
    planned = survey(0.0, 120.0)
    blind = replace(planned, scanning=replace(planned.scanning, reach_m=100.0))
    assert isinstance(predict_survey(blind), FitFailure)
    assert isinstance(foresee(replace(blind, points_per_station=1e4)), FitFailure)


def test_one_height_has_no_lean() -> None:
    planned = replace(survey(0.0, 120.0, 240.0), bands=slices(np.array([50.0]), 0.01))
    assert isinstance(predict_survey(planned), FitFailure)


def test_detectable_means_the_same_as_between_epochs_that_were_measured() -> None:
    assert stated.DETECTABLE_FACTOR == DETECTABLE_FACTOR
    found = lean(survey(0.0, 120.0, 240.0))
    expected_m = 3.7257 * np.sqrt(2.0) * found.sigma_worst * 102.0
    assert found.smallest_detectable_m(102.0) == pytest.approx(expected_m)


def test_causes_add_up_to_the_whole() -> None:
    found = lean(survey(0.0, 50.0, errors=replace(ERRORS, form_m=0.004)))
    assert sum(found.shares.values()) == pytest.approx(1.0)
    assert found.sigma_best <= found.sigma_worst
    assert found.sigma_worst**2 + found.sigma_best**2 == pytest.approx(np.trace(found.covariance))


def test_two_stations_of_one_name_are_misuse() -> None:
    one = Site("ST01", (0.0, 100.0, 1.0))
    with pytest.raises(ShapeError, match="a name of its own"):
        replace(survey(0.0), sites=(one, one))


def test_levels_that_are_adjusted_along_count_alike_wherever_the_stations_stand() -> None:
    """A near station has more points; only a fit that takes its level as it is lets it decide."""
    near = Site("near", (0.0, -120.0, 1.6))
    sites = (*(Site(f"far {i}", (260.0 * (i - 1), 260.0 * (i == 1), 1.6)) for i in range(3)), near)
    held = replace(survey(0.0), sites=sites)
    adjusted = replace(held, errors=replace(held.errors, levels="adjusted"))
    pulls_held, pulls_adjusted = lean(held).pull, lean(adjusted).pull
    assert np.ptp(pulls_held) > 0.1
    assert pulls_adjusted == pytest.approx(0.25, abs=0.02)
    assert lean(adjusted).sigma_worst < lean(held).sigma_worst
