"""What a run asks every worker of a cluster before it trusts it: the same code, the same store, the same server."""

import platform
import urllib.error
import urllib.request
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.digests import file_sha256, text_sha256
from storage.errors import InputError, TiltwatchError
from storage.places import check_store, is_on_s3
from tasks import stages
from tasks.caching import Stage
from tasks.code_version import code_version
from tasks.memory_room import allow_memory

ANSWER_S: Final = 10.0
"""So long a worker tries to reach the server."""


@dataclass(frozen=True, slots=True)
class Needed:
    """What the workers must have: the place of artifacts, a server, and of a folder the files that prove it shared."""

    place: str
    api_url: str
    shared_files: Mapping[str, str]
    """SHA-256 of files that every worker must see under the same path; none where the store is on S3."""
    memory_gb: float | None
    """What the stages of a worker may take together."""


def needed_of(place: str, api_url: str, campaign_file: Path, memory_gb: float | None) -> Needed:
    """What the workers must have for a run that keeps its artifacts at ``place``."""
    proofs = () if is_on_s3(place) else (Path(place) / "workspace.json", campaign_file.absolute())
    return Needed(place, api_url, {str(path): file_sha256(path) for path in proofs}, memory_gb)


def version_of_stages() -> str:
    """Digest of the code of all stages, as this machine has it, and of what runs it."""
    made = {name: code_version(known.fn) for name, known in vars(stages).items() if isinstance(known, Stage)}
    lines = [f"{name} {version}" for name, version in sorted(made.items())]
    return text_sha256("\n".join([*lines, platform.python_version().rpartition(".")[0]]))


def examine_worker(needed: Needed) -> tuple[str, tuple[str, ...]]:
    """Look at this worker: the version of its stages, and what it lacks; it learns its bound. Runs on the worker."""
    allow_memory(needed.memory_gb)
    lacks = [*_unseen_files(needed), *_unusable_store(needed), *_unreachable_server(needed)]
    return version_of_stages(), tuple(lacks)


def judge_workers(found: Mapping[str, tuple[str, tuple[str, ...]] | BaseException]) -> None:
    """Refuse a cluster in which any worker has other code or lacks something.

    Raises
    ------
    InputError
        One line for every worker that does not fit.
    """
    here = version_of_stages()
    lines = [line for address, said in found.items() for line in _why_unfit(address, said, here)]
    if lines:
        raise InputError("\n".join(lines))


def _why_unfit(address: str, said: tuple[str, tuple[str, ...]] | BaseException, here: str) -> tuple[str, ...]:
    same = "install the same tiltwatch, Python and locked packages there as here, and start the worker again"
    if isinstance(said, BaseException):
        return (f"worker {address} cannot run tiltwatch ({type(said).__name__}: {said}): {same}",)
    version, lacks = said
    if version != here:
        return (f"worker {address} has code {version[:12]}, this machine {here[:12]}: {same}",)
    return tuple(f"worker {address}: {lack}" for lack in lacks)


def _unseen_files(needed: Needed) -> list[str]:
    hint = "mount workspace and scans on every machine at the same path, or name a store on S3 in [execution]"
    return [
        f"does not see {path} as this machine does: {hint}"
        for path, sha256 in needed.shared_files.items()
        if not Path(path).is_file() or file_sha256(Path(path)) != sha256
    ]


def _unusable_store(needed: Needed) -> list[str]:
    if not is_on_s3(needed.place):
        return []
    try:
        check_store(needed.place)
    except TiltwatchError as fault:
        return [str(fault)]
    return []


def _unreachable_server(needed: Needed) -> list[str]:
    if not needed.api_url.startswith(("http://", "https://")):
        return [f"{needed.api_url!r} is no address of a Prefect server"]
    try:
        with urllib.request.urlopen(f"{needed.api_url}/health", timeout=ANSWER_S):  # noqa: S310 (http, see above)
            return []
    except (OSError, ValueError) as fault:
        return [
            f"cannot reach the Prefect server {needed.api_url} ({fault}): start one that all machines reach with "
            "`prefect server start --host 0.0.0.0`, and name it by PREFECT_API_URL"
        ]
