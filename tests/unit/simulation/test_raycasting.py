import sys

import numpy as np
import pytest

from storage.errors import ShapeError, TiltwatchError
from tasks.open3d_import import import_open3d
from tasks.simulation import Surface, build_scene
from tasks.simulation.mesh import House, Mesh, beams, house_mesh, merge, tube


def test_open3d_loads_whether_or_not_the_machine_has_libusb() -> None:
    assert hasattr(import_open3d().t.geometry, "RaycastingScene")


def test_missing_open3d_is_told_with_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "open3d", None)
    with pytest.raises(TiltwatchError, match=r"needs open3d.*requirements.lock.*libusb-package"):
        import_open3d()


def _square_at(north_m: float) -> Mesh:
    corners = [[-1.0, north_m, -1.0], [1.0, north_m, -1.0], [1.0, north_m, 1.0], [-1.0, north_m, 1.0]]
    return Mesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]]))


def test_ray_meets_the_nearer_of_two_surfaces() -> None:
    scene = build_scene([(Surface.BUILDING, _square_at(20.0)), (Surface.LADDER, _square_at(5.0))])
    hits = scene.cast(np.zeros(3), np.array([[0.0, 1.0, 0.0]]))
    assert hits.range_m[0] == pytest.approx(5.0, abs=1e-6)
    assert hits.surface[0] == Surface.LADDER


def test_ray_into_the_sky_has_no_range_and_no_surface() -> None:
    hits = build_scene([(Surface.GROUND, _square_at(5.0))]).cast(np.zeros(3), np.array([[0.0, 0.0, 1.0]]))
    assert np.isinf(hits.range_m[0])
    assert hits.surface[0] == -1


def test_directions_of_a_wrong_shape_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"directions \(n, 3\); got \(3,\) and \(4, 2\)"):
        build_scene([(Surface.GROUND, _square_at(5.0))]).cast(np.zeros(3), np.zeros((4, 2)))


def test_beam_has_its_length_and_width_whatever_its_direction() -> None:
    starts_m = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [0.0, 0.0, 0.0]])
    ends_m = np.array([[0.0, 0.0, 5.0], [4.0, 6.0, 3.0], [0.0, 5.0, 0.0]])
    corners_m = beams(starts_m, ends_m, 0.2).vertices_m.reshape(3, 8, 3)
    for start_m, end_m, box_m in zip(starts_m, ends_m, corners_m, strict=True):
        along = (end_m - start_m) / 5.0
        off_m = box_m - start_m
        assert np.unique(np.round(off_m @ along, 9)) == pytest.approx([0.0, 5.0])
        # the corners of a square of 0.2 m lie 0.1 * sqrt(2) from its middle
        across_m = np.linalg.norm(off_m - np.outer(off_m @ along, along), axis=1)
        assert across_m == pytest.approx(0.1 * np.sqrt(2.0))


def test_ridge_of_a_house_runs_along_its_azimuth() -> None:
    house = House(10.0, 20.0, 1.0, 16.0, 8.0, 5.0, 7.0, np.radians(90.0))
    vertices_m = house_mesh(house).vertices_m
    ridge_m = vertices_m[vertices_m[:, 2] == 8.0]
    assert np.ptp(ridge_m[:, 0]) == pytest.approx(16.0)
    assert np.ptp(ridge_m[:, 1]) == pytest.approx(0.0, abs=1e-12)


def test_no_ray_enters_a_house() -> None:
    scene = build_scene([(Surface.BUILDING, house_mesh(House(0.0, 0.0, 0.0, 16.0, 8.0, 5.0, 7.0, 0.4)))])
    rng = np.random.default_rng(3)
    directions = rng.normal(size=(500, 3))
    directions[:, 2] = np.abs(directions[:, 2])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # from within every upward direction must meet a wall, a gable or the roof
    assert np.isfinite(scene.cast(np.array([0.0, 0.0, 1.0]), directions).range_m).all()


def test_merging_keeps_every_triangle_where_it_was() -> None:
    first, second = _square_at(5.0), _square_at(9.0)
    both = merge([first, second])
    assert both.vertices_m[both.triangles[2:]] == pytest.approx(second.vertices_m[second.triangles])


def test_tube_of_a_single_ring_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"k >= 2 and n >= 3; got \(1, 8, 3\)"):
        tube(np.zeros((1, 8, 3)))
