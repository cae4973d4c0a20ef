import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.surface.choice import Evidence, choose_form, fullest_form
from tasks.surface.form import Form, kept_in
from tests.unit.surface.cells_by_hand import SHAFT_Z_M, equations_of

STRAIGHT = Form(SHAFT_Z_M, axis_order=1, radius_intervals=8)
EVIDENCE = Evidence(n_independent=2000.0, wall_m2=0.0)


def covariance_of(form: Form, seed: int = 1) -> NDArray[np.float64]:
    """Coefficients that are known to some 1 mm and hang together."""
    A = np.random.default_rng(seed).normal(size=(4 * form.size, form.size)) / np.sqrt(4 * form.size)
    return np.asarray(1e-6 * np.linalg.inv(A.T @ A))


def independent(form: Form) -> NDArray[np.float64]:
    """Coefficients that are known to 1 mm each."""
    return np.asarray(1e-6 * np.eye(form.size))


def values_of(form: Form, **terms_m: float) -> NDArray[np.float64]:
    """Coefficients of a straight, round shaft; ``east2``, ``north3`` are bending terms, metres."""
    values = np.zeros(form.size)
    values[[0, 1, form.n_axis, form.n_axis + 1]] = [0.3, 0.36, -0.2, -0.28]
    values[2 * form.n_axis : 2 * form.n_axis + form.n_radius] = 3.6
    for name, size in terms_m.items():
        component = 0 if name.startswith("east") else form.n_axis
        values[component + int(name[-1])] = size
    return values


def test_one_straight_shaft_in_a_hundred_is_taken_for_a_bent_one() -> None:
    full = fullest_form(STRAIGHT, 120.0)
    bendable = Form(SHAFT_Z_M, full.axis_order, full.radius_intervals)
    covariance = covariance_of(bendable)
    root, equations = np.linalg.cholesky(covariance), equations_of(bendable, covariance)
    rng = np.random.default_rng(2)
    n, truth = 3000, values_of(bendable)
    bent = sum(
        choose_form(
            bendable, truth + root @ rng.standard_normal(bendable.size), equations, EVIDENCE
        ).axis_model
        != "straight"
        for _ in range(n)
    )
    # sd of the share 0.18 %
    assert bent / n == pytest.approx(0.01, abs=0.006)


@pytest.mark.parametrize(
    ("terms_m", "model"),
    [({"east2": 0.02}, "parabola"), ({"north3": 0.02}, "cubic"), ({"east2": 0.02, "north3": 0.02}, "cubic")],
)
def test_bending_far_beyond_its_sigma_is_found_to_its_order(terms_m: dict[str, float], model: str) -> None:
    full = fullest_form(STRAIGHT, 360.0)
    choice = choose_form(full, values_of(full, **terms_m), equations_of(full, independent(full)), EVIDENCE)
    assert choice.axis_model == model
    assert "20.00 mm" in choice.axis_reason


def test_a_round_section_stays_round() -> None:
    full = fullest_form(STRAIGHT, 360.0)
    covariance = covariance_of(full)
    root, equations = np.linalg.cholesky(covariance), equations_of(full, covariance)
    rng = np.random.default_rng(3)
    found = [
        choose_form(full, values_of(full) + root @ rng.standard_normal(full.size), equations, EVIDENCE)
        for _ in range(30)
    ]
    assert [choice.asked_for.harmonics for choice in found] == [0] * 30


def test_an_oval_asks_for_the_second_harmonic_as_it_changes_with_height() -> None:
    full = fullest_form(STRAIGHT, 360.0)
    values = values_of(full)
    first = 2 * full.n_axis + full.n_radius
    values[first] = 0.03
    choice = choose_form(full, values, equations_of(full, independent(full)), EVIDENCE)
    assert (choice.asked_for.harmonics, choice.asked_for.harmonic_order) == (2, 0)
    values[first + 1] = 0.01
    choice = choose_form(full, values, equations_of(full, independent(full)), EVIDENCE)
    assert (choice.asked_for.harmonics, choice.asked_for.harmonic_order) == (2, 1)


def test_terms_that_cost_the_lean_nothing_are_kept() -> None:
    full = fullest_form(STRAIGHT, 360.0)
    choice = choose_form(full, values_of(full), equations_of(full, independent(full)), EVIDENCE)
    assert choice.asked_for.axis_order == 1
    assert choice.kept.axis_order == full.axis_order
    assert choice.kept.free == (0, 0)


def test_terms_that_cost_the_lean_are_dropped_unless_the_data_ask_for_them() -> None:
    full = fullest_form(STRAIGHT, 120.0)
    covariance = independent(full)
    lobe = full.size - 1
    slope = full.lean_rows[0]
    covariance[slope, lobe] = covariance[lobe, slope] = 0.9e-6
    choice = choose_form(full, values_of(full), equations_of(full, covariance), EVIDENCE)
    assert choice.kept == choice.asked_for
    assert choice.kept.harmonics == 0


@pytest.mark.parametrize(("coverage_deg", "harmonics"), [(360.0, 6), (300.0, 6), (285.0, 3), (120.0, 2)])
def test_the_shorter_the_arc_the_fewer_harmonics_are_tried(coverage_deg: float, harmonics: int) -> None:
    full = fullest_form(STRAIGHT, coverage_deg)
    assert full.free == (harmonics, 2)
    assert full.harmonics == 6
    assert np.count_nonzero(full.held) == 2 * 3 * (6 - harmonics)


def test_a_smaller_form_keeps_its_terms_in_a_larger_one() -> None:
    full = fullest_form(STRAIGHT, 360.0)
    z_m = np.linspace(*SHAFT_Z_M, 7)
    places = kept_in(STRAIGHT, full)
    assert len(places) == STRAIGHT.size
    assert STRAIGHT.axis_terms(z_m) == pytest.approx(full.axis_terms(z_m)[:, :2])
    assert [places.index(row) for row in full.lean_rows] == STRAIGHT.lean_rows
