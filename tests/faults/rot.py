"""Bit rot, each kind of file times each damage: ``python -m tests.faults.rot --out FILE.json``.

Each case works on a copy of one workspace: a file is damaged, `verify` and `verify --deep` are asked, a run follows, and
what it leaves is held against what was there before, table by table and row by row. What a run leaves as it is, because it
trusts a date that did not change, is deleted as `verify` says, and a second run follows.
"""

import argparse
import json
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import duckdb

from flows.kept_server import ServerSearch
from storage.catalog import rebuild_catalog
from storage.errors import StorageError
from storage.verify import verify_workspace, verify_workspace_deeply
from storage.workspace import Workspace, existing_workspace
from tests.faults.damages import DAMAGES
from tests.faults.full_site import command, fill_up, kept_files, runs_in_ledger, shown
from tests.faults.kinds import KINDS, Kind, files_of_kind
from tests.faults.sites import Site
from tests.flows.campaigns import small_campaign


@dataclass(frozen=True)
class Case:
    """One kind of file and one damage, who found it, and how it ended."""

    kind: str
    damage: str
    file: str
    found_by: str
    ended: str
    exit_code: int
    told: str
    deleted: tuple[str, ...] = ()

    @property
    def is_well(self) -> bool:
        """Found or harmless, and healed or said."""
        harmless = next(kind.harmless for kind in KINDS if kind.name == self.kind)
        return self.ended != "unnoticed" and bool(harmless or self.found_by) and self.exit_code in (0, 3)


def sound_site(folder: Path) -> Site:
    """A workspace with every kind of file, processed here."""
    site = Site(folder)
    folder.mkdir(parents=True)
    small_campaign(folder, epochs=2, stations=5)
    assert command(site, "run").code == 0
    fill_up(site)
    return site


def copy_of(site: Site, folder: Path) -> Site:
    """A copy whose catalog knows its files."""
    shutil.copytree(site.folder, folder, symlinks=True)
    rebuild_catalog(Workspace(folder / "ws"))
    return Site(folder)


def sample(site: Site, kind: Kind) -> tuple[str, Path | None]:
    """The last file of a kind, and another one that differs where there is one."""
    names = files_of_kind(site.workspace, kind)
    path = site.workspace / names[-1]
    others = [site.workspace / name for name in names[:-1]]
    return names[-1], next((other for other in others if other.read_bytes() != path.read_bytes()), None)


def run_case(
    sound: Site, folder: Path, kind: Kind, damage: str, server: Mapping[str, str] | None = None
) -> Case | None:
    """Damage a file of a kind in a copy and follow what becomes of it; None where there is no other file to exchange.

    With a ``server`` that is up the runs start none of their own, which takes longer than the run.
    """
    site = copy_of(sound, folder)
    name, other = sample(site, kind)
    if damage == "exchanged" and other is None:
        return None
    runs = runs_in_ledger(site.workspace)
    before = shown(site.workspace, runs), kept_files(site.workspace)
    if kind.harmless:  # nothing rests on it, so nobody need make it again
        before[1].pop(name, None)
    DAMAGES[damage](site.workspace / name, other)
    found_by = _found_by(site)
    called = command(site, "run", server=server)
    told = _told(called.err, name)
    if called.code == 3 and told:
        return Case(kind.name, damage, name, found_by, "said by the run", called.code, told)
    if _is_as_before(site, runs, before):
        ended = "harmless" if kind.harmless else "healed by the run"
        return Case(kind.name, damage, name, found_by, ended, called.code, told)
    deleted = _delete_faulty(site)
    called = command(site, "run", server=server)
    ended = "healed after deleting as verify says" if _is_as_before(site, runs, before) else "unnoticed"
    return Case(kind.name, damage, name, found_by, ended, called.code, _told(called.err, name), deleted)


def look_at_case(site: Site, aside: Path, kind: Kind, damage: str) -> Case | None:
    """Damage a file of a kind, ask verify only, and put the file back: nothing runs, and nothing is copied."""
    name, other = sample(site, kind)
    if damage == "exchanged" and other is None:
        return None
    path = site.workspace / name
    path.rename(aside)
    shutil.copy2(aside, path)
    DAMAGES[damage](path, other)
    found_by = _found_by(site)
    if path.is_dir():
        path.rmdir()
    path.unlink(missing_ok=True)
    aside.rename(path)
    return Case(kind.name, damage, name, found_by, "looked at only", 0, "")


