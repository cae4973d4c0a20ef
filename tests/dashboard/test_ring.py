"""The contour that is drawn is the contour of the wall: against rings of points that are known."""

import numpy as np
import pytest
from numpy.typing import NDArray

from dashboard.content.harmonics import harmonics_of
from dashboard.content.ring import Arc, Polar, Ring, SeenFrom, polar_of, ring_of, sector_width_deg

RADIUS_M = 4.0


def ring_points(
    n: int = 20_000,
    sigma_m: float = 0.003,
    waves: dict[int, tuple[float, float]] | None = None,
    seed: int = 1,
) -> Polar:
    """Points on a circle with waves {order: (amplitude, azimuth of the first largest radius)}."""
    rng = np.random.default_rng(seed)
    azimuth = rng.uniform(0.0, 360.0, n)
    radial_m = RADIUS_M + rng.normal(0.0, sigma_m, n)
    for order, (amplitude_m, at_deg) in (waves or {}).items():
        radial_m += amplitude_m * np.cos(order * np.radians(azimuth - at_deg))
    return Polar(azimuth, radial_m)


def without(points: Polar, low_deg: float, high_deg: float) -> Polar:
    """The points but for those of an arc clockwise from low, which may go over north."""
    inside = (points.azimuth_deg - low_deg) % 360.0 < (high_deg - low_deg)
    return Polar(points.azimuth_deg[~inside], points.radial_m[~inside])


def test_a_wave_of_the_wall_is_the_wave_of_the_contour() -> None:
    ring = ring_of(ring_points(waves={2: (0.012, 35.0)}), RADIUS_M, 5.0)
    expected = 0.012 * np.cos(2.0 * np.radians(ring.azimuth_deg - 35.0))
    # four sigmas of a median of 277 points of 3 mm, and what the wave turns within half a sector
    np.testing.assert_allclose(ring.deviation_m, expected, atol=4 * 1.25 * 0.003 / np.sqrt(277) + 0.0006)


def test_the_stated_sigma_of_a_sector_is_the_scatter_of_its_median() -> None:
    rings = [ring_of(ring_points(7200, seed=seed), RADIUS_M, 10.0) for seed in range(60)]
    scatter = np.std([ring.deviation_m for ring in rings])
    assert np.mean([ring.sigma_m for ring in rings]) == pytest.approx(scatter, rel=0.05)


def test_points_far_off_the_wall_do_not_move_the_contour() -> None:
    points = ring_points()
    radial_m = points.radial_m.copy()
    radial_m[::10] += 0.5
    assert np.abs(ring_of(Polar(points.azimuth_deg, radial_m), RADIUS_M, 10.0).deviation_m).max() < 0.0015


@pytest.mark.parametrize(
    ("low", "high", "gap"),
    [(60.0, 120.0, Arc(60.0, 120.0)), (330.0, 390.0, Arc(330.0, 390.0)), (300.0, 360.0, Arc(300.0, 360.0))],
)
def test_a_gap_is_where_no_points_are(low: float, high: float, gap: Arc) -> None:
    ring = ring_of(without(ring_points(), low, high), RADIUS_M, 5.0)
    assert ring.gaps == (gap,)
    assert ring.coverage_deg == 300.0
    assert np.isnan(ring.deviation_m[~ring.seen]).all()


def test_several_gaps_are_told_clockwise() -> None:
    points = without(without(without(ring_points(), 200.0, 210.0), 40.0, 55.0), 355.0, 365.0)
    gaps = ring_of(points, RADIUS_M, 5.0).gaps
    assert {(gap.from_deg, gap.width_deg) for gap in gaps} == {(40.0, 15.0), (200.0, 10.0), (355.0, 10.0)}


def test_a_whole_ring_and_an_empty_one_have_no_gap() -> None:
    empty = Polar(np.empty(0), np.empty(0))
    assert ring_of(ring_points(), RADIUS_M, 5.0).gaps == ()
    assert ring_of(empty, RADIUS_M, 5.0).gaps == ()
    assert ring_of(empty, RADIUS_M, 5.0).range_m is None


def test_without_a_fitted_radius_deviations_are_from_the_middle_of_the_sectors() -> None:
    ring = ring_of(ring_points(), None, 10.0)
    assert ring.radius_m == pytest.approx(RADIUS_M, abs=2e-4)
    assert np.median(ring.deviation_m) == pytest.approx(0.0, abs=1e-12)


