"""The shapes that a map of the surface is measured from: the best-fit straight shaft, and the designed one."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.faces import normals_of, split_by_face
from tasks.preprocessing import ShaftModel
from tasks.whole_surface import RoundCut


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """Places (k, 3) on a shaft, and how the distance from it changes with a shift there (k, 3)."""

    points_m: NDArray[np.float64]
    outward: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StraightAxis:
    """A point (3,) of a straight axis, site frame, metres, and its lean vector (2,)."""

    point_m: NDArray[np.float64]
    lean: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DesignedShape:
    """The shape that a shaft was to have.

    ``radius_m`` (square tower: half the side) at rising heights ``z_m``, linear between; lean vector; where the axis is
    at z = 0 of the site frame, or None: then the designed axis meets the measured one at the foot of the shaft.
    """

    z_m: tuple[float, ...]
    radius_m: tuple[float, ...]
    lean: tuple[float, float]
    base_xy_m: tuple[float, float] | None


def straight_shaft(model: ShaftModel, axis: StraightAxis, shaft_z_m: tuple[float, float]) -> ShaftModel:
    """The rough model around the straight axis, its size going on to the ends of the shaft as between its last knots."""
    z_m = np.unique([*model.radius_z_m, *shaft_z_m])
    sizes = [_going_on(z_m, model.radius_z_m, size) for size in (model.radius_m, *_distances(model))]
    base = axis.point_m[:2] - axis.lean * axis.point_m[2]
    return _rebuilt(model, base, axis.lean, tuple(z_m.tolist()), sizes)


def designed_shaft(shaft: ShaftModel, design: DesignedShape, shaft_z_m: tuple[float, float]) -> ShaftModel:
    """The designed shape; faces look where those of the measured straight shaft do.

    Raises
    ------
    ShapeError
        If the design ends within the shaft.
    """
    if design.z_m[0] > shaft_z_m[0] or design.z_m[-1] < shaft_z_m[1]:
        raise ShapeError(
            f"a design needs radii from {shaft_z_m[0]:g} to {shaft_z_m[1]:g} m; "
            f"got {design.z_m[0]:g} to {design.z_m[-1]:g} m"
        )
    lean = np.array(design.lean)
    foot = shaft.straight_axis_at(shaft_z_m[0]) - lean * shaft_z_m[0]
    base = foot if design.base_xy_m is None else np.array(design.base_xy_m)
    return _rebuilt(shaft, base, lean, design.z_m, [design.radius_m] * (1 + len(shaft.faces)))


def _rebuilt(
    model: ShaftModel,
    base_m: NDArray[np.float64],
    lean: NDArray[np.float64],
    z_m: tuple[float, ...],
    sizes_m: list[tuple[float, ...]],
) -> ShaftModel:
    """The model with a straight axis, and with another radius and other distances of the faces at heights ``z_m``."""
    return replace(
        model,
        base_east_m=float(base_m[0]),
        base_north_m=float(base_m[1]),
        lean_east=float(lean[0]),
        lean_north=float(lean[1]),
        radius_z_m=z_m,
        radius_m=sizes_m[0],
        bend_east_m=(0.0,) * len(z_m),
        bend_north_m=(0.0,) * len(z_m),
        faces=tuple(
            replace(face, distance_m=size_m, sigma_m=None)
            for face, size_m in zip(model.faces, sizes_m[1:], strict=True)
        ),
    )


def _distances(model: ShaftModel) -> tuple[tuple[float, ...], ...]:
    return tuple(face.distance_m for face in model.faces)


def _going_on(
    z_m: NDArray[np.float64], knots_m: tuple[float, ...], sizes_m: tuple[float, ...]
) -> tuple[float, ...]:
    """Sizes at heights (k,), linear between knots and beyond them."""
    knots, sizes = np.array(knots_m), np.array(sizes_m)
    slopes = np.diff(sizes) / np.diff(knots)
    beyond = slopes[0] * np.minimum(z_m - knots[0], 0.0) + slopes[-1] * np.maximum(z_m - knots[-1], 0.0)
    return tuple((np.interp(z_m, knots, sizes) + beyond).tolist())


def distances_m(points_m: NDArray[np.float64], shaft: ShaftModel, sections: RoundCut) -> NDArray[np.float64]:
    """Distance (n,) of points (n, 3) from a straight shaft, positive outward, metres."""
    if not shaft.is_round:
        return shaft.off_surface_m(points_m)
    from tasks.map_kernel import off_round  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    off_m = np.empty(len(points_m))
    radii = (np.array(shaft.radius_z_m), np.array(shaft.radius_m))
    off_round(points_m, straight_line(shaft), *radii, sections == "perpendicular", off_m)
    return off_m


def straight_line(shaft: ShaftModel) -> tuple[float, float, float, float]:
    """East and north of the straight axis at z = 0, and its lean vector."""
    return shaft.base_east_m, shaft.base_north_m, shaft.lean_east, shaft.lean_north


def skin_of(z_m: NDArray[np.float64], azimuth_deg: NDArray[np.float64], shaft: ShaftModel) -> Skin:
    """Where the skin of a straight shaft is at heights (k,) and azimuths (k,), and which way it looks."""
    azimuth = np.radians(azimuth_deg)
    ray = np.column_stack([np.sin(azimuth), np.cos(azimuth)])
    radius_m = shaft.radius_at(z_m)
    flat = ray if shaft.is_round else _face_normals(radius_m[:, None] * ray, z_m, shaft)
    lean = np.array([shaft.lean_east, shaft.lean_north])
    outward = np.column_stack([flat, -shaft.taper_at(z_m) - flat @ lean])
    reach = radius_m / np.einsum("ki,ki->k", ray, flat)
    return Skin(np.column_stack([shaft.straight_axis_at(z_m) + reach[:, None] * ray, z_m]), outward)


def _face_normals(
    ray: NDArray[np.float64], z_m: NDArray[np.float64], shaft: ShaftModel
) -> NDArray[np.float64]:
    """Outward normals (k, 2) of the faces that lie in the directions (k, 2), which are about as long as the faces far."""
    turn = shaft.twist_rad_per_m * z_m
    azimuth = shaft.face_azimuths_rad(0.0)
    split = split_by_face(ray, azimuth, shaft.face_distances_at(z_m), turn)
    return normals_of(azimuth[split.face] + turn)
