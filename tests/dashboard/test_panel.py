"""Rows as CSV."""

from datetime import UTC, datetime

from dashboard.panel import Table


def test_numbers_keep_all_figures_and_what_does_not_exist_is_empty() -> None:
    table = Table(("a", "b", "c", "d"), [[1 / 3, None, True, datetime(2026, 1, 2, 3, tzinfo=UTC)]])
    assert table.as_csv() == "a,b,c,d\n0.3333333333333333,,true,2026-01-02T03:00:00Z\n"


def test_a_text_that_a_spreadsheet_would_compute_is_disarmed() -> None:
    assert Table(("a", "b"), [["=1+1", -2.5]]).as_csv() == "a,b\n'=1+1,-2.5\n"
