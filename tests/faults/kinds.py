"""Every kind of file that a workspace holds, and which of them may be lost without harm and why."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.tables import ALARM_EVENTS, EPOCH_TABLES, RUNS, SERIES_TABLES


@dataclass(frozen=True)
class Kind:
    """Files with names of one form; ``harmless`` says why nothing follows from them."""

    name: str
    pattern: str
    harmless: str = ""


KINDS: Final = (
    Kind("identity", r"workspace\.json"),
    Kind("catalog", r"catalog\.duckdb"),
    *(Kind(f"table {name}", rf"tables/{name}/[^/]+/[^/]+\.parquet") for name in EPOCH_TABLES),
    *(Kind(f"series {name}", rf"tables/{name}/[^/]+/series\.parquet") for name in SERIES_TABLES),
    Kind("alarm event", rf"tables/{ALARM_EVENTS}/[^/]+/[^/]+\.parquet"),
    Kind("ledger of runs", rf"tables/{RUNS}/[^/]+/[^/]+\.parquet"),
    Kind("seal", r"seals/[^/]+/[^/]+\.json"),
    Kind("second copy", r"second/.+"),
    *(
        Kind(f"artifact {ext}", rf"artifacts/../[0-9a-f]+\.{ext}")
        for ext in ("cloud", "json", "npy", "parquet")
    ),
    Kind("record", r"records/[^/]+-[0-9a-f]{64}"),
    Kind("settings", r"runs/settings/[0-9a-f]{64}\.json"),
    Kind("settings part", r"runs/settings-parts/[0-9a-f]{64}\.txt"),
    Kind("version table", r"versions/[^/]+/[^/]+/[^/]+/[^/]+\.parquet"),
    Kind("version manifest", r"versions/[^/]+/[^/]+/[^/]+/manifest\.json"),
    Kind("intake", r"intake/[^/]+/[^/]+\.toml"),
    Kind("set aside", r".+\.bad", "what was damaged is kept for people only; verify notes it"),
    Kind("intake note", r"intake/[^/]+/[^/]+\.run\.json", "without it a watch runs the epoch once more"),
    Kind("preview", r"previews/.+\.json", "told the crew on site; made anew with the next station"),
    Kind(
        "settled mark",
        r"runs/settled/[^/]+/[^/]+\.json",
        "saves time; without it the epoch is looked at again",
    ),
    Kind("assessed mark", r"runs/assessed/[^/]+\.txt", "saves time; without it the series are made again"),
    Kind("code versions", r"runs/code-versions\.json", "saves time; read only where its digest is right"),
    Kind("verified", r"artifacts/verified\.txt", "saves time; what it does not name is hashed again"),
    Kind("run record", r"runs/active/[^/]+\.json", "of a run that ended; the ledger has it, twice"),
    Kind("run journal", r"runs/active/[^/]+\.jsonl", "of a run under way; torn lines are left out"),
    Kind("lock", r"(locks/.+|runs/active/[^/]+\.lock)", "the system holds the lock, not the file"),
    Kind(
        "history of flow runs",
        r"prefect/[^/]+/prefect\.db",
        "nothing rests on it; a damaged one is set aside",
    ),
    Kind("workflow server", r"prefect/(?![^/]+/prefect\.db$).+", "its log, its record and its lock"),
    Kind("log", r"logs/.+", "for people"),
    Kind(
        "unfinished",
        r"(tmp/.+|.+\.tmp|publish-journal\.json)",
        "work under way; tests/storage/test_publish.py has it",
    ),
)


def kinds_of(name: str) -> list[Kind]:
    """Kinds to which a file belongs by its name in the workspace; exactly one, or the list is not complete."""
    found = [kind for kind in KINDS if re.fullmatch(kind.pattern, name)]
    aside = [kind for kind in found if kind.name in ("set aside", "unfinished")]
    return aside or found


def files_of_kind(workspace: Path, kind: Kind) -> list[str]:
    """Names of the files of a kind, sorted."""
    return [name for name in names_in(workspace) if kind in kinds_of(name)]


def names_in(workspace: Path) -> Iterable[str]:
    """Names of all files of a workspace, sorted."""
    return sorted(path.relative_to(workspace).as_posix() for path in workspace.rglob("*") if path.is_file())
