"""The preview of an epoch as lines for the crew."""

from collections.abc import Iterator

from tasks.design import BestPlace
from tasks.geometry.failure import FitFailure
from tasks.site_preview import SitePreview


def preview_lines(found: SitePreview) -> Iterator[str]:
    """What was seen, what is missing, and what to do next."""
    looked = [one for one in found.looks if one.seen is not None]
    head = f"{found.epoch} preview (stated poses, nothing registered)"
    yield f"{head}: {len(looked)} of {len(found.looks)} stations looked at{_coverage(found)}"
    for one in found.looks:
        if one.reason is not None:
            yield f"{found.epoch}   {one.station}: {one.reason}"
    yield f"{found.epoch}   expected sigma of the lean: {_sigma(found)}"
    yield f"{found.epoch}   {_next(found)}"


def _coverage(found: SitePreview) -> str:
    if found.covered_deg is None:
        return ""
    unseen = f"unseen: {_arcs(found.unseen_deg)}" if found.unseen_deg else "all sides seen"
    return f", {found.covered_deg:.0f}° of 360° seen; {unseen}"


def _arcs(arcs: tuple[tuple[float, float], ...]) -> str:
    if arcs == ((0.0, 360.0),):
        return "all sides"
    return ", ".join(f"azimuth {first:.0f}° to {last:.0f}°" for first, last in arcs)


def _sigma(found: SitePreview) -> str:
    lean = found.lean
    if isinstance(lean, FitFailure):
        return f"none yet: {lean.reason}"
    top_mm = 1e3 * found.height_m * lean.sigma_worst
    return f'{lean.sigma_worst_arcsec:.1f}", {top_mm:.1f} mm at {found.height_m:g} m, in the worst direction'


def _next(found: SitePreview) -> str:
    missing = f"still to come: {', '.join(found.missing)}; " if found.missing else ""
    place = found.place
    if not isinstance(place, BestPlace):
        return f"{missing}no next station is suggested: {place.reason}"
    east, north, _ = place.site.position_m
    return (
        f"{missing}one more station helps most at azimuth {place.azimuth_deg:.0f}° from the structure, "
        f"{place.distance_m:.0f} m away (near east {round(east)}, north {round(north)} m): "
        f'{place.lean.sigma_worst_arcsec:.1f}"'
    )