def looks(sound: Site, folder: Path, kinds: list[str], damages: list[str]) -> Iterator[Case]:
    """All cases of one copy, whose file is put back behind each of them."""
    site = copy_of(sound, folder / "look")
    for kind in KINDS:
        if (kinds and kind.name not in kinds) or not files_of_kind(site.workspace, kind):
            continue
        for damage in damages or DAMAGES:
            case = look_at_case(site, folder / "aside", kind, damage)
            if case is not None:
                yield case


def _found_by(site: Site) -> str:
    """Which form of verify finds something."""
    notes = ""
    for form, verified in (("verify", verify_workspace), ("verify --deep", verify_workspace_deeply)):
        try:
            report = verified(existing_workspace(site.workspace))
        except StorageError:  # the command line tells it, with exit code 3
            return form
        if report.faults:
            return form
        notes = "note" if report.notes else ""
    return notes


def _is_as_before(site: Site, runs: frozenset[str], before: tuple[object, dict[str, str]]) -> bool:
    try:
        rebuild_catalog(Workspace(site.workspace))
        after, files = shown(site.workspace, runs), kept_files(site.workspace)
        report = verify_workspace_deeply(Workspace(site.workspace))
    except (StorageError, OSError, duckdb.Error):
        return False
    same_files = all(files.get(name) == digest for name, digest in before[1].items())
    return after == before[0] and same_files and not report.faults


def _delete_faulty(site: Site) -> tuple[str, ...]:
    """Delete what verify names and says may be deleted."""
    gone = []
    for fault in verify_workspace_deeply(Workspace(site.workspace)).faults:
        path = site.workspace / fault.where
        if "delete" in fault.what_to_do and path.is_file():
            path.unlink()
            gone.append(fault.where)
    return tuple(gone)


def _told(err: str, name: str) -> str:
    lines = [
        line
        for line in err.splitlines()
        if line.startswith(("error:", "warning:")) and Path(name).stem in line
    ]
    return lines[0][:300] if lines else ""


def cases(sound: Site, folder: Path, kinds: list[str], damages: list[str]) -> Iterator[Case]:
    """All cases that there are, one after the other; each in a folder that is removed behind it."""
    with shared_server(folder / "engine") as server:
        for kind in KINDS:
            if (kinds and kind.name not in kinds) or not files_of_kind(sound.workspace, kind):
                continue
            own = kind.name in OWN_SERVER
            for damage in damages or DAMAGES:
                case = run_case(sound, folder / "case", kind, damage, None if own else server)
                shutil.rmtree(folder / "case")
                if case is not None:
                    yield case


@contextmanager
def shared_server(folder: Path) -> Iterator[Mapping[str, str]]:
    """Keep one workflow server for many runs; gives what tells them of it."""
    lease = ServerSearch(folder, 0.0).wait()
    try:
        yield {"PREFECT_API_URL": lease.record.url, "PREFECT_API_AUTH_STRING": lease.record.secret}
    finally:
        lease.connection.close()  # it then ends by itself


OWN_SERVER: Final = ("history of flow runs", "workflow server")
"""What only the workspace's own server reads."""


def main() -> int:
    """Run the matrix, print a line a case, and write all of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument(
        "--site", type=Path, help="folder of a site that was made before, or where to make it"
    )
    parser.add_argument("--kind", action="append", default=[])
    parser.add_argument("--damage", action="append", default=[])
    parser.add_argument("--look", action="store_true", help="ask verify only, and run nothing")
    asked = parser.parse_args()
    began, done = time.monotonic(), []
    with tempfile.TemporaryDirectory() as folder:
        place = asked.site or Path(folder) / "sound"
        sound = Site(place) if place.is_dir() else sound_site(place)
        for case in (looks if asked.look else cases)(sound, Path(folder), asked.kind, asked.damage):
            done.append(case)
            print(  # noqa: T201 - a command
                f"{case.kind:28} {case.damage:10} {case.found_by or '-':14} {case.ended}, {case.exit_code}",
                flush=True,
            )
            told = {
                "cases": len(done),
                "ended": Counter(one.ended for one in done),
                "not_well": [asdict(one) for one in done if not one.is_well],
                "seconds": round(time.monotonic() - began),
                "all": [asdict(one) for one in done],
            }
            asked.out.write_text(json.dumps(told, indent=1), encoding="utf-8")
    bad = [case for case in done if not case.is_well]
    print(f"{len(done)} cases, {len(bad)} not well")  # noqa: T201
    return 1 if bad else 0


if __name__ == "__main__":
    raise SystemExit(main())
