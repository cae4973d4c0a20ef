"""The difference of two axes: what is in both cancels, what is not adds up."""

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.change import FrameOf, ParameterChange, hold_radius, parameter_change
from tasks.geometry.axis_parameters import AxisParameters, JointParts, as_stated
from tests.unit.change.parameters import NAMES, SIGMAS, correlated, parameters

ZERO = np.zeros(len(NAMES))
OWN = correlated(1)


def change(
    before: AxisParameters, after: AxisParameters, alike: float = 1.0, frame_of: FrameOf = None
) -> ParameterChange:
    return parameter_change(before, after, alike, frame_of)


def test_independent_epochs_add_their_covariances() -> None:
    found = change(parameters(ZERO, OWN), parameters(SIGMAS, correlated(2)))
    assert found.difference == pytest.approx(SIGMAS)
    assert found.covariance == pytest.approx(OWN + correlated(2), rel=1e-12)


def test_form_that_both_saw_alike_cancels() -> None:
    with_form = parameters(ZERO, OWN, form=4.0)
    assert change(with_form, with_form).covariance == pytest.approx(2.0 * OWN, rel=1e-6, abs=1e-16)


def test_form_that_each_saw_otherwise_adds_up() -> None:
    with_form = parameters(ZERO, OWN, form=4.0)
    assert change(with_form, with_form, alike=0.0).covariance == pytest.approx(2.0 * with_form.covariance)


@pytest.mark.parametrize("alike", [0.0, 0.3, 0.9, 1.0])
def test_difference_never_has_a_negative_variance(alike: float) -> None:
    first, second = parameters(ZERO, 1e-3 * OWN, form=4.0), parameters(ZERO, 1e-3 * OWN, form=1.0, seed=20)
    scale = np.outer(SIGMAS, SIGMAS)
    assert np.linalg.eigvalsh(change(first, second, alike).covariance / scale)[0] > 0.0


def test_frame_of_the_reference_epoch_cancels_against_that_epoch() -> None:
    tied = parameters(ZERO, OWN, frame=3.0)
    # the reference epoch itself: its frame's errors are its own
    reference = AxisParameters(NAMES, ZERO, tied.covariance, tied.form_covariance, 0.0 * OWN)
    found = change(reference, tied, frame_of="before").covariance
    assert found == pytest.approx(2.0 * OWN, rel=1e-9, abs=1e-16)
    assert change(tied, reference, frame_of="after").covariance == pytest.approx(found)
    assert change(reference, tied).covariance == pytest.approx(2.0 * tied.covariance)


def test_two_epochs_tied_to_one_frame_share_its_errors() -> None:
    tied = parameters(ZERO, OWN, frame=3.0)
    assert change(tied, tied).covariance == pytest.approx(2.0 * OWN, rel=1e-6, abs=1e-16)


def test_units_of_the_parameters_do_not_matter() -> None:
    first, second = parameters(ZERO, OWN, form=4.0), parameters(ZERO, OWN, form=1.0, seed=20)
    scale = np.array([1.0, 1.0, 100.0, 100.0, 1.0, 1.0, 1.0, 1.0])
    both = np.outer(scale, scale)

    def scaled(one: AxisParameters) -> AxisParameters:
        parts = (one.covariance * both, one.form_covariance * both, one.frame_covariance * both)
        return AxisParameters(NAMES, one.values * scale, *parts)

    assert change(scaled(first), scaled(second)).covariance / both == pytest.approx(
        change(first, second).covariance, rel=1e-9, abs=1e-20
    )


def test_only_parameters_that_both_have_are_compared() -> None:
    after = parameters(SIGMAS, OWN)
    places = [0, 1, 2, 3, 6]
    less = AxisParameters(
        tuple(NAMES[place] for place in places),
        ZERO[places],
        *(part[np.ix_(places, places)] for part in (OWN, 0.0 * OWN, 0.0 * OWN)),
    )
    assert change(less, after).names == less.names
    assert change(after, less).difference == pytest.approx(-SIGMAS[places])


def test_likeness_is_a_correlation() -> None:
    with pytest.raises(ShapeError, match="from 0 to 1"):
        change(parameters(ZERO, OWN), parameters(ZERO, OWN), alike=1.5)


def test_held_radius_takes_out_what_an_arc_confuses_with_the_lean() -> None:
    # on an arc the lean to the north follows the taper almost alone
    mix = np.zeros((len(NAMES), len(NAMES)))
    mix[3, 7] = 6e-3
    joined = (np.eye(len(NAMES)) + mix) @ np.diag(SIGMAS**2) @ (np.eye(len(NAMES)) + mix).T
    drawn = np.zeros(len(NAMES))
    drawn[7] = 2e-3
    after = parameters((np.eye(len(NAMES)) + mix) @ drawn, joined)
    free = change(parameters(ZERO, joined), after)
    held = hold_radius(free)
    assert held.basis == "radius held"
    assert not any(name.startswith("radius") for name in held.names)
    assert free.of("lean_")[0] == pytest.approx([0.0, 1.2e-5], rel=1e-6)
    assert held.of("lean_")[0] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert held.of("lean_")[1][1, 1] == pytest.approx(2.0 * SIGMAS[3] ** 2, rel=1e-6)


def test_holding_the_radius_never_makes_anything_less_certain() -> None:
    free = change(parameters(ZERO, OWN), parameters(SIGMAS, correlated(2)))
    held = hold_radius(free)
    for prefix in ("lean_", "base_", "bend_"):
        less = free.of(prefix)[1] - held.of(prefix)[1]
        assert np.linalg.eigvalsh(less)[0] > -1e-12 * np.trace(free.of(prefix)[1])


def test_stations_that_contradict_each_other_make_all_they_measured_less_certain() -> None:
    lean = [2, 3]
    stated = 4.0 * OWN[np.ix_(lean, lean)]
    made = as_stated(NAMES, ZERO, JointParts(OWN, 0.0 * OWN, 0.0 * OWN), stated, np.zeros((2, 2)))
    assert made.covariance == pytest.approx(4.0 * OWN, rel=1e-9)


def test_parameters_carry_the_covariance_that_is_stated_for_the_lean() -> None:
    stated, form = np.diag([4e-11, 3e-11]), np.diag([1e-11, 1e-11])
    made = as_stated(NAMES, ZERO, JointParts(OWN, correlated(4, 0.1), 0.0 * OWN), stated, form)
    lean = made.places(("lean_east", "lean_north"))
    assert made.covariance[np.ix_(lean, lean)] == pytest.approx(stated, rel=1e-9, abs=1e-20)
    assert made.form_covariance[np.ix_(lean, lean)] == pytest.approx(form, rel=1e-9, abs=1e-20)
    base = made.places(("base_east", "base_north"))
    assert made.covariance[np.ix_(base, base)] == pytest.approx(
        (OWN + correlated(4, 0.1))[np.ix_(base, base)], rel=1e-9
    )
    assert np.linalg.eigvalsh(made.covariance / np.outer(SIGMAS, SIGMAS))[0] > 0.0
