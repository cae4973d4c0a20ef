import time
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.simulation import (
    PERFECT_SCANNER,
    Fittings,
    Horizontal,
    Mesh,
    Scanner,
    Setup,
    ShaftShape,
    SimulatedScan,
    Surface,
    Window,
    axis_truth,
    build_scene,
    scan_windows,
    set_up_epoch,
    simulate_epoch,
    simulate_station,
    structure_meshes,
)
from tasks.simulation.scanner import shot_grid
from tests.unit.simulation.conftest import SmallCampaign

FACET_AND_FLOAT_M = 1e-4
"""2e-5 of chord, and single precision over 300 m (3e-5) in each of origin, direction and range."""

NO_FITTINGS = Fittings(platform_z_m=1e3, ladder_foot_m=1e3)


def _shaft_points(small: SmallCampaign) -> NDArray[np.float64]:
    return np.vstack(
        [s.setup.to_site(s.scan.points_m[s.scan.surface == Surface.SHAFT]) for s in small.perfect]
    )


def _off_round_m(points_m: NDArray[np.float64], shape: ShaftShape) -> NDArray[np.float64]:
    """Horizontal distance from the formula of a shaft with horizontal sections."""
    off_m = points_m[:, :2] - shape.axis_at(points_m[:, 2])
    azimuth_rad = np.arctan2(off_m[:, 0], off_m[:, 1])
    return np.asarray(np.hypot(*off_m.T) - shape.radius_at(points_m[:, 2]) * shape.roundness_at(azimuth_rad))


def _scan(small: SmallCampaign, scanner: Scanner, seed: int = 1, n: int = 5000) -> SimulatedScan:
    setup = small.perfect[0].setup
    windows = scan_windows(setup, small.shape)
    return simulate_station(small.scene, setup, windows, scanner, n, np.random.default_rng(seed))


def test_points_without_noise_lie_on_the_round_shaft(small: SmallCampaign) -> None:
    assert np.abs(_off_round_m(_shaft_points(small), small.shape)).max() < FACET_AND_FLOAT_M


def test_points_without_noise_lie_on_a_bent_oval_bowed_shaft(small: SmallCampaign) -> None:
    shape = ShaftShape(
        base_m=Horizontal(1.5, -0.7),
        bend_top_m=Horizontal(0.2, 0.1),
        bend_form="cantilever",
        ovality=0.01,
        taper_bow_m=0.15,
    )
    scene, setup = build_scene(structure_meshes(shape, NO_FITTINGS)), small.perfect[1].setup
    scan = simulate_station(
        scene, setup, scan_windows(setup, shape), PERFECT_SCANNER, 8000, np.random.default_rng(2)
    )
    points_m = setup.to_site(scan.points_m[scan.surface == Surface.SHAFT])
    assert len(points_m) > 4000
    assert np.abs(_off_round_m(points_m, shape)).max() < FACET_AND_FLOAT_M


def test_points_of_perpendicular_sections_lie_on_a_cone_about_the_leaning_axis(small: SmallCampaign) -> None:
    shape = ShaftShape(sections="perpendicular", lean=Horizontal(0.05, -0.03))
    scene, setup = build_scene(structure_meshes(shape, NO_FITTINGS)), small.perfect[2].setup
    scan = simulate_station(
        scene, setup, scan_windows(setup, shape), PERFECT_SCANNER, 8000, np.random.default_rng(2)
    )
    points_m = setup.to_site(scan.points_m[scan.surface == Surface.SHAFT])
    stretch = np.sqrt(1.0 + 0.05**2 + 0.03**2)
    along_m = points_m @ np.array([0.05, -0.03, 1.0]) / stretch
    from_axis_m = np.sqrt(np.sum(points_m**2, axis=1) - along_m**2)
    assert np.abs(from_axis_m - shape.radius_at(along_m / stretch)).max() < FACET_AND_FLOAT_M


def test_circle_through_a_slice_without_noise_has_the_true_axis_as_its_centre(small: SmallCampaign) -> None:
    points_m = _shaft_points(small)
    for z_m in (10.0, 55.0, 100.0):
        slab_m = points_m[np.abs(points_m[:, 2] - z_m) < 0.1]
        # straighten lean and taper within the slab, then Kasa's linear circle
        up_m = slab_m[:, 2] - z_m
        x_m, y_m = (slab_m[:, :2] - up_m[:, None] * small.shape.lean.as_array()).T
        design = np.column_stack([x_m, y_m, np.ones(len(x_m)), up_m])
        found = np.linalg.lstsq(design, x_m**2 + y_m**2, rcond=None)[0]
        assert len(slab_m) > 100
        assert 0.5 * found[:2] == pytest.approx(small.shape.axis_at(np.array(z_m)), abs=5e-5)


