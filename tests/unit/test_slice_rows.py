"""What a slice says beside its contour: the local change of the radius."""

import numpy as np
import pytest

from storage.records import SectionFit
from tasks.epoch_tables import Home, SchemeOutcome, slice_rows
from tasks.methods import methods_of
from tasks.slicing import SCHEMES
from tests.storage.samples import bare_row


def outcome(z_m: list[float], radius_m: list[float | None]) -> SchemeOutcome:
    blank = bare_row(SectionFit)
    rows = tuple(
        SectionFit(
            **{
                **{name: getattr(blank, name) for name in SectionFit.__dataclass_fields__},
                "slice_index": i,
                "z_m": z,
                "radius_m": r,
                "state": "ok" if r is not None else "failed",
            }
        )
        for i, (z, r) in enumerate(zip(z_m, radius_m, strict=True))
    )
    scheme = SCHEMES["B"]
    return SchemeOutcome(scheme, methods_of(scheme)[0], rows, None, "no axis")


def offsets(z_m: list[float], radius_m: list[float | None]) -> list[float | None]:
    return [row.radius_offset_m for row in slice_rows(Home("x", "e1"), outcome(z_m, radius_m))]


def test_a_cone_has_no_radius_offset() -> None:
    assert offsets([2.0, 7.0, 20.0, 50.0], [4.6, 4.5, 4.24, 3.64]) == pytest.approx([0.0] * 4, abs=1e-12)


def test_a_wider_slice_stands_out_of_the_line_of_the_radii() -> None:
    z_m = [float(z) for z in range(0, 101, 5)]
    radius_m = [4.6 - 0.019 * z + (0.021 if z == 50.0 else 0.0) for z in z_m]
    found = offsets(z_m, radius_m)
    # the line is raised by a 21st of it
    assert found[10] == pytest.approx(0.020, abs=1e-12)
    assert np.delete(np.array(found, dtype=float), 10) == pytest.approx(-0.001, abs=1e-12)


def test_a_slice_without_a_radius_has_no_offset_and_does_not_count() -> None:
    assert offsets([0.0, 1.0, 2.0, 3.0], [4.0, None, 3.8, 3.7]) == [
        pytest.approx(0.0, abs=1e-12),
        None,
        pytest.approx(0.0, abs=1e-12),
        pytest.approx(0.0, abs=1e-12),
    ]


def test_two_radii_make_no_line_that_a_third_is_off() -> None:
    assert offsets([0.0, 1.0, 2.0], [4.0, None, 3.8]) == [None, None, None]
