"""The campaign file as a whole."""

import hashlib
import json
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from tasks.settings.alarms import DEFAULT_ALARMS, Alarm
from tasks.settings.epochs import Epoch
from tasks.settings.execution import Execution
from tasks.settings.files import Files
from tasks.settings.frame import Frame
from tasks.settings.instrument import Instrument
from tasks.settings.limit_file import StatedLimit
from tasks.settings.limits import Limits
from tasks.settings.notify import Notify
from tasks.settings.preprocessing import Preprocessing
from tasks.settings.registration import Registration
from tasks.settings.report import Report
from tasks.settings.scan_paths import resolve_scan
from tasks.settings.schedule import Schedule
from tasks.settings.schemes import Scheme
from tasks.settings.section import SafeId, Section, problem
from tasks.settings.structure import Structure

FOLDER: str = "folder"
"""Key of the validation context that carries the folder of the campaign file."""

AWAITS_EPOCHS: str = "awaits epochs"
"""Key of the validation context that lets a campaign be without epochs: they come through an inbox."""

OWN_LIMITS: str = "own limits"
"""Key of the validation context that carries the tables of the file of [limits]."""


class Campaign(Section):
    """A campaign: one structure, its epochs, and how they are to be worked on.

    ``load_campaign`` makes it from a file and checks besides what goes across tables (ids, scans named twice,
    folders); a campaign made in code has passed the checks of its tables only.
    """

    schema_version: Literal[1] = Field(description="version of this file's form; 1")
    structure: Structure = Field(description="what is watched")
    frame: Frame = Field(description="what coordinates mean")
    instrument: Instrument = Field(default=Instrument(), description="what the maker of the scanner states")
    epochs: Annotated[tuple[Epoch, ...], Field(strict=False)] = Field(
        description="what was measured, and when"
    )
    schemes: dict[SafeId, Scheme] = Field(default={}, description="own slicing schemes beside A to F and S")
    limits: Limits = Field(default=Limits(), description="how far from plumb the structure may be")
    report: Report = Field(default=Report(), description="which result counts")
    files: Files = Field(default=Files(), description="where scans may lie")
    registration: Registration = Field(default=Registration(), description="what ties the epochs together")
    preprocessing: Preprocessing = Field(default=Preprocessing(), description="how the shaft is isolated")
    alarms: Annotated[tuple[Alarm, ...], Field(strict=False)] | None = Field(
        default=None,
        description="what raises an alarm; the rules of docs/monitoring.md where missing, none where []",
    )
    notify: Annotated[tuple[Notify, ...], Field(strict=False)] = Field(
        default=(), description="who is told of alarms"
    )
    execution: Execution = Field(default=Execution(), description="what the machine may spend")
    schedule: Schedule = Field(default=Schedule(), description="when it is processed without being asked")

    _folder: Path = PrivateAttr(default=Path())
    _own_limits: tuple[StatedLimit, ...] = PrivateAttr(default=())

    @model_validator(mode="after")
    def _has_epochs(self, info: ValidationInfo) -> Self:
        if not self.epochs and not (info.context or {}).get(AWAITS_EPOCHS):
            raise problem("a campaign needs at least one epoch", "add an [[epochs]] table")
        if info.context:
            self._folder = info.context[FOLDER]
            self._own_limits = info.context.get(OWN_LIMITS, ())
        return self

    @property
    def folder(self) -> Path:
        """Folder of the campaign file; paths are relative to it."""
        return self._folder

    @property
    def digest(self) -> str:
        """SHA-256 of the filled-in settings; where the file lies does not enter."""
        return hashlib.sha256(self.filled_in_json().encode()).hexdigest()

    def filled_in_json(self) -> str:
        """Return all settings with their defaults as canonical JSON: sorted keys, no spaces, ASCII.

        The tables of the file of [limits] are settings, too, and stand in ``own_limits`` where there are such.
        """
        content = self.model_dump(mode="json")
        if self._own_limits:
            content["own_limits"] = [limit.model_dump(mode="json") for limit in self._own_limits]
        return json.dumps(content, sort_keys=True, separators=(",", ":"))

    @property
    def own_limits(self) -> tuple[StatedLimit, ...]:
        """The tables of the file of [limits], every version of them."""
        return self._own_limits

    @property
    def primary_limit_name(self) -> str | None:
        """Name of the table that gives the verdict: the one that is named, or the only one of the file."""
        names = {limit.name for limit in self._own_limits} - set(self.limits.also)
        only = next(iter(names)) if len(names) == 1 else None
        return self.limits.table if self.limits.table is not None else only

    def scan_path(self, scan: str) -> Path:
        """Resolve a scan that the file names.

        Raises
        ------
        InputError
            If it lies outside the campaign's folder and the roots of [files].
        """
        return resolve_scan(scan, self._folder, self.files.roots)

    @property
    def reference_epoch(self) -> Epoch:
        """The epoch that changes are counted from: the one that says so, else the earliest."""
        marked = next((epoch for epoch in self.epochs if epoch.reference), None)
        return marked or min(self.epochs, key=lambda epoch: epoch.time)

    @property
    def alarm_rules(self) -> tuple[Alarm, ...]:
        """The rules of the file, or those that hold where it names none."""
        return DEFAULT_ALARMS if self.alarms is None else self.alarms

    def epoch(self, name: str) -> Epoch | None:
        """Return the epoch of that id, if there is one."""
        return next((epoch for epoch in self.epochs if epoch.id == name), None)
