"""What to do next, from the verdict, the change and the data."""

from collections.abc import Iterator

from dashboard import numbers
from dashboard.report.facts import Facts
from dashboard.report.words import Words


def next_steps(facts: Facts, words: Words) -> tuple[str, ...]:
    """Name the steps, the most urgent first."""
    return tuple(_steps(facts, words))


def _steps(facts: Facts, words: Words) -> Iterator[str]:
    tilt = facts.now.tilt
    if tilt is None:
        yield words("next.mend")
        return
    yield from _verdict(tilt.verdict, facts, words)
    yield from _change(facts, words)
    yield from _station(facts, words)
    if facts.epoch.state != "ok":
        yield words("next.mend_part")
    if tilt.verdict == "pass" and not _has_moved(facts):
        yield words("next.go_on")
    if not facts.references:
        yield words("next.reference")


def _verdict(verdict: str, facts: Facts, words: Words) -> Iterator[str]:
    limit = facts.primary_limit
    if verdict == "fail":
        yield words("next.assess")
        if limit is not None and limit.kind == "construction":
            yield words("next.which_limit")
    if verdict == "cannot tell":
        yield words("next.measure_better")
    if verdict == "no limit":
        yield words("next.name_limit")


def _change(facts: Facts, words: Words) -> Iterator[str]:
    if _has_moved(facts):
        yield words("next.find_cause")
    if facts.now.change is None and facts.epoch.is_reference:
        yield words("next.second_epoch")


def _has_moved(facts: Facts) -> bool:
    return facts.now.change is not None and facts.now.change.significant is True


def _station(facts: Facts, words: Words) -> Iterator[str]:
    epoch = facts.epoch
    if facts.now.lacks_a_station and epoch.next_station_azimuth_deg is not None:
        yield words(
            "next.station",
            azimuth=numbers.degrees(epoch.next_station_azimuth_deg, 0),
            now=numbers.number(epoch.stations_sigma_arcsec, 1),
            then=numbers.number(epoch.next_station_sigma_arcsec, 1),
        )
