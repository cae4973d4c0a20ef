"""Walls and what is attached to them: the mesh is what the shape and the wall say, and the truth is its axis."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError, ShapeError
from tasks.simulation import (
    Bumps,
    Horizontal,
    Mesh,
    ShaftShape,
    SimulatedCampaignRequest,
    Wall,
    attachment_meshes,
    build_site,
    draw_station_places,
    wall_mesh,
)
from tasks.simulation.kinds import CASES, request_of_kind

SHAPE = ShaftShape(height_m=20.0, radius_foot_m=2.0, radius_top_m=1.5, lean=Horizontal(0.02, -0.01))


def distances_m(mesh: Mesh, shape: ShaftShape) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Heights (n,) of the vertices and their distances (n,) from the axis."""
    z_m = mesh.vertices_m[:, 2]
    return z_m, np.hypot(*(mesh.vertices_m[:, :2] - shape.axis_at(z_m)).T)


def test_a_plain_wall_is_the_shape() -> None:
    z_m, off_m = distances_m(wall_mesh(SHAPE, Wall()), SHAPE)
    assert off_m == pytest.approx(SHAPE.radius_at(z_m), abs=1e-12)


def test_a_step_stands_in_the_wall_at_its_height() -> None:
    wall = Wall(profile_m=((10.0, 0.0), (10.0, -0.3)))
    z_m, off_m = distances_m(wall_mesh(SHAPE, wall), SHAPE)
    added_m = off_m - SHAPE.radius_at(z_m)
    assert added_m[z_m < 10.0] == pytest.approx(0.0, abs=1e-12)
    assert added_m[z_m > 10.0] == pytest.approx(-0.3, abs=1e-12)
    at_step = np.unique(np.round(added_m[z_m == 10.0], 9))
    assert at_step.tolist() == [-0.3, 0.0]


def test_plane_faces_are_plane_and_look_where_they_should() -> None:
    shape = ShaftShape(height_m=20.0, radius_foot_m=3.0, radius_top_m=3.0, lean=Horizontal(0.0, 0.0))
    mesh = wall_mesh(shape, Wall(faces=4, face_azimuth_deg=25.0))
    azimuth = np.radians(25.0 + 90.0 * np.arange(4))
    normals = np.column_stack([np.sin(azimuth), np.cos(azimuth)])
    # every vertex is on the plane of one face, and behind those of the others
    assert (mesh.vertices_m[:, :2] @ normals.T).max(axis=1) == pytest.approx(3.0, abs=1e-9)


def test_bumps_have_their_size_and_stay_from_epoch_to_epoch() -> None:
    wall = Wall(bumps=Bumps(sigma_m=0.004, tall_m=0.5, wide_m=0.5), ring_step_m=0.1)
    z_m, off_m = distances_m(wall_mesh(SHAPE, wall), SHAPE)
    rough_m = off_m - SHAPE.radius_at(z_m)
    # between the grid's nodes a bump is the mean of its neighbours: two thirds of the variance a direction
    assert np.std(rough_m) == pytest.approx(0.004 * 2.0 / 3.0, rel=0.1)
    leaned = ShaftShape(height_m=20.0, radius_foot_m=2.0, radius_top_m=1.5, lean=Horizontal(0.03, 0.0))
    again = distances_m(wall_mesh(leaned, wall), leaned)[1] - leaned.radius_at(z_m)
    assert again == pytest.approx(rough_m, abs=1e-12)


@pytest.mark.parametrize(
    "wrong", [{"faces": 5}, {"profile_m": ((5.0, 0.0), (2.0, 0.1))}, {"ring_step_m": 0.0}]
)
def test_a_wall_that_cannot_be_built_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ShapeError, match="rising heights, 0 or 4 faces"):
        Wall(**wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", sorted(CASES))
def test_nothing_attached_reaches_into_the_part_of_the_wall_that_is_sliced(kind: str) -> None:
    request = request_of_kind(kind)
    if request.attachments is None:
        return
    low_m, high_m = request.shaft_z_m
    for _, mesh in attachment_meshes(request.shape, request.fittings, request.attachments):
        points_m = mesh.vertices_m
        inside = (points_m[:, 2] > low_m) & (points_m[:, 2] < high_m)
        off_m = np.hypot(*(points_m[inside, :2] - request.shape.axis_at(points_m[inside, 2])).T)
        # floors of platforms end in the wall; nothing else comes nearer than the axis of a branch
        assert (off_m > 0.25 * request.shape.radius_at(points_m[inside, 2])).all()


def test_the_default_request_is_the_chimney_of_the_kinds() -> None:
    assert request_of_kind("chimney") == SimulatedCampaignRequest()


def test_another_seed_is_another_wall_and_another_epoch_is_not() -> None:
    one, other = (request_of_kind("stem", seed=seed).wall for seed in (1, 2))
    assert one is not None
    assert one != other
    assert one == request_of_kind("stem", epochs=9, seed=1).wall


def test_unknown_kind_is_answered_with_the_known_ones() -> None:
    with pytest.raises(InputError, match="unknown kind of structure 'pagoda'; known: chimney, column, mast"):
        request_of_kind("pagoda")


def test_surroundings_keep_off_a_wide_structure() -> None:
    request = request_of_kind("tank")
    rng = np.random.default_rng(3)
    places_m = draw_station_places(4, rng, request.layout)
    site = build_site(places_m, rng, request.surroundings)
    for surface, mesh in site.meshes[1:]:
        assert np.hypot(*mesh.vertices_m[:, :2].T).min() > request.shape.radius_foot_m + 5.0, surface
