"""What the report says of the campaign's settings, as they were when the epoch was processed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from storage.errors import StorageError


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of the run that published an epoch, as far as a report names them; metres and degrees."""

    name: str | None
    kind: str
    height_m: float
    shaft_z_m: tuple[float, float]
    radius_m: tuple[float, float]
    base_xy_m: tuple[float, float]
    horizontal: str
    range_sigma_m: float
    angle_sigma_deg: float
    level_sigma_deg: float
    position_sigma_m: tuple[float, float]
    heading_sigma_deg: float
    temperatures_c: Mapping[str, float]
    """By epoch; only where one is stated."""


def settings_of(content: Mapping[str, Any]) -> Settings:
    """Read the filled-in settings that a run stored beside its results.

    Raises
    ------
    StorageError
        If something lacks that every version has stored.
    """
    try:
        return _read(content)
    except (KeyError, TypeError, ValueError) as fault:
        raise StorageError(f"the stored settings lack or spoil {fault}; run the epoch again") from fault


def _read(content: Mapping[str, Any]) -> Settings:
    structure, instrument = content["structure"], content["instrument"]
    return Settings(
        structure.get("name"),
        structure["kind"],
        float(structure["height_m"]),
        _two(structure["shaft_z_m"]),
        _two(structure["radius_m"]),
        _two(structure["base_xy_m"]),
        str(content["frame"]["horizontal"]),
        float(instrument["range_sigma_m"]),
        float(instrument["angle_sigma_deg"]),
        float(instrument["level_sigma_deg"]),
        _two(instrument["position_sigma_m"]),
        float(instrument["heading_sigma_deg"]),
        {
            epoch["id"]: float(epoch["temperature_c"])
            for epoch in content["epochs"]
            if epoch.get("temperature_c") is not None
        },
    )


def _two(values: Any) -> tuple[float, float]:
    first, second = values
    return float(first), float(second)
