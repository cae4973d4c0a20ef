"""The frame in which an epoch was processed: what the campaign file says today may be another."""

from pydantic import ValidationError

from storage.drawing import DrawingFrame
from storage.errors import StorageError
from storage.ledger import kept_frame, settings_path
from storage.records import EpochRow
from storage.workspace import Workspace
from tasks.settings import Campaign
from tasks.settings.frame import Frame


def frame_of_epoch(place: Workspace, campaign: Campaign, epoch: EpochRow) -> DrawingFrame:
    """Frame of the settings with which an epoch was processed.

    Raises
    ------
    StorageError
        If they are not kept any more and are not those of the campaign file, or are damaged.
    """
    if epoch.campaign_digest == campaign.digest:
        return _drawn(campaign.frame)
    frame = _drawn(_processed_in(place, epoch))
    if frame == _drawn(campaign.frame):
        return frame
    return _drawn(
        _processed_in(place, epoch),
        f"[frame] of the campaign file changed since epoch {epoch.epoch} was processed; its geometry lies in the frame "
        "that held then; `tiltwatch run FILE` processes it in the new one",
    )


def _processed_in(place: Workspace, epoch: EpochRow) -> Frame:
    known = kept_frame(place, epoch.campaign_digest)
    if known is None:
        raise StorageError(
            f"the frame in which epoch {epoch.epoch} was processed is not known: its settings are not kept in "
            f"{settings_path(place, epoch.campaign_digest)}, and the campaign file has others today; "
            f"`tiltwatch run FILE --epoch {epoch.epoch}` processes it again"
        )
    try:
        return Frame.model_validate({name: known[name] for name in Frame.model_fields})
    except (KeyError, ValidationError) as fault:
        raise StorageError(
            f"the stored settings of epoch {epoch.epoch} lack or spoil [frame]; run the epoch again"
        ) from fault


def _drawn(frame: Frame, warning: str = "") -> DrawingFrame:
    epsg = None if frame.horizontal == "local" else int(frame.horizontal.removeprefix("EPSG:"))
    return DrawingFrame(frame.origin_enu_m, epsg, warning)
