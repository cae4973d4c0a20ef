"""When an epoch is complete: all its stations are there, or a marker says that no more come."""

from collections.abc import Sequence
from pathlib import Path

from flows.watch.events import Teller, WatchEvent
from flows.watch.file_kinds import MARKER, is_marker, is_scan
from flows.watch.place import WatchPlace
from storage.errors import TiltwatchError
from storage.ids import check_id
from storage.inbox import InboxFile
from storage.intake import write_intake
from tasks.arrivals import SCANS, expected_stations, missing_stations
from tasks.settings import Campaign
from tasks.settings.intake import Intake, intake_text, load_awaiting, read_intakes


class Epochs:
    """Marks epochs as complete."""

    def __init__(self, place: WatchPlace, teller: Teller) -> None:
        self._place = place
        self._teller = teller

    def follow(self, files: Sequence[InboxFile]) -> tuple[Intake, ...]:
        """Mark what has become complete; gives all epochs that came through the inbox.

        ``files`` are those of an inbox that has come to rest; none while anything is still on its way: it may be the
        last station of an epoch, whose marker was quicker.

        Raises
        ------
        InputError
            If the campaign file or an intake is damaged.
        """
        campaign = load_awaiting(self._place.campaign_file)
        for intake in read_intakes(self._place.workspace.root, self._place.structure):
            awaited = expected_stations(intake, campaign)
            if intake.complete is None and awaited and not missing_stations(intake, campaign):
                self._complete(intake.model_copy(update={"complete": "stations"}), campaign, ())
        left = [file.name for file in files if is_scan(file)]
        for marker in (file for file in files if is_marker(file)):
            self._read_marker(marker, campaign, [] if self._place.keeps else left)
        return read_intakes(self._place.workspace.root, self._place.structure)

    def _read_marker(self, marker: InboxFile, campaign: Campaign, left: Sequence[str]) -> None:
        epoch = marker.path.name[: -len(MARKER)]
        try:
            check_id(epoch, "an epoch")
            self._obey_marker(marker, epoch, campaign, left)
        except TiltwatchError as fault:
            lines = (f"kept: {marker.name}: {fault}",)
            facts = {"name": marker.name, "reason": str(fault)}
            self._teller.tell_once(marker.name, WatchEvent("kept", lines, facts))

    def _obey_marker(self, marker: InboxFile, epoch: str, campaign: Campaign, left: Sequence[str]) -> None:
        intakes = read_intakes(self._place.workspace.root, self._place.structure)
        intake = next((one for one in intakes if one.epoch == epoch), None)
        if intake is None:
            line = f"{marker.name}: waits for the first station of epoch {epoch!r}"
            self._teller.tell_once(marker.name, WatchEvent("waiting", (line,), {"name": marker.name}))
            return
        if intake.complete is None:
            self._complete(intake.model_copy(update={"complete": "marker"}), campaign, left)
        elif self._place.keeps:
            return
        target = Path(campaign.folder) / SCANS / self._place.structure / epoch / f"{epoch}{MARKER}"
        self._place.place(marker, target)
        self._place.take_out(marker, target)

    def _complete(self, intake: Intake, campaign: Campaign, left: Sequence[str]) -> None:
        place = self._place
        write_intake(place.workspace, place.structure, intake.epoch, intake_text(intake))
        missing = missing_stations(intake, campaign)
        without = f", without {', '.join(missing)}" if missing else ""
        why = "all its stations are there" if intake.complete == "stations" else "its marker says so"
        still = f"; not taken in, and still in the inbox: {', '.join(left)}" if left else ""
        line = f"{intake.epoch}: complete with {len(intake.stations)} stations{without}: {why}{still}"
        facts = {
            "epoch": intake.epoch,
            "by": intake.complete,
            "stations": list(intake.arrived),
            "missing_stations": list(missing),
            "left_in_inbox": list(left),
        }
        self._teller.tell(WatchEvent("complete", (line,), facts))
