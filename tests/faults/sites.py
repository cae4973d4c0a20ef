"""A campaign folder with its workspace: how the tests of faults spoil it, run it and look at it."""

import contextlib
import io
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import duckdb

from flows.cli import main
from flows.terminal import Terminal, use_terminal
from storage.records import EpochRow, SchemeRow, StationRow, TiltRow
from tests.flows.calls import Called
from tests.flows.campaigns import rows

FIRST, SECOND = EPOCHS = ("2025-01", "2025-04")


@dataclass(frozen=True)
class Site:
    """A folder with a campaign file and a workspace."""

    folder: Path

    @property
    def file(self) -> Path:
        return self.folder / "campaign.toml"

    @property
    def workspace(self) -> Path:
        return self.folder / "ws"

    def scan(self, station: str, epoch: str = SECOND) -> Path:
        return self.folder / epoch / f"{station}.laz"

    def text(self) -> str:
        return self.file.read_text(encoding="utf-8")

    def append(self, text: str) -> None:
        self.file.write_text(f"{self.text()}\n{text}\n", encoding="utf-8")

    def run(self, *words: object, workspace: Path | None = None) -> Called:
        """Call ``tiltwatch run`` in this process; no traceback may reach the screen."""
        out, err = io.StringIO(), io.StringIO()
        asked = ["run", self.file, "--workspace", workspace or self.workspace, *words]
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = main([str(word) for word in asked])
            finally:
                use_terminal(Terminal())
        assert "Traceback" not in out.getvalue() + err.getvalue()
        return Called(code, out.getvalue(), err.getvalue())

    def epoch(self, epoch: str) -> EpochRow:
        (row,) = rows(self.workspace, "epochs", epoch)
        return row

    def stations(self, epoch: str) -> dict[str, StationRow]:
        return {row.station: row for row in rows(self.workspace, "stations", epoch)}

    def schemes(self, epoch: str) -> dict[str, SchemeRow]:
        return {f"{row.scheme}/{row.method}": row for row in rows(self.workspace, "schemes", epoch)}

    def tilts(self, epoch: str) -> dict[str, TiltRow]:
        return {f"{row.scheme}/{row.method}": row for row in rows(self.workspace, "tilt", epoch)}

    def states(self) -> dict[str, str]:
        """State of every epoch, as the catalog tells everybody."""
        return dict(self.query("select epoch, state from epochs"))

    def query(self, sql: str, values: Sequence[object] = ()) -> list[tuple]:  # type: ignore[type-arg]
        with duckdb.connect(str(self.workspace / "catalog.duckdb"), read_only=True) as catalog:
            return catalog.execute(sql, list(values)).fetchall()


def state_of(called: Called, epoch: str) -> Mapping[str, object]:
    """What the JSON answer of a run says of an epoch."""
    (told,) = [told for told in called.answer["epochs"] if told["epoch"] == epoch]
    return told


def head_of(text: str) -> str:
    """A campaign file without its epochs."""
    return text[: text.index("[[epochs]]")]


def stations_of(text: str, epoch: str) -> Sequence[Mapping[str, object]]:
    """The station tables of an epoch."""
    (found,) = [table for table in tomllib.loads(text)["epochs"] if table["id"] == epoch]
    return found["stations"]


def epoch_text(epoch: str, month: int, tables: Iterable[Mapping[str, object]]) -> str:
    """An epoch of stations as a campaign file has it."""
    lines = [
        "[[epochs]]",
        f'id = "{epoch}"',
        f"time = {2026 + month // 12}-{1 + month % 12:02d}-01T06:00:00Z",
    ]
    for table in tables:
        lines.append("[[epochs.stations]]")
        lines += [
            f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}"
            for key, value in table.items()
        ]
    return "\n".join(lines) + "\n"
