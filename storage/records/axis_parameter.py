"""What an axis and its radius are made of, as numbers that have a joint covariance."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class AxisParameterRow:
    """A number that says where the axis of an epoch is, how it bends, or how wide the shaft is.

    ``base_east``, ``base_north``: the straight axis at z = 0 of the site frame. ``lean_east``, ``lean_north``: the lean
    vector. ``bend_east``, ``bend_north``: the coefficient of the second Legendre polynomial over the shaft, which is two
    thirds of the sagitta. ``s_bend_east``, ``s_bend_north``: that of the third one, a bend in the shape of an S.
    ``radius_0``, ``radius_1``, ...: coefficients of the Legendre polynomials of the mean radius over the part of the
    shaft that is cut or fitted.
    """

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    parameter: Annotated[
        str, Column("base_, lean_, bend_ and s_bend_ with east and north behind; radius_0, radius_1, ...")
    ]
    place: Annotated[
        int, Column("number of the parameter, from 0: the order of its rows and columns in the covariance")
    ]
    value: Annotated[float, Column("value of the parameter: metres, of the lean metres a metre")]
    sigma: Annotated[float, Column("standard deviation of the value, in its unit")]


@dataclass(frozen=True, slots=True)
class AxisCovarianceRow:
    """The covariance of two parameters of an axis."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    place_1: Annotated[int, Column("place of the one parameter")]
    place_2: Annotated[int, Column("place of the other parameter, not below the first")]
    covariance: Annotated[float, Column("their covariance, in the product of their units")]
    form_covariance: Annotated[
        float, Column("the part of it that the form of the wall causes, which stays from epoch to epoch")
    ]
    frame_covariance: Annotated[
        float,
        Column(
            "the part of it that stable surroundings bring along from the reference epoch, 0 without them"
        ),
    ]
