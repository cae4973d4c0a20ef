"""The campaign file as a whole."""

import hashlib
import json
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from tasks.settings.epochs import Epoch
from tasks.settings.execution import Execution
from tasks.settings.files import Files
from tasks.settings.frame import Frame
from tasks.settings.instrument import Instrument
from tasks.settings.limits import Limits
from tasks.settings.preprocessing import Preprocessing
from tasks.settings.registration import Registration
from tasks.settings.report import Report
from tasks.settings.scan_paths import resolve_scan
from tasks.settings.schemes import Scheme
from tasks.settings.section import SafeId, Section, problem
from tasks.settings.structure import Structure

FOLDER: str = "folder"
"""Key of the validation context that carries the folder of the campaign file."""


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
    execution: Execution = Field(default=Execution(), description="what the machine may spend")

    _folder: Path = PrivateAttr(default=Path())

    @model_validator(mode="after")
    def _has_epochs(self, info: ValidationInfo) -> Self:
        if not self.epochs:
            raise problem("a campaign needs at least one epoch", "add an [[epochs]] table")
        if info.context:
            self._folder = info.context[FOLDER]
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
        """Return all settings with their defaults as canonical JSON: sorted keys, no spaces, ASCII."""
        return json.dumps(self.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))

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

    def epoch(self, name: str) -> Epoch | None:
        """Return the epoch of that id, if there is one."""
        return next((epoch for epoch in self.epochs if epoch.id == name), None)
