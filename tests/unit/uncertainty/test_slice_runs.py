import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.uncertainty import form_of_slices, leverage

HEIGHTS_M = np.linspace(2.0, 102.0, 101)
LEVERS = leverage(HEIGHTS_M, np.ones(101))
SIGMA_M = 0.004


def centres(wall_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centres (101, 3) of a leaning shaft that its wall draws aside by (101, 2)."""
    return np.column_stack([np.outer(HEIGHTS_M, [0.007, -0.0057]) + wall_m, HEIGHTS_M])


def independent() -> NDArray[np.float64]:
    """Covariance of the lean if no slice knows of its neighbour."""
    return np.asarray(SIGMA_M**2 * float(LEVERS @ LEVERS) * np.eye(2))


def white(rng: np.random.Generator) -> NDArray[np.float64]:
    return np.asarray(SIGMA_M * rng.standard_normal((101, 2)))


def rough(rng: np.random.Generator, length: int = 5) -> NDArray[np.float64]:
    """The same standard deviation, correlated over that many slices: a running mean of white noise."""
    noise = rng.standard_normal((101 + length - 1, 2))
    total = np.array([np.convolve(column, np.ones(length), mode="valid") for column in noise.T]).T
    return np.asarray(SIGMA_M / np.sqrt(length) * total)


def test_slices_that_err_alone_say_nothing_of_the_wall() -> None:
    rng = np.random.default_rng(1)
    found = [form_of_slices(centres(white(rng)), LEVERS, independent()) for _ in range(200)]
    # three lengths of runs, each beyond two standard deviations in some 3 of 100
    assert np.mean([bool(form.any()) for form in found]) < 0.15
    assert np.trace(np.mean(found, axis=0)) < 0.15 * np.trace(independent())


def test_slices_that_err_with_their_neighbours_state_the_scatter_of_the_lean() -> None:
    rng = np.random.default_rng(2)
    walls = [rough(rng) for _ in range(200)]
    stated = [independent() + form_of_slices(centres(wall), LEVERS, independent()) for wall in walls]
    scatter = np.mean([np.sum((LEVERS @ wall) ** 2) for wall in walls])
    # of slices taken as independent the scatter is some four times the stated variance
    assert scatter > 3.0 * np.trace(independent())
    assert np.trace(np.mean(stated, axis=0)) == pytest.approx(scatter, rel=0.4)


def test_bending_is_the_shape_of_the_axis_and_no_error() -> None:
    rng = np.random.default_rng(3)
    share = (HEIGHTS_M - 2.0) / 100.0
    bent = np.outer(0.2 * share**2 - 0.1 * share**3, [1.0, -0.5])
    for _ in range(20):
        wall = white(rng)
        straight = form_of_slices(centres(wall), LEVERS, independent())
        assert form_of_slices(centres(wall + bent), LEVERS, independent()) == pytest.approx(
            straight, abs=1e-6 * float(np.trace(independent()))
        )


def test_few_slices_say_nothing_of_the_wall() -> None:
    wall = rough(np.random.default_rng(4))
    few = slice(0, 23)
    levers = leverage(HEIGHTS_M[few], np.ones(23))
    assert not form_of_slices(centres(wall)[few], levers, independent()).any()


def test_slices_without_a_lever_do_not_count() -> None:
    wall = rough(np.random.default_rng(5))
    used = np.arange(101) % 10 != 3
    levers = np.zeros(101)
    levers[used] = leverage(HEIGHTS_M[used], np.ones(used.sum()))
    spoiled = wall.copy()
    spoiled[~used] += 1.0
    assert form_of_slices(centres(spoiled), levers, independent()) == pytest.approx(
        form_of_slices(centres(wall)[used], levers[used], independent()), rel=1e-12
    )


def test_centres_that_stand_exactly_above_each_other_have_no_form() -> None:
    plumb = np.column_stack([np.zeros((101, 2)), HEIGHTS_M])
    assert not form_of_slices(plumb, LEVERS, independent()).any()
