"""Settings of Prefect for one workspace, made before Prefect is imported: its own home, quiet, no telemetry."""

import os
from collections.abc import Mapping
from pathlib import Path

from flows.ephemeral_server import mark_server, stop_orphans
from flows.terminal import note
from storage.workspace import Workspace


def prepare_prefect(workspace: Workspace) -> None:
    """Point Prefect to the workspace.

    A server that the user names by PREFECT_API_URL is used; otherwise each run starts one of its own on
    loopback that goes away with it. One that a killed run left behind is stopped here. What the user set in
    the environment wins. The records of stages are in the workspace in any case: the flow says so itself.
    """
    for name, value in _defaults(workspace.prefect).items():
        os.environ.setdefault(name, value)
    if "PREFECT_API_URL" not in os.environ:
        home = Path(os.environ["PREFECT_HOME"])
        for process in stop_orphans(home):
            note(f"stopped process {process}: the server of a run that was killed")
        mark_server(home)


def _defaults(home: Path) -> Mapping[str, str]:
    return {
        "PREFECT_HOME": str(home),
        "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
        "DO_NOT_TRACK": "1",
        # a loaded machine needs longer than the 20 seconds that Prefect gives its own server
        "PREFECT_SERVER_EPHEMERAL_STARTUP_TIMEOUT_SECONDS": "120",
        # failures reach the user through the ledger; Prefect's own lines would only repeat them
        "PREFECT_LOGGING_LEVEL": "CRITICAL",
        "PREFECT_SERVER_LOGGING_LEVEL": "CRITICAL",
        "PREFECT_LOGGING_TO_API_ENABLED": "false",
        "PREFECT_CLI_PROMPT": "false",
        "RAY_USAGE_STATS_ENABLED": "0",
    }
