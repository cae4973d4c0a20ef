"""Whether a workflow server can still write down what is done: for one whose database is stuck a run would wait."""

import base64
import http.client
import importlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import ClassVar, Final

from flows.workflow_server import LOOPBACK, ServerRecord
from storage.errors import TiltwatchError

WRITE_S: Final = 30.0
"""Longest wait for a small thing to be written down; a loaded machine needs seconds.

Prefect's client asks a server that does not answer six times over, for a minute each.
"""

CREATED: Final = (200, 201)


class ServerLostError(TiltwatchError):
    """A workflow server answered no longer when a run was under way."""

    exit_code: ClassVar[int] = 3


def why_it_cannot_write(record: ServerRecord) -> str | None:
    """Why nothing can be put down by a server, in words for the user; None where it can.

    It is asked to know a flow, which every run asks first.
    """
    secret = base64.b64encode(record.secret.encode()).decode()
    headers = {"Authorization": f"Basic {secret}", "Content-Type": "application/json"}
    connection = http.client.HTTPConnection(LOOPBACK, record.port, timeout=WRITE_S)
    try:
        connection.request("POST", "/api/flows/", json.dumps({"name": "monitor-campaign"}), headers)
        answer = connection.getresponse()
        answer.read()
    except TimeoutError:
        return f"its database took nothing in for {WRITE_S:.0f} s; end process {record.pid} if that stays so"
    except (OSError, http.client.HTTPException) as fault:
        return f"it does not answer ({fault})"
    finally:
        connection.close()
    if answer.status in CREATED:
        return None
    return f"its database takes nothing in (answer {answer.status}): is the drive of {record.folder} full?"


@contextmanager
def loss_told() -> Iterator[None]:
    """Say in words for the user that the server of a run answers no longer.

    Raises
    ------
    ServerLostError
        In the place of what Prefect's client raises when it has asked often enough.
    """
    try:
        yield
    except importlib.import_module("httpx").TransportError as fault:
        raise ServerLostError(
            f"the workflow server answers no longer ({type(fault).__name__}: {fault}); what was computed and published is "
            "kept: run again; another one takes its place if it stays so, unless PREFECT_API_URL names one of your own"
        ) from fault