def test_a_range_is_that_of_the_medians() -> None:
    ring = Ring(4.0, 90.0, np.array([3, 3, 0, 3]), np.array([4.001, 3.99, np.nan, 4.02]), np.full(4, np.nan))
    assert ring.range_m == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("n_points", "width"), [(0, 10.0), (863, 10.0), (864, 5.0), (2159, 5.0), (2160, 2.0)]
)
def test_sectors_are_as_fine_as_twelve_points_each_allow(n_points: int, width: float) -> None:
    assert sector_width_deg(n_points) == width


def test_points_of_a_leaning_tapered_wall_come_to_the_middle_height() -> None:
    rng = np.random.default_rng(3)
    z_m, azimuth = rng.uniform(18.0, 22.0, 5000), rng.uniform(0.0, 2.0 * np.pi, 5000)
    lean, taper, centre = np.array([0.02, -0.01]), -0.03, np.array([7.0, -2.0])
    radial_m = RADIUS_M + taper * (z_m - 20.0)
    out = radial_m[:, None] * np.column_stack([np.sin(azimuth), np.cos(azimuth)])
    points_m = np.column_stack([centre + (z_m - 20.0)[:, None] * lean + out, z_m])
    polar = polar_of(points_m, SeenFrom(centre, 20.0, lean, taper))
    np.testing.assert_allclose(polar.radial_m, RADIUS_M, atol=1e-12)
    np.testing.assert_allclose(polar.azimuth_deg, np.degrees(azimuth), atol=1e-9)


def test_azimuths_are_clockwise_from_north_and_below_360() -> None:
    points_m = np.array(
        [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [-1e-300, 1.0, 0.0]]
    )
    polar = polar_of(points_m, SeenFrom(np.zeros(2), 0.0, np.zeros(2), 0.0))
    np.testing.assert_allclose(polar.azimuth_deg, [0.0, 90.0, 180.0, 270.0, 0.0])


WAVES = {2: (0.010, 30.0), 3: (0.004, 100.0), 5: (0.002, 10.0)}


def amplitudes(ring: Ring) -> NDArray[np.float64]:
    return np.array([h.amplitude_m for h in harmonics_of(ring)], dtype=float)


@pytest.mark.parametrize("sector_deg", [2.0, 5.0, 10.0])
def test_waves_are_found_with_their_amplitude_and_direction(sector_deg: float) -> None:
    found = harmonics_of(ring_of(ring_points(100_000, 0.002, WAVES), RADIUS_M, sector_deg))
    assert [h.order for h in found] == [2, 3, 4, 5, 6]
    for harmonic in found:
        amplitude_m, azimuth = WAVES.get(harmonic.order, (0.0, None))
        assert harmonic.amplitude_m == pytest.approx(amplitude_m, abs=1e-4)
        if azimuth is not None:
            assert harmonic.azimuth_deg == pytest.approx(azimuth, abs=1.0)


def test_a_centre_that_is_off_is_no_wave() -> None:
    points = ring_points(50_000, 0.001)
    off = Polar(points.azimuth_deg, points.radial_m + 0.02 * np.cos(np.radians(points.azimuth_deg)))
    assert np.nanmax(amplitudes(ring_of(off, RADIUS_M, 5.0))) < 2e-4


def test_the_stated_sigma_of_an_amplitude_is_its_scatter() -> None:
    found = [
        harmonics_of(ring_of(ring_points(3600, 0.003, {2: (0.01, 0.0)}, seed), RADIUS_M, 10.0))[0]
        for seed in range(200)
    ]
    scatter = np.std([h.amplitude_m for h in found if h.amplitude_m is not None])
    assert np.mean([h.sigma_m for h in found if h.sigma_m is not None]) == pytest.approx(scatter, rel=0.15)


@pytest.mark.parametrize(("gap_deg", "told"), [(30.0, 5), (60.0, 2), (90.0, 1), (200.0, 0)])
def test_waves_that_a_gap_hides_are_missing_and_not_0(gap_deg: float, told: int) -> None:
    points = without(ring_points(50_000, 0.001, WAVES), 100.0, 100.0 + gap_deg)
    found = amplitudes(ring_of(points, RADIUS_M, 5.0))
    assert np.isfinite(found[:told]).all()
    assert np.isnan(found[told:]).all()


def test_one_sector_has_no_range() -> None:
    ring = ring_of(Polar(np.full(4, 84.0), np.array([4.0, 4.1, 4.2, 4.0])), None, 10.0)
    assert ring.range_m is None
    assert all(h.amplitude_m is None for h in harmonics_of(ring))
