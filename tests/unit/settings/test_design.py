"""The designed shape in the campaign file."""

from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.plan import plan_mapped_axis, plan_surface_map
from tests.unit.settings.campaign_text import edited, load

RADII = "design_radius_m = [[0.0, 4.62], [60.0, 3.5], [102.0, 2.7]]\n"
BASE = "base_xy_m = [0.0, 0.0]\n"


def designed(lines: str) -> str:
    return edited(BASE, BASE + lines)


def test_without_a_design_there_is_none(tmp_path: Path) -> None:
    question = plan_surface_map(load(tmp_path, edited("", "")))
    assert question.design is None
    assert question.shaft_z_m == (2.0, 102.0)


def test_a_design_is_plumb_and_starts_at_the_measured_foot_unless_it_says_otherwise(tmp_path: Path) -> None:
    design = plan_surface_map(load(tmp_path, designed(RADII))).design
    assert design is not None
    assert (design.z_m, design.radius_m) == ((0.0, 60.0, 102.0), (4.62, 3.5, 2.7))
    assert (design.lean, design.base_xy_m) == ((0.0, 0.0), None)


def test_the_base_of_a_design_is_in_the_order_of_the_axes_and_its_lean_is_not(tmp_path: Path) -> None:
    lines = RADII + "design_lean = [0.001, -0.002]\ndesign_base_xy_m = [3.0, 7.0]\n"
    design = plan_surface_map(load(tmp_path, edited('axes = "ENU"', 'axes = "NEU"', designed(lines)))).design
    assert design is not None
    assert (design.lean, design.base_xy_m) == ((0.001, -0.002), (7.0, 3.0))


@pytest.mark.parametrize(
    ("lines", "line"),
    [
        (
            "design_radius_m = [[3.0, 4.6], [102.0, 2.7]]",
            "structure.design_radius_m: goes from 3 to 102 m and leaves out a part of shaft_z_m [2, 102]; add the",
        ),
        (
            "design_radius_m = [[0.0, 4.6], [101.0, 2.7]]",
            "structure.design_radius_m: goes from 0 to 101 m and leaves out a part of shaft_z_m [2, 102]",
        ),
        (
            "design_radius_m = [[0.0, 4.6]]",
            "structure.design_radius_m: needs two heights or more, got 1; write [[",
        ),
        (
            "design_radius_m = [[102.0, 2.7], [0.0, 4.6]]",
            "structure.design_radius_m: heights must rise, each height once; sort the points by height",
        ),
        (
            "design_radius_m = [[0.0, 4.6], [102.0, 0.0]]",
            "structure.design_radius_m[#2][#2]: should be greater than 0, got 0.0",
        ),
        (
            RADII + "design_lean = [0.4, 0.9]",
            "structure.design_lean[#2]: should be less than or equal to 0.5, got 0.9",
        ),
        (
            "design_lean = [0.001, 0.0]",
            "structure.design_lean: is a part of a design that has no radii; add design_radius_m or drop it",
        ),
        (
            "design_base_xy_m = [0.0, 0.0]",
            "structure.design_base_xy_m: is a part of a design that has no radii",
        ),
    ],
)
def test_a_fault_of_a_design_is_told_in_its_place(tmp_path: Path, lines: str, line: str) -> None:
    with pytest.raises(InputError, match=r"campaign\.toml: ") as caught:
        load(tmp_path, designed(lines + "\n"))
    assert line in str(caught.value)


@pytest.mark.parametrize(
    ("primary", "axis"), [('["A", "robust"]', ("S", "surface")), ('["S", "surface"]', ("S", "surface"))]
)
def test_the_map_rests_on_a_whole_surface(tmp_path: Path, primary: str, axis: tuple[str, str]) -> None:
    campaign = load(tmp_path, edited('primary = ["S", "surface"]', f"primary = {primary}"))
    assert plan_mapped_axis(campaign) == axis
