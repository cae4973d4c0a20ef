import numpy as np
import pytest

from storage.errors import InputError, ShapeError
from tasks.slicing import SCHEMES, AdaptiveCut, SlicingScheme, slice_heights, user_scheme

PAPER_SHAFT_M = (0.0, 100.01)


@pytest.mark.parametrize(("name", "count"), [("A", 101), ("B", 21), ("C", 11), ("D", 6), ("E", 2), ("F", 2)])
def test_paper_shaft_is_cut_into_the_paper_number_of_slices(name: str, count: int) -> None:
    assert len(slice_heights(SCHEMES[name], PAPER_SHAFT_M)) == count


@pytest.mark.parametrize("name", SCHEMES)
def test_every_slice_fits_whole_into_the_shaft(name: str) -> None:
    scheme = SCHEMES[name]
    heights = slice_heights(scheme, (2.0, 102.0))
    half = scheme.thickness_m / 2
    assert heights.min() - half >= 2.0 - 1e-9
    assert heights.max() + half <= 102.0 + 1e-9
    assert (np.diff(heights) > 0).all()


def test_first_mid_height_is_half_a_slice_above_the_lower_end() -> None:
    assert slice_heights(SCHEMES["A"], (2.0, 102.0))[0] == pytest.approx(2.005, abs=1e-12)


def test_one_more_metre_does_not_fit_when_half_a_slice_sticks_out() -> None:
    heights = slice_heights(SCHEMES["A"], (2.0, 102.0))
    assert len(heights) == 100
    assert heights[-1] == pytest.approx(101.005, abs=1e-9)


def test_end_slices_lie_at_both_ends() -> None:
    assert slice_heights(SCHEMES["E"], (2.0, 102.0)) == pytest.approx([2.005, 101.995], abs=1e-12)


def test_only_the_control_scheme_takes_vertices() -> None:
    assert {name for name, scheme in SCHEMES.items() if scheme.contour == "vertex_mean"} == {"F"}
    assert {name for name, scheme in SCHEMES.items() if scheme.axis == "two_points"} == {"E", "F"}


def test_shaft_of_one_thickness_gives_one_slice_and_a_shorter_one_none() -> None:
    assert slice_heights(SCHEMES["E"], (5.0, 5.01)) == pytest.approx([5.005], abs=1e-12)
    assert len(slice_heights(SCHEMES["A"], (5.0, 5.005))) == 0


def test_user_heights_come_out_ascending() -> None:
    scheme = user_scheme("G", heights_m=[30.0, 10.0, 20.0])
    assert slice_heights(scheme, (0.0, 40.0)).tolist() == [10.0, 20.0, 30.0]


def test_user_interval_and_thickness_are_used() -> None:
    scheme = user_scheme("G", interval_m=2.5, thickness_m=0.5)
    assert slice_heights(scheme, (0.0, 10.5)) == pytest.approx([0.25, 2.75, 5.25, 7.75, 10.25])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "got none"),
        ({"interval_m": 1.0, "heights_m": [1.0, 2.0]}, "got interval_m and heights_m"),
        ({"interval_m": 1.0, "adaptive": AdaptiveCut(0.002)}, "got interval_m and adaptive"),
        ({"adaptive": AdaptiveCut(0.0)}, "adaptive.sigma_center_m above 0 m, got 0"),
        (
            {"adaptive": AdaptiveCut(0.002, 0.5, 0.1)},
            "least_thickness_m up to most_thickness_m, got 0.5 and 0.1",
        ),
        ({"interval_m": -1.0}, "interval_m above 0 m, got -1"),
        ({"interval_m": 0.0}, "interval_m above 0 m, got 0"),
        ({"interval_m": float("nan")}, "interval_m above 0 m, got nan"),
        ({"interval_m": 1.0, "thickness_m": 0.0}, "thickness_m above 0 m"),
        ({"heights_m": [1.0]}, "at least 2 heights_m for an axis, got 1"),
        ({"heights_m": [1.0, 1.0]}, "heights_m that differ"),
        ({"heights_m": [1.0, float("inf")]}, "finite heights_m"),
    ],
)
def test_user_scheme_that_makes_no_sense_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        user_scheme("G", **arguments)  # type: ignore[arg-type]


def test_heights_outside_the_shaft_are_named() -> None:
    scheme = user_scheme("G", heights_m=[-3.0, 5.0, 41.0])
    with pytest.raises(InputError, match=r"heights_m outside the shaft: \[-3.0, 41.0\]"):
        slice_heights(scheme, (0.0, 40.0))


def test_interval_in_the_wrong_unit_is_refused() -> None:
    with pytest.raises(InputError, match="at most 1000000"):
        slice_heights(user_scheme("G", interval_m=1e-9), (0.0, 100.0))


def test_upside_down_shaft_is_misuse() -> None:
    with pytest.raises(ShapeError, match="lo < hi"):
        slice_heights(SCHEMES["A"], (100.0, 0.0))


def test_scheme_that_says_nothing_is_misuse() -> None:
    with pytest.raises(ShapeError, match="exactly one of"):
        SlicingScheme("G", "nothing")
