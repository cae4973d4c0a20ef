import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.registration import Registration, StationScan, register_stations
from tasks.registration.observability import NAMES, weakest_direction
from tests.unit.registration.conftest import bare_cylinder, succeed
from tests.unit.registration.courtyard import SIGMAS

PRIOR = np.diag(
    np.tile(np.array([SIGMAS.level_rad, SIGMAS.level_rad, SIGMAS.heading_rad, 0.015, 0.015, 0.0225]), 2)
    ** -2.0
)


def compared(weak: int) -> NDArray[np.float64]:
    """What two stations say of each other, in units that compare: little of one direction, much of all others."""
    scale = np.r_[np.full(3, 100.0), np.ones(3)] * 1e3
    scale[weak] *= 1e-4
    apart = np.hstack([np.diag(scale), -np.diag(scale)])
    return np.asarray(apart.T @ apart)


@pytest.fixture(scope="module")
def bare() -> Registration:
    """Two stations that both see a round shaft all around, and nothing else."""
    rng = np.random.default_rng(5)
    scans = [
        StationScan(name, bare_cylinder(rng) + 0.002 * rng.normal(size=(40_000, 3)), np.zeros(3), 0.0)
        for name in ("ST01", "ST02")
    ]
    return succeed(register_stations(scans, SIGMAS))


@pytest.mark.parametrize("weak", range(6))
def test_the_direction_of_which_the_scans_say_least_is_named(weak: int) -> None:
    assert weakest_direction(compared(weak), PRIOR, 0) == NAMES[weak]
    assert weakest_direction(compared(weak), PRIOR, 1) == NAMES[weak]


def test_scans_that_share_nothing_have_no_weakest_direction() -> None:
    assert weakest_direction(np.zeros((12, 12)), PRIOR, 0) is None


def test_yaw_or_height_is_named_on_a_bare_round_shaft(bare: Registration) -> None:
    for diagnosis in bare.diagnoses:
        assert diagnosis.weakest_direction in {"heading", "shift up"}


def test_heading_about_a_bare_round_shaft_stays_as_uncertain_as_it_is_stated(bare: Registration) -> None:
    for diagnosis in bare.diagnoses:
        assert diagnosis.sigma_heading_rad == pytest.approx(SIGMAS.heading_rad, rel=0.03)


def test_heading_about_a_bare_round_shaft_is_not_moved_by_the_scans(bare: Registration) -> None:
    for diagnosis in bare.diagnoses:
        assert diagnosis.heading_correction_rad is not None
        assert abs(diagnosis.heading_correction_rad) < 0.2 * SIGMAS.heading_rad


def test_height_of_a_cylinder_stays_as_uncertain_as_it_is_stated(bare: Registration) -> None:
    sigmas = np.sqrt(np.diag(bare.covariance)).reshape(-1, 6)
    assert sigmas[:, 5] == pytest.approx(0.0225, rel=0.03)


def test_a_cylinder_shows_where_two_stations_stand_against_each_other(bare: Registration) -> None:
    apart = np.zeros(12)
    apart[[3, 9]] = 1.0, -1.0
    assert np.sqrt(apart @ bare.covariance @ apart) < 0.1 * np.sqrt(2.0) * 0.015