def test_line_through_slices_without_noise_leans_as_the_truth_says(small: SmallCampaign) -> None:
    points_m = _shaft_points(small)
    points_m = points_m[(points_m[:, 2] > 2.0) & (points_m[:, 2] < 102.01)]
    # one linear system for axis and taper: radius from the known profile, centre and lean unknown
    z_m, radius_m = points_m[:, 2], small.shape.radius_at(points_m[:, 2])
    off_m = points_m[:, :2] - small.shape.axis_at(z_m)
    out = off_m / np.linalg.norm(off_m, axis=1, keepdims=True)
    rest_m = np.linalg.norm(off_m, axis=1) - radius_m
    design = np.column_stack([out, out * (z_m - 50.0)[:, None], np.ones(len(z_m))])
    found = np.linalg.lstsq(design, rest_m, rcond=None)[0]
    truth = axis_truth(small.shape, 2.0, 102.01)
    lean = small.shape.lean.as_array() + found[2:4]
    # 0.05 arc seconds: what the facets and single precision leave
    assert lean == pytest.approx(truth.lean.as_array(), abs=0.05 / 206264.8)


def test_bearing_of_the_shaft_is_its_azimuth_in_the_scan_plus_the_heading(small: SmallCampaign) -> None:
    for station in small.perfect:
        shaft_m = station.scan.points_m[station.scan.surface == Surface.SHAFT].mean(axis=0)
        seen_rad = np.arctan2(shaft_m[0], shaft_m[1]) + station.setup.heading_rad
        bearing_rad = np.arctan2(-station.setup.position_m[0], -station.setup.position_m[1])
        # the lean moves the middle of the shaft by 0.4 m, at 200 m or more
        assert np.sin(seen_rad - bearing_rad) == pytest.approx(0.0, abs=4e-3)


def test_level_error_is_in_the_points_and_turns_them_about_the_scanner(small: SmallCampaign) -> None:
    tilted = replace(small.perfect[0].setup, level_east_rad=1e-3, level_north_rad=-5e-4)
    windows = scan_windows(tilted, small.shape)
    scan = simulate_station(small.scene, tilted, windows, PERFECT_SCANNER, 4000, np.random.default_rng(3))
    shaft_m = scan.points_m[scan.surface == Surface.SHAFT]
    true_m = tilted.to_site(shaft_m)
    believed_m = replace(tilted, level_east_rad=0.0, level_north_rad=0.0).to_site(shaft_m)
    expected_m = -np.cross([1e-3, -5e-4, 0.0], true_m - tilted.position_m)
    # second order of a turn of 1.1 mrad over 320 m: 0.2 mm
    assert believed_m - true_m == pytest.approx(expected_m, abs=3e-4)
    assert np.abs(_off_round_m(true_m, small.shape)).max() < FACET_AND_FLOAT_M


def test_stated_range_sigma_matches_the_scatter(small: SmallCampaign) -> None:
    scanner = replace(PERFECT_SCANNER, range_sigma_m=0.005)
    clean, noisy = _scan(small, PERFECT_SCANNER), _scan(small, scanner)
    range_m = np.linalg.norm(clean.points_m, axis=1)
    normed = (np.linalg.norm(noisy.points_m, axis=1) - range_m) / scanner.range_sigma_at(range_m)
    # a standard deviation of 5000 draws scatters by 1 %: four of those
    assert normed.std() == pytest.approx(1.0, rel=0.04)


def test_stated_angle_sigma_matches_the_scatter(small: SmallCampaign) -> None:
    scanner = replace(PERFECT_SCANNER, angle_sigma_deg=0.01)
    clean, noisy = _scan(small, PERFECT_SCANNER).points_m, _scan(small, scanner).points_m
    azimuth_rad = np.arctan2(noisy[:, 0], noisy[:, 1]) - np.arctan2(clean[:, 0], clean[:, 1])
    elevation_rad = np.arctan2(noisy[:, 2], np.hypot(*noisy[:, :2].T)) - np.arctan2(
        clean[:, 2], np.hypot(*clean[:, :2].T)
    )
    assert np.degrees(np.sin(azimuth_rad)).std() == pytest.approx(0.01, rel=0.04)
    assert np.degrees(elevation_rad).std() == pytest.approx(0.01, rel=0.04)


def test_same_seed_gives_the_same_points_and_another_seed_does_not(small: SmallCampaign) -> None:
    first, again, other = (_scan(small, Scanner(), seed) for seed in (1, 1, 2))
    assert first.points_m.tobytes() == again.points_m.tobytes()
    assert first.points_m.tobytes() != other.points_m.tobytes()


@pytest.mark.parametrize(("n", "within"), [(1000, 0.10), (5000, 0.05), (40_000, 0.03)])
def test_number_of_points_comes_out_near_what_is_asked_for(
    small: SmallCampaign, n: int, within: float
) -> None:
    # fewer points make a coarser grid, whose columns either meet the shaft's edge or do not
    assert len(_scan(small, Scanner(), n=n).points_m) == pytest.approx(n, rel=within)


def test_more_than_half_of_the_points_are_on_the_structure(small: SmallCampaign) -> None:
    for station in small.perfect:
        assert np.mean(station.scan.surface <= Surface.LADDER) > 0.5


