"""The rows of stations."""

from tasks.epoch_tables import Home, ScanInput
from tasks.registration import InstrumentSigmas, registered_cloud
from tasks.station_rows import station_rows

POSE = (
    "position_east_m",
    "position_north_m",
    "position_up_m",
    "heading_deg",
    "level_east_deg",
    "level_north_deg",
)


def test_a_cloud_that_came_registered_has_no_scanner_anywhere_but_the_sigmas_that_were_stated() -> None:
    registration = registered_cloud("registered", InstrumentSigmas((0.015, 0.0225), 0.0026, 1.4e-5))
    (row,) = station_rows(Home("tower", "e1"), [ScanInput("registered", "ab", 5, None)], registration)
    assert [getattr(row, name) for name in POSE] == [None] * len(POSE)
    assert (row.heading_correction_deg, row.n_points, row.state) == (None, 5, "ok")
    assert row.sigma_level_deg is not None
    assert row.sigma_position_m is not None
