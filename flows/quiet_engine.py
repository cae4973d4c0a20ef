"""What Prefect does of itself for a server that people watch, and a workspace's own server need not have.

Every stage is told to the server by events, which its services write into the database: most of what a stage costs it, and
the ledger has it all. And every flow waits at its end for up to a second for the thread of its heartbeats.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from prefect.events.clients import NullEventsClient
from prefect.events.worker import EventsWorker
from prefect.settings import PREFECT_FLOWS_HEARTBEAT_FREQUENCY, temporary_settings

from flows.prefect_home import users_server


@contextmanager
def quiet_engine() -> Iterator[None]:
    """Do without events and heartbeats as long as the block lasts; with a server that the user named they stay.

    Flow runs and their states are told to the server all the same, by its API.
    """
    if users_server() is not None:
        yield
        return
    EventsWorker.set_client_override(NullEventsClient)
    try:
        with temporary_settings({PREFECT_FLOWS_HEARTBEAT_FREQUENCY: None}):
            yield
    finally:
        EventsWorker.set_client_override(None)
