"""``tiltwatch watch``: take stations in as they arrive."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, workspace_of
from flows.terminal import answer, log_into
from storage.errors import UsageError

if TYPE_CHECKING:
    from flows.watch.events import Teller
    from flows.watch.place import WatchPlace

LOGS = "logs"
INBOX = "inbox"

Switch = Annotated[bool, Parameter(negative="", show_default=False)]


@Parameter(name="*")
@dataclass(frozen=True, slots=True, kw_only=True)
class InboxOptions:
    """What is watched, and what becomes of the files."""

    inbox: str
    """Folder into which stations come (made if it is not there), or s3://BUCKET/PREFIX."""
    keep: Switch = False
    """Leave files in the folder that were taken in."""
    move: Switch = False
    """Move objects that were taken in below taken/ of the prefix; they are left in place without it."""


@Parameter(name="*")
@dataclass(frozen=True, slots=True, kw_only=True)
class PaceOptions:
    """How often it looks, and for how long it waits."""

    once: Switch = False
    """Take in and run what is there, and end."""
    interval_s: float = 5.0
    """Seconds between two looks."""
    settle_s: float | None = None
    """So many seconds a file must keep its size and time of change; 10 in a folder, 0 for objects on S3."""
    run_timeout_s: float = 4 * 3600.0
    """A run of an epoch is ended after so many seconds."""


@Parameter(name="*")
@dataclass(frozen=True, slots=True, kw_only=True)
class UploadOptions:
    """Uploads over HTTP (tus), into the inbox folder."""

    listen: str | None = None
    """HOST:PORT on which uploads are taken; port 0 takes a free one."""
    token_env: str | None = None
    """Name of the environment variable that holds the token of the senders."""
    tls_cert: Path | None = None
    """Certificate (PEM); with --tls-key."""
    tls_key: Path | None = None
    """Key of the certificate (PEM)."""
    insecure_http: Switch = False
    """Listen without TLS on an address that others can reach."""


def watch(
    file: CampaignFile,
    /,
    *,
    inbox: InboxOptions,
    pace: PaceOptions = PaceOptions(),
    uploads: UploadOptions = UploadOptions(),
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Take station files in as they arrive, say what is missing while the crew is on site, run complete epochs.

    A scan comes with a sidecar of the same name (ST01.laz, ST01.toml); an empty file EPOCH.complete says that no more
    stations come. docs/watch.md has it all. With --json, one object a line and event.
    """
    from flows.watch.loop import Pace, Watch, keep_watching
    from storage.locks import watch_lock
    from storage.upgrade import ready_or_new_workspace
    from tasks.settings.intake import load_awaiting

    campaign = load_awaiting(file)
    _check_pace(pace)
    place = ready_or_new_workspace(workspace_of(campaign.folder, workspace))
    log_into(place.root / LOGS)
    with ExitStack() as stack:
        watched, settle_s = _open_inbox(file, campaign.structure.id, place.root, inbox)
        stack.enter_context(watch_lock(place, campaign.structure.id, watched.inbox))
        teller = _teller(watched, as_json=as_json)
        port = _take_uploads(stack, watched, uploads, teller)
        _tell_start(watched, inbox, port, teller)
        steps = Pace(
            pace.interval_s, settle_s if pace.settle_s is None else pace.settle_s, pace.run_timeout_s
        )
        code = keep_watching(Watch(watched, teller, steps), steps, once=pace.once)
    return answer(code, {"event": "stopped"}) if as_json else code


def _check_pace(pace: PaceOptions) -> None:
    for name, value in (("--interval-s", pace.interval_s), ("--run-timeout-s", pace.run_timeout_s)):
        if not value > 0.0:
            raise UsageError(f"{name} needs seconds above 0, got {value:g}")
    if pace.settle_s is not None and not pace.settle_s >= 0.0:
        raise UsageError(f"--settle-s needs seconds from 0 on, got {pace.settle_s:g}")


def _open_inbox(
    file: Path, structure: str, workspace: Path, wanted: InboxOptions
) -> "tuple[WatchPlace, float]":
    """The inbox, and for how long its files must rest."""
    from flows.watch.place import WatchPlace
    from storage.digests import text_sha256
    from storage.inbox import SETTLE_S
    from storage.s3_inbox import S3Inbox, is_s3_url, parse_s3_url, s3_files
    from storage.workspace import Workspace

    if not is_s3_url(wanted.inbox):
        if wanted.move:
            raise UsageError(
                "--move is for objects on S3; files of a folder are moved unless --keep is given"
            )
        folder = _made(Path(wanted.inbox).expanduser().absolute())
        return WatchPlace(file, structure, Workspace(workspace), folder, keeps=wanted.keep), SETTLE_S
    if wanted.keep:
        raise UsageError("objects on S3 are left in place unless --move is given; --keep is for folders")
    source = parse_s3_url(wanted.inbox)
    folder = _made(workspace / INBOX / text_sha256(source.path)[:16])
    objects = S3Inbox(source, folder, s3_files())
    return WatchPlace(file, structure, Workspace(workspace), folder, objects=objects, moves=wanted.move), 0.0


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise UsageError(f"the inbox {folder} cannot be made: {fault.strerror}; name a folder") from fault
    return folder


def _teller(place: "WatchPlace", *, as_json: bool) -> "Teller":
    from flows.watch.events import Teller

    return Teller(place.workspace, place.structure, as_json=as_json)


def _take_uploads(
    stack: ExitStack, place: "WatchPlace", wanted: UploadOptions, teller: "Teller"
) -> int | None:
    """Start the upload server if it is wanted; gives its port."""
    if wanted.listen is None:
        return None
    if place.objects is not None:
        raise UsageError(
            "--listen puts uploads into a folder; with an inbox on S3 start a second watch for them"
        )
    from flows.upload.server import listening, upload_server
    from flows.watch.events import WatchEvent

    how = listening(
        wanted.listen, wanted.token_env, (wanted.tls_cert, wanted.tls_key), insecure_http=wanted.insecure_http
    )

    def received(name: str, size_bytes: int) -> None:
        line = f"{name}: uploaded, {size_bytes / 1e6:.1f} MB"
        teller.tell(WatchEvent("uploaded", (line,), {"name": name, "size_bytes": size_bytes}))

    return stack.enter_context(upload_server(place.inbox, how, received))


def _tell_start(place: "WatchPlace", inbox: InboxOptions, port: int | None, teller: "Teller") -> None:
    from flows.watch.events import WatchEvent

    facts = {"inbox": inbox.inbox, "workspace": str(place.workspace.root), "upload_port": port}
    line = f"watching {inbox.inbox} for {place.structure}" + (
        "" if port is None else f"; uploads on port {port}"
    )
    teller.tell(WatchEvent("started", (line,), {"structure": place.structure, **facts}))
