"""The last step of a run: what follows from all epochs of a structure, its alarms, and the catalog over all of it."""

from datetime import UTC, datetime

from flows.alarm_delivery import evaluate_and_deliver
from storage.catalog import rebuild_catalog
from storage.locks import series_lock
from storage.series import publish_series
from storage.workspace import Workspace
from tasks.assessment import assess
from tasks.settings import Campaign


def assess_structure(workspace: Workspace, campaign: Campaign) -> None:
    """Compare the epochs, follow the trend, raise and close alarms; the catalog shows all of it afterwards.

    Raises
    ------
    StorageError
        If the catalog cannot be read or written.
    """
    with series_lock(workspace, campaign.structure.id):
        rebuild_catalog(workspace)
        publish_series(workspace, campaign.structure.id, assess(workspace, campaign))
        rebuild_catalog(workspace)
    evaluate_and_deliver(workspace, campaign, datetime.now(UTC))
    rebuild_catalog(workspace)
