"""The address of a workflow server that the user names: without a login in it, and elsewhere only with a secret."""

import os
from typing import Final
from urllib.parse import urlsplit

from storage.errors import UsageError
from storage.loopback import is_loopback
from storage.secrets import has_login, without_login

ADDRESS: Final = "PREFECT_API_URL"
PROOFS: Final = ("PREFECT_API_AUTH_STRING", "PREFECT_API_KEY", "PREFECT_CLIENT_CUSTOM_HEADERS")
"""By which a client shows a server that it may; one of them is needed for a server on another machine."""


def check_server_address(url: str | None) -> None:
    """Refuse an address that would be written down with its password, or that anybody may give work to.

    Who can talk to a workflow server can have the workers run what it likes.

    Raises
    ------
    UsageError
        If the address carries a login, is none, or is of another machine and no secret is set.
    """
    if not url:
        return
    if has_login(url):
        raise UsageError(
            f"{ADDRESS} {without_login(url)} carries a login, which would be written into records; put USER:PASSWORD into "
            f"{PROOFS[0]}"
        )
    host = _host_of(url)
    if not is_loopback(host) and not any(os.environ.get(name) for name in PROOFS):
        raise UsageError(
            f"the workflow server at {host} is on another machine and no secret is set: give it one by "
            f"PREFECT_SERVER_API_AUTH_STRING, and set {PROOFS[0]} here to the same (infra/README.md)"
        )


def _host_of(url: str) -> str:
    try:
        host = urlsplit(url).hostname
    except ValueError:
        host = None
    if not host:
        login, at, rest = url.rpartition("@")  # USER:PASSWORD@HOST without http:// is no login to urlsplit
        shown = f"***{at}{rest}" if login else url
        raise UsageError(f"{ADDRESS} needs an address as http://127.0.0.1:4200/api, got {shown[:80]!r}")
    return host
