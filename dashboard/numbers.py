"""How numbers are written for people: millimetres, degrees, uncertainties; what does not exist is ``--``."""

import math
from datetime import datetime
from typing import Final

MISSING: Final = "--"
"""Stands where there is no value; never 0."""

COVERAGE: Final = 2.0
"""Factor k of expanded uncertainties, about 95 %."""

MINUS: Final = "\u2212"


def number(value: float | None, digits: int = 1, unit: str = "") -> str:
    """Write a number with so many decimals and its unit; a NULL or NaN is ``--`` without a unit."""
    if value is None or math.isnan(value):
        return MISSING
    text = f"{value:.{digits}f}"
    if float(text) == 0.0:
        text = text.removeprefix("-")
    return text.replace("-", MINUS) + (f" {unit}" if unit else "")


def count(value: int | None) -> str:
    """Write a count with thin spaces between thousands."""
    return MISSING if value is None else f"{value:,}".replace(",", "\u202f")


def mm(value_m: float | None, digits: int = 1, unit: str = " mm") -> str:
    """Write metres as millimetres."""
    return MISSING if value_m is None else number(1e3 * value_m, digits) + unit


def signed_mm(value_m: float | None, digits: int = 1, unit: str = " mm") -> str:
    """Write metres as millimetres, with its sign."""
    text = mm(value_m, digits, unit)
    return text if text[0] in (MINUS, MISSING[0]) else f"+{text}"


def mm_with_u(value_m: float | None, sigma_m: float | None, unit: str = " mm") -> str:
    """Write metres as millimetres with the expanded uncertainty (k = 2); says so where that is unknown."""
    if value_m is None:
        return MISSING
    if sigma_m is None:
        return f"{mm(value_m, unit='')} ± {MISSING}{unit}"
    digits = digits_for(COVERAGE * sigma_m * 1e3)
    return f"{mm(value_m, digits, '')} ± {mm(COVERAGE * sigma_m, digits, '')}{unit}"


def digits_for(uncertainty: float, most: int = 2) -> int:
    """Decimals that show two figures of an uncertainty, at most so many."""
    if not math.isfinite(uncertainty) or uncertainty <= 0.0:
        return 1
    return min(max(1 - math.floor(math.log10(uncertainty)), 0), most)


def degrees(value_deg: float | None, digits: int = 2) -> str:
    """Write an angle in decimal degrees."""
    return MISSING if value_deg is None else number(value_deg, digits) + "°"


def dms(value_deg: float | None, digits: int = 1) -> str:
    """Write an angle as degrees, minutes and seconds."""
    if value_deg is None or math.isnan(value_deg):
        return MISSING
    units = 10**digits
    whole = round(abs(value_deg) * 3600 * units)
    sign = MINUS if value_deg < 0.0 and whole else ""
    minutes, parts = divmod(whole, 60 * units)
    degree, minute = divmod(minutes, 60)
    second = f"{parts / units:0{3 + digits if digits else 2}.{digits}f}"
    return f"{sign}{degree}°{minute:02d}\u2032{second}\u2033"


def probability(value: float | None) -> str:
    """Write a probability with two figures; below one in ten thousand only that."""
    if value is None:
        return MISSING
    return "< 0.0001" if value < 1e-4 else f"{value:.2g}"


def p_value(value: float | None) -> str:
    """Write a probability with its name, as in ``p = 0.03`` or ``p < 0.0001``."""
    text = probability(value)
    return f"p {text}" if text.startswith("<") else f"p = {text}"


def day(time: datetime | None) -> str:
    """Write the date of an instant, UTC."""
    return MISSING if time is None else f"{time:%Y-%m-%d}"


def minute(time: datetime | None) -> str:
    """Write an instant to the minute, UTC."""
    return MISSING if time is None else f"{time:%Y-%m-%d %H:%M} UTC"


def age(then: datetime, now: datetime) -> str:
    """Say how long ago something was."""
    days = (now - then).total_seconds() / 86400.0
    if days < 0.0:
        return "in the future of this machine's clock"
    if days < 2.0:
        return f"{24.0 * days:.0f} hours ago"
    return f"{days:.0f} days ago" if days < 730.0 else f"{days / 365.25:.1f} years ago"


def brief(text: str | None, most: int = 140) -> str:
    """Cut a long text at a word; the whole of it is to stand somewhere else."""
    if text is None:
        return ""
    return text if len(text) <= most else text[:most].rsplit(" ", 1)[0] + " …"