def test_every_station_sees_the_whole_sliced_part_of_the_shaft(small: SmallCampaign) -> None:
    for station in small.perfect:
        z_m = station.setup.to_site(station.scan.points_m[station.scan.surface == Surface.SHAFT])[:, 2]
        assert np.histogram(z_m, np.arange(2.0, 103.0, 1.0))[0].min() > 20


def test_every_station_sees_buildings_to_register_by(small: SmallCampaign) -> None:
    assert min(np.sum(s.scan.surface == Surface.BUILDING) for s in small.perfect) > 500


def test_platform_is_above_the_sliced_part_and_the_ladder_near_the_shaft(small: SmallCampaign) -> None:
    for station in small.perfect:
        points_m = station.setup.to_site(station.scan.points_m)
        platform = station.scan.surface == Surface.PLATFORM
        ladder = station.scan.surface == Surface.LADDER
        assert points_m[platform, 2].min() > 102.09
        assert points_m[platform, 2].max() < 103.5
        off_m = _off_round_m(points_m[ladder], small.shape)
        assert (off_m > 0.1).all()
        assert (off_m < 0.35).all()


def test_mixed_and_stray_points_are_few_but_there(small: SmallCampaign) -> None:
    scan = _scan(small, Scanner(), n=40_000)
    assert 0.0005 < np.mean(scan.surface == Surface.MIXED) < 0.03
    # a share of the shots, about half of which go into the sky
    assert 0.0003 < np.mean(scan.surface == Surface.STRAY) < 0.003


def test_perfect_scanner_has_neither_mixed_nor_stray_points(small: SmallCampaign) -> None:
    for station in small.perfect:
        assert station.scan.surface.max() < Surface.MIXED


def test_mixed_points_have_a_range_between_the_two_surfaces() -> None:
    def wall(east_m: float, north_m: float) -> Mesh:
        corners = [[east_m + i, north_m, k] for i, k in ((0, -9), (30, -9), (30, 9), (0, 9))]
        return Mesh(np.array(corners, float), np.array([[0, 1, 2], [0, 2, 3]]))

    scene = build_scene([(Surface.BUILDING, wall(-30.0, 50.0)), (Surface.SHAFT, wall(0.0, 60.0))])
    setup = Setup("ST01", np.zeros(3), 0.0, 0.0, 0.0, np.zeros(3), 0.0)
    always = replace(PERFECT_SCANNER, mixed_probability=1.0)
    window = Window(0.0, 0.2, -0.1, 0.1, 1.0)
    scan = simulate_station(scene, setup, [window], always, 2000, np.random.default_rng(1))
    north_m = scan.points_m[scan.surface == Surface.MIXED, 1]
    assert len(north_m) > 10
    assert (north_m > 49.9).all()
    assert (north_m < 60.1).all()
    assert np.mean((north_m > 51.0) & (north_m < 59.0)) > 0.5


def test_thin_level_slice_meets_its_share_of_the_columns() -> None:
    # a band of an eighth of the step: a locked mirror would give it all columns or none
    grid = shot_grid(Window(0.0, 0.02, 0.0, 0.4, 1.0), 100_000, 0.37)
    step_rad = grid.elevation_rad[0, 1] - grid.elevation_rad[0, 0]
    columns = len(grid.elevation_rad)
    for low_rad in np.linspace(0.01, 0.39, 40):
        inside = (grid.elevation_rad >= low_rad) & (grid.elevation_rad < low_rad + step_rad / 8.0)
        assert inside.sum() == pytest.approx(columns / 8.0, abs=3)


def test_station_set_up_again_stands_some_metres_off(small: SmallCampaign) -> None:
    again = set_up_epoch(small.site, small.places_m, Scanner(), np.random.default_rng(77))
    off_m = [
        np.hypot(*(s.position_m - p.setup.position_m)[:2]) for s, p in zip(again, small.perfect, strict=True)
    ]
    assert 0.1 < min(off_m) <= max(off_m) < 12.0


def test_no_points_are_refused(small: SmallCampaign) -> None:
    with pytest.raises(ShapeError, match="n_points >= 1 and windows with shares; got 0"):
        _scan(small, Scanner(), n=0)


def test_scan_of_a_few_thousand_points_takes_well_under_a_second(small: SmallCampaign) -> None:
    start = time.process_time()
    _scan(small, Scanner(), n=3000)
    assert time.process_time() - start < 0.5


@pytest.mark.slow
def test_epoch_of_eight_stations_of_200_000_points_takes_under_five_seconds(small: SmallCampaign) -> None:
    rng = np.random.default_rng(1)
    start = time.perf_counter()
    setups = set_up_epoch(small.site, np.vstack([small.places_m, small.places_m[:2]]), Scanner(), rng)
    scans = list(simulate_epoch(small.scene, small.shape, setups, Scanner(), 200_000, rng))
    assert len(scans) == 8
    assert time.perf_counter() - start < 5.0
