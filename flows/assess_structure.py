"""The last step of a run: what follows from all epochs of a structure, its alarms, and the catalog over all of it."""

import json
from datetime import UTC, datetime

from flows.alarm_delivery import evaluate_and_deliver
from flows.settled_epochs import program_digest
from storage.assessed import basis_of, is_assessed, put_down_assessed
from storage.catalog import rebuild_catalog
from storage.locks import publish_lock, series_lock
from storage.series import publish_series
from storage.workspace import Workspace
from tasks.assessment import assess
from tasks.settings import Campaign


def assess_structure(workspace: Workspace, campaign: Campaign) -> None:
    """Compare the epochs, follow the trend, raise and close alarms; the catalog shows all of it afterwards.

    What follows from the epochs alone is not made again where none of them changed; alarms follow the clock, too.

    Raises
    ------
    StorageError
        If the catalog cannot be read or written.
    """
    structure = campaign.structure.id
    with series_lock(workspace, structure):
        # together: an epoch that another run publishes is in both or in neither
        with publish_lock(workspace):
            rebuild_catalog(workspace)
            basis = basis_of(workspace, structure, _inputs_of(campaign))
        if not is_assessed(workspace, structure, basis):
            publish_series(workspace, structure, assess(workspace, campaign))
            put_down_assessed(workspace, structure, basis)
            rebuild_catalog(workspace)
    alarmed = evaluate_and_deliver(workspace, campaign, datetime.now(UTC))
    if alarmed.events or alarmed.sent:
        rebuild_catalog(workspace)


def _inputs_of(campaign: Campaign) -> str:
    """What an assessment rests on beside the published epochs: some settings, and the program."""
    temperatures = [(epoch.id, epoch.temperature_c) for epoch in campaign.epochs]
    return json.dumps([temperatures, list(campaign.report.primary), program_digest()])
