"""A reader who opens the catalog with plain DuckDB again and again, and minds that what is shown is whole and only grows.

`python -m tests.faults.crowding.reader CATALOG FILE.json STOP` reads until the file STOP is there.
"""

import json
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import duckdb

NOT_WHOLE: Final = {
    "epochs twice": "SELECT epoch, count(*) FROM epochs GROUP BY ALL HAVING count(*) > 1",
    "slices that are not as many as their scheme says": """
        SELECT epoch, scheme, method, n_slices, count(slice_index) FROM schemes LEFT JOIN slices
        USING (structure, epoch, scheme, method) GROUP BY ALL HAVING n_slices <> count(slice_index)""",
    "axes that are not one a scheme that is ok": """
        SELECT epoch, scheme, method, schemes.state, count(tilt.method) FROM schemes LEFT JOIN tilt
        USING (structure, epoch, scheme, method) GROUP BY ALL
        HAVING count(tilt.method) <> CASE schemes.state WHEN 'ok' THEN 1 ELSE 0 END""",
    "stations that are not as many as their epoch says": """
        SELECT epoch, n_stations, count(station) FROM epochs LEFT JOIN stations USING (structure, epoch)
        GROUP BY ALL HAVING n_stations <> count(station)""",
    "rows of epochs that are not there": """
        SELECT DISTINCT epoch FROM (SELECT epoch FROM slices UNION ALL SELECT epoch FROM tilt UNION ALL
        SELECT epoch FROM stations UNION ALL SELECT epoch FROM coverage) ANTI JOIN epochs USING (epoch)""",
    "stages twice": "SELECT run, epoch, stage, count(*) FROM runs GROUP BY ALL HAVING count(*) > 1",
    "events twice": "SELECT event FROM alarm_events GROUP BY ALL HAVING count(*) > 1",
    "alarms raised twice": """
        SELECT alarm, count(*) FROM alarm_events WHERE action = 'raised' GROUP BY ALL HAVING count(*) > 1""",
}
"""Queries that must give no row."""

NEVER_LESS: Final = {
    "epochs": "SELECT epoch FROM epochs",
    "versions": "SELECT epoch, version FROM versions",
    "runs": "SELECT DISTINCT run FROM runs",
    "alarm events": "SELECT event FROM alarm_events",
}


@dataclass
class Reader:
    """What was seen so far."""

    seen: dict[str, set[tuple[Any, ...]]] = field(
        default_factory=lambda: {name: set() for name in NEVER_LESS}
    )
    shown: dict[str, list[str]] = field(default_factory=dict)
    """Epoch to the runs that published what was shown of it, in the order in which they were seen."""
    readings: int = 0
    findings: list[str] = field(default_factory=list)

    def read(self, catalog: Path) -> None:
        """Look at one catalog."""
        self.readings += 1
        try:
            with duckdb.connect(str(catalog), read_only=True) as connection:
                self._look(connection)
        except duckdb.Error as fault:
            self.findings.append(f"reading {self.readings}: {type(fault).__name__}: {fault}")

    def _look(self, connection: duckdb.DuckDBPyConnection) -> None:
        for what, sql in NOT_WHOLE.items():
            rows = connection.execute(sql).fetchall()
            if rows:
                self.findings.append(f"reading {self.readings}: {what}: {rows[:5]}")
        for what, sql in NEVER_LESS.items():
            now = set(connection.execute(sql).fetchall())
            if self.seen[what] - now:
                self.findings.append(
                    f"reading {self.readings}: {what} gone: {sorted(self.seen[what] - now)[:5]}"
                )
            self.seen[what] |= now
        for epoch, run in connection.execute("SELECT epoch, run FROM epochs").fetchall():
            before = self.shown.setdefault(epoch, [])
            if run in before[:-1]:
                self.findings.append(f"reading {self.readings}: {epoch} goes back from {before[-1]} to {run}")
            if not before or before[-1] != run:
                before.append(run)


def main() -> None:
    """Read until told to stop, and write what was seen."""
    catalog, out, stop = (Path(word) for word in sys.argv[1:])
    reader = Reader()
    while not stop.exists():
        reader.read(catalog)
        time.sleep(0.1)
    reader.read(catalog)
    content = {"readings": reader.readings, "findings": reader.findings, "shown": reader.shown}
    out.write_text(json.dumps(content, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
