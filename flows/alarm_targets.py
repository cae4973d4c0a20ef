"""Send a message about an alarm to one target: mail and web services by apprise, or a program of the user's."""

import json
import logging
import os
import signal
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final
from urllib.parse import urlencode

from flows.terminal import Json
from storage.errors import InputError
from storage.secrets import secret_in
from tasks.settings.notify import CommandTarget, EmailTarget, Notify, WebhookTarget

if TYPE_CHECKING:
    import apprise

MAIL: Final = ("mailto://", "mailtos://")
TAKES_FIELDS: Final = ("json://", "jsons://", "form://", "forms://")
"""Services of apprise that pass fields on beside title and message."""

LONGEST_REASON: Final = 400


@dataclass(frozen=True, slots=True, kw_only=True)
class Letter:
    """A message in every guise that a target may want."""

    title: str
    body: str
    severity: str
    is_over: bool
    """Whether it says that an alarm has ended."""
    facts: Mapping[str, Json]


def send(target: Notify, letter: Letter, folder: Path) -> str | None:
    """Send a message; None where it was taken, else the reason, without any secret in it.

    Parameters
    ----------
    folder
        Folder of the campaign file, in which commands are started.
    """
    if isinstance(target, CommandTarget):
        return _run(target, letter, folder)
    return _post(target, letter)


def _post(target: EmailTarget | WebhookTarget, letter: Letter) -> str | None:
    try:
        url = secret_in(target.url_env)
    except InputError as fault:
        return str(fault)
    if not url:
        return f"the environment variable {target.url_env} is not set"
    if isinstance(target, EmailTarget) and not url.lower().startswith(MAIL):
        return f"the environment variable {target.url_env} holds no {' or '.join(MAIL)} URL"
    if url.lower().startswith(TAKES_FIELDS):
        url += ("&" if "?" in url else "?") + urlencode(
            {f":{name}": "" if value is None else value for name, value in letter.facts.items()}
        )
    return _by_apprise(url, target.url_env, letter)


def _by_apprise(url: str, variable: str, letter: Letter) -> str | None:
    import apprise  # noqa: PLC0415 (slow to import)

    with apprise.LogCapture(level=logging.WARNING, fmt="%(message)s") as said:  # type: ignore[no-untyped-call]
        service = apprise.Apprise.instantiate(url, suppress_exceptions=True)
        if service is None:
            return f"the environment variable {variable} holds no URL that apprise understands"
        post = apprise.Apprise()
        post.add(service)
        taken = post.notify(
            title=letter.title,
            body=letter.body,
            notify_type=_kind(letter),
            body_format=apprise.NotifyFormat.TEXT,
        )
        reasons = "; ".join(said.getvalue().split("\n")).strip("; ")
    if taken:
        return None
    return _without_secrets(reasons or "the service did not take it", url, service)


def _kind(letter: Letter) -> "apprise.NotifyType":
    import apprise  # noqa: PLC0415 (slow to import)

    if letter.is_over:
        return apprise.NotifyType.SUCCESS
    kinds = {"info": apprise.NotifyType.INFO, "warning": apprise.NotifyType.WARNING}
    return kinds.get(letter.severity, apprise.NotifyType.FAILURE)


def _without_secrets(text: str, url: str, service: "apprise.NotifyBase") -> str:
    """Take out what no log may hold: the URL with its user, password and path."""
    secrets = [url, service.password, service.user, getattr(service, "fullpath", None)]
    for secret in secrets:
        if secret and len(str(secret)) > 1:
            text = text.replace(str(secret), "***")
    return text[:LONGEST_REASON]


def _run(target: CommandTarget, letter: Letter, folder: Path) -> str | None:
    try:
        process = subprocess.Popen(
            target.command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            cwd=folder,
            start_new_session=True,
        )
    except (OSError, ValueError) as fault:
        return f"{target.command[0]} cannot be started: {getattr(fault, 'strerror', None) or fault}"
    content = json.dumps({**letter.facts, "title": letter.title, "text": letter.body}) + "\n"
    try:
        _, complaint = process.communicate(content.encode(), timeout=target.timeout_s)
    except subprocess.TimeoutExpired:
        _end(process)
        return f"{target.command[0]} took longer than {target.timeout_s:g} s and was ended"
    if process.returncode == 0:
        return None
    said = complaint.decode(errors="replace").strip()[-LONGEST_REASON:]
    return f"{target.command[0]} ended with {process.returncode}" + (f": {said}" if said else "")


def _end(process: "subprocess.Popen[bytes]") -> None:
    """End a program with all that it started."""
    with suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    process.kill()
    with suppress(subprocess.TimeoutExpired):
        process.communicate(timeout=5.0)
