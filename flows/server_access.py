"""Reach a workflow server for a command that cannot do without one; what is wrong is said in the user's words."""

from collections.abc import Iterator
from contextlib import contextmanager

import httpx
from prefect.client.orchestration import SyncPrefectClient, get_client
from prefect.exceptions import PrefectHTTPStatusError
from prefect.settings import PREFECT_API_URL

from flows.server_address import check_server_address
from storage.errors import UsageError

UNAUTHORIZED = 401


@contextmanager
def server_client() -> Iterator[SyncPrefectClient]:
    """Client of the server that PREFECT_API_URL names.

    Raises
    ------
    UsageError
        If none is named, it does not answer, or it refuses the secret or what is asked for.
    """
    url = PREFECT_API_URL.value()
    if not url:
        raise UsageError(
            "needs the address of a workflow server in PREFECT_API_URL, as http://127.0.0.1:4200/api "
            "(infra/README.md says how to start one)"
        )
    check_server_address(url)
    try:
        with get_client(sync_client=True) as client:
            client.hello()
            yield client
    except PrefectHTTPStatusError as fault:
        if fault.response.status_code == UNAUTHORIZED:
            raise UsageError(
                f"the server at {url} wants a secret: set PREFECT_API_AUTH_STRING to the user:password that it has "
                "in PREFECT_SERVER_API_AUTH_STRING"
            ) from fault
        told = fault.response.text[:500]
        raise UsageError(f"the server at {url} refused ({fault.response.status_code}): {told}") from fault
    except httpx.HTTPError as fault:
        what = str(fault) or type(fault).__name__
        raise UsageError(
            f"the server at {url} did not answer ({what}); start it, or correct PREFECT_API_URL"
        ) from fault
