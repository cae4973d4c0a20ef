"""Horizontal cuts of a leaning cone, against the exact ellipses in which a plane meets it."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.axis.cone_cut import cone_cut_factor, take_out_cone_cut

HEIGHT_M = 102.0


def cut_centre(axis: NDArray[np.float64], taper: float, z_m: float) -> NDArray[np.float64]:
    """Centre (2,) of the ellipse in which the plane at z meets a cone with its apex at the origin."""
    across = np.linalg.svd(axis[None, :])[2][1:]
    turn = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    rays = axis + taper * (np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1])
    x, y = (rays[:, :2] * (z_m / rays[:, 2])[:, None]).T
    scale = np.abs([x, y]).max()
    x, y = x / scale, y / scale
    conic = np.linalg.svd(np.column_stack([x * x, x * y, y * y, x, y, np.ones(12)]))[2][-1]
    a, b, c, d, e, _ = conic
    return np.asarray(scale * np.linalg.solve([[2 * a, b], [b, 2 * c]], [-d, -e]))


def lean_of_cuts(tilt_deg: float, azimuth_deg: float, taper: float) -> NDArray[np.float64]:
    """Lean of the line through the centres of two cuts of a cone that narrows upwards."""
    tilt, azimuth = np.radians([tilt_deg, azimuth_deg])
    axis = np.array([np.sin(tilt) * np.sin(azimuth), np.sin(tilt) * np.cos(azimuth), np.cos(tilt)])
    low, high = cut_centre(axis, taper, -250.0), cut_centre(axis, taper, -150.0)
    return np.asarray((high - low) / 100.0)


@pytest.mark.parametrize(
    ("tilt_deg", "taper", "printed_mm", "digit_mm"),
    [
        (0.58, 0.01, 0.10, 0.01),
        (0.58, 0.02, 0.41, 0.01),
        (0.58, 0.05, 2.6, 0.1),
        (5.0, 0.01, 0.9, 0.1),
        (5.0, 0.02, 3.6, 0.1),
        (5.0, 0.05, 22.0, 1.0),
    ],
)
def test_cuts_lean_more_by_the_factor_and_the_printed_deviation(
    tilt_deg: float, taper: float, printed_mm: float, digit_mm: float
) -> None:
    true = np.tan(np.radians(tilt_deg))
    found = float(np.hypot(*lean_of_cuts(tilt_deg, 0.0, taper)))
    assert found / true == pytest.approx(cone_cut_factor(taper, np.radians(tilt_deg)), rel=1e-9)
    assert 1e3 * HEIGHT_M * (found - true) == pytest.approx(printed_mm, abs=digit_mm / 2)


@pytest.mark.parametrize("tilt_deg", [0.0, 0.58, 5.0, 30.0])
@pytest.mark.parametrize("taper", [-0.05, 0.0, 0.02, 0.3])
def test_correction_gives_the_axis_back(tilt_deg: float, taper: float) -> None:
    tilt, azimuth = np.radians([tilt_deg, 200.0])
    wanted = np.tan(tilt) * np.array([np.sin(azimuth), np.cos(azimuth)])
    cuts = wanted * cone_cut_factor(taper, tilt)
    assert take_out_cone_cut(cuts, np.eye(2), taper).lean == pytest.approx(wanted, abs=1e-14)


def test_correction_holds_in_any_direction_of_lean() -> None:
    cuts = lean_of_cuts(5.0, 133.0, 0.05)
    wanted = np.tan(np.radians(5.0)) * np.array([np.sin(np.radians(133.0)), np.cos(np.radians(133.0))])
    assert take_out_cone_cut(cuts, np.eye(2), 0.05).lean == pytest.approx(wanted, abs=1e-10)


def test_covariance_is_that_of_the_scatter_through_the_correction() -> None:
    rng = np.random.default_rng(1)
    lean, covariance = np.array([0.5, -0.3]), np.array([[4e-6, 1e-6], [1e-6, 2e-6]])
    drawn = rng.multivariate_normal(lean, covariance, 4000)
    corrected = [take_out_cone_cut(one, covariance, 0.5).lean for one in drawn]
    # 4000 draws: 0.03 of a variance
    stated = take_out_cone_cut(lean, covariance, 0.5).covariance
    np.testing.assert_allclose(np.cov(np.array(corrected).T), stated, atol=0.06 * stated[0, 0])


def test_cylinder_needs_no_correction() -> None:
    lean, covariance = np.array([0.01, 0.02]), np.diag([1e-8, 2e-8])
    corrected = take_out_cone_cut(lean, covariance, 0.0)
    assert corrected.lean == pytest.approx(lean, rel=1e-15)
    np.testing.assert_allclose(corrected.covariance, covariance, rtol=1e-15)


def test_cone_that_a_plane_cuts_in_no_ellipse_is_misuse() -> None:
    with pytest.raises(InputError, match=r"below 1, got 1\.73205"):
        cone_cut_factor(1.0, np.radians(60.0))
