"""Straight faces around an upright axis: where points are among them, and the centre between them.

A face has the azimuth of its outward normal, clockwise from +y, and a distance from a reference point along it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class FaceSplit:
    """Points by face.

    Attributes
    ----------
    face : (n,) array
        Index of the face that is nearest to each point.
    off : (n,) array
        Signed distance from it, positive outside.
    along : (n,) array
        Place along the face from the foot of its normal, positive clockwise.
    margin : (n,) array
        How far the point is inside all other faces: small near a corner, negative beyond one.
    """

    face: NDArray[np.intp]
    off: NDArray[np.float64]
    along: NDArray[np.float64]
    margin: NDArray[np.float64]


def normals_of(azimuth_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Outward unit normals (..., 2) of faces with these azimuths (...)."""
    return np.stack([np.sin(azimuth_rad), np.cos(azimuth_rad)], axis=-1)


def tangents_of(azimuth_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (..., 2) along the faces, clockwise: the derivative of the normals by the azimuth."""
    return np.stack([np.cos(azimuth_rad), -np.sin(azimuth_rad)], axis=-1)


def split_by_face(
    xy: NDArray[np.float64],
    azimuth_rad: NDArray[np.float64],
    distance: NDArray[np.float64],
    turn_rad: NDArray[np.float64] | float = 0.0,
) -> FaceSplit:
    """Give every point to the face that it is farthest out of, or least inside of.

    Parameters
    ----------
    xy : (n, 2) array
        Points about the reference point.
    azimuth_rad : (m,) array
        Azimuths of the normals, m at least 2.
    distance : (m,) or (n, m) array
        Distances of the faces from the reference point.
    turn_rad : (n,) array or float
        By how much all faces are turned where each point is, clockwise.
    """
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    # turning the points back is the same as turning the faces, and cheaper
    x, y = c * xy[:, 0] - s * xy[:, 1], s * xy[:, 0] + c * xy[:, 1]
    turned = np.column_stack([x, y])
    off = turned @ normals_of(azimuth_rad).T - distance
    rows = np.arange(len(xy))
    face = np.argmax(off, axis=1)
    nearest = off[rows, face]
    off[rows, face] = -np.inf
    along = np.einsum("ij,ij->i", turned, tangents_of(azimuth_rad)[face])
    return FaceSplit(face, nearest, along, -off.max(axis=1))


def opposite_pairs(n_faces: int) -> NDArray[np.intp]:
    """Indices (n / 2, 2) of opposite faces, of an even number of faces in the order of their azimuths."""
    first = np.arange(n_faces // 2)
    return np.column_stack([first, first + n_faces // 2])


def centre_matrix(azimuth_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix (2, m) that makes the centre of the distances (m,) of an even number of faces.

    The centre lies on the mid-lines of opposite faces, where n_i c - d_i = n_j c - d_j; of more than two mid-lines it
    is nearest to all in the sense of least squares.
    """
    m = len(azimuth_rad)
    first, second = opposite_pairs(m).T
    normal = normals_of(azimuth_rad)
    differences = np.zeros((m // 2, m))
    differences[np.arange(m // 2), first] = 1.0
    differences[np.arange(m // 2), second] = -1.0
    return np.asarray(np.linalg.pinv(normal[first] - normal[second]) @ differences)


def corners_of(azimuth_rad: NDArray[np.float64], distance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners (m, 2) between each of m faces and the next one clockwise, about the reference point."""
    normal = normals_of(azimuth_rad)
    pairs = np.stack([normal, np.roll(normal, -1, axis=0)], axis=1)
    sides = np.stack([distance, np.roll(distance, -1)], axis=1)
    return np.asarray(np.linalg.solve(pairs, sides[..., None])[..., 0])
