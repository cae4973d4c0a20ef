"""The schemes of a user's own, from the campaign file to what the stages are asked."""

from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.axis import AXES
from tasks.contours import CONTOURS
from tasks.methods import Method, methods_of
from tasks.plan import plan_axes, plan_sight_noise
from tasks.settings import Campaign
from tasks.slicing import AdaptiveCut
from tasks.surface import SURFACES
from tests.unit.settings.campaign_text import WHOLE, edited, load

FLAT = "shaft_z_m = [2.0, 102.0]"


def with_scheme(folder: Path, lines: str, text: str = WHOLE) -> Campaign:
    return load(folder, edited("interval_m = 2.5", lines, text))


@pytest.mark.parametrize("contour", CONTOURS)
def test_every_contour_can_be_asked_for_and_changes_method_robust_only(tmp_path: Path, contour: str) -> None:
    campaign = with_scheme(tmp_path, f'interval_m = 2.5\ncontour = "{contour}"')
    paper, robust = methods_of(campaign.schemes["G"].as_scheme("G"))
    assert (paper.contour, paper.axis) == ("kasa", "irls")
    assert (robust.contour, robust.axis) == (contour, "robust_line")


@pytest.mark.parametrize("axis", AXES)
def test_every_axis_can_be_asked_for_and_changes_method_robust_only(tmp_path: Path, axis: str) -> None:
    campaign = with_scheme(tmp_path, f'interval_m = 2.5\naxis = "{axis}"')
    paper, robust = methods_of(campaign.schemes["G"].as_scheme("G"))
    assert (paper.contour, paper.axis) == ("kasa", "irls")
    assert (robust.contour, robust.axis) == ("robust_circle", axis)


@pytest.mark.parametrize("surface", SURFACES)
def test_every_surface_can_be_asked_for(tmp_path: Path, surface: str) -> None:
    campaign = with_scheme(tmp_path, f'surface = "{surface}"')
    assert campaign.schemes["G"].as_scheme("G").surface == surface


@pytest.mark.parametrize(
    ("lines", "cut"),
    [
        ("adaptive = 0.002", AdaptiveCut(0.002, 0.02, 2.0)),
        ("adaptive = { sigma_center_m = 0.002 }", AdaptiveCut(0.002, 0.02, 2.0)),
        (
            "adaptive = { sigma_center_m = 0.001, least_thickness_m = 0.1, most_thickness_m = 5.0 }",
            AdaptiveCut(0.001, 0.1, 5.0),
        ),
    ],
)
def test_adaptive_is_a_sigma_or_a_table(tmp_path: Path, lines: str, cut: AdaptiveCut) -> None:
    (axis,) = plan_axes(with_scheme(tmp_path, lines), ["G"])
    assert axis.scheme.adaptive == cut
    assert axis.method == Method("robust", "robust_circle", "robust_line", cut.least_thickness_m)


@pytest.mark.parametrize(
    ("shaft", "lines", "fault"),
    [
        (
            "shaft_z_m = [2.0, 5.0]",
            "adaptive = 0.002",
            "schemes.G.adaptive: most_thickness_m = 2 leaves 1 slice on the 3 m of shaft_z_m where points are few; an "
            "axis needs at least 2; write { sigma_center_m = 0.002, most_thickness_m = 1.5 } or less",
        ),
        (
            "shaft_z_m = [2.0, 102.5]",
            "adaptive = { sigma_center_m = 0.002, least_thickness_m = 0.005 }",
            "schemes.G.adaptive: least_thickness_m = 0.005 may make more than 20000 slices; write at least 0.006",
        ),
    ],
)
def test_slices_that_follow_the_points_are_counted(
    tmp_path: Path, shaft: str, lines: str, fault: str
) -> None:
    with pytest.raises(InputError) as caught:
        with_scheme(tmp_path, lines, edited(FLAT, shaft))
    assert fault in str(caught.value)


def test_an_adaptive_scheme_has_no_method_paper_to_report(tmp_path: Path) -> None:
    text = edited('primary = ["S", "surface"]', 'primary = ["G", "paper"]')
    with pytest.raises(InputError, match="'G' has no method 'paper'; G goes with robust"):
        with_scheme(tmp_path, "adaptive = 0.002", text)


def test_the_noise_of_sights_is_asked_for_where_it_counts_and_stations_are_known(tmp_path: Path) -> None:
    weighing = next(name for name, model in CONTOURS.items() if model.weighs_sights)
    campaign = with_scheme(
        tmp_path, f'adaptive = 0.002\n[schemes.H]\ninterval_m = 5.0\ncontour = "{weighing}"'
    )
    stations, registered = campaign.epochs
    asked = {axis.label for axis in plan_axes(campaign) if plan_sight_noise(campaign, stations, axis)}
    assert asked == {"G/robust", "H/robust"}
    assert not any(plan_sight_noise(campaign, registered, axis) for axis in plan_axes(campaign))


def test_the_noise_of_sights_is_what_the_maker_states(tmp_path: Path) -> None:
    campaign = with_scheme(tmp_path, "adaptive = 0.002")
    (axis,) = plan_axes(campaign, ["G"])
    noise = plan_sight_noise(campaign, campaign.epochs[0], axis)
    assert noise is not None
    assert noise.range_sigma_m == 0.005
    assert noise.angle_sigma_rad == pytest.approx(1.7453e-5, rel=1e-4)
