"""What to mind in the data of an epoch, and what follows from it, in figures of the catalog."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import median

from dashboard import numbers
from dashboard.content.coverage import Gap, gaps
from dashboard.content.schemes import order_of
from storage.records import CoverageRow, EpochRow, SchemeRow, SliceRow, StationRow, TiltRow
from storage.views.condition import FULL_COVERAGE_DEG, WORTHWHILE_GAIN


@dataclass(frozen=True, slots=True)
class Mind:
    """Something to mind: how grave (quality, warning or note), what it is, and what follows."""

    tone: str
    what: str
    then: str


@dataclass(frozen=True, slots=True)
class Evidence:
    """The rows that the warnings of an epoch are made of.

    ``before`` is the newest other epoch that is whole, with its axes; None where there is none.
    """

    epoch: EpochRow
    result: tuple[str, str]
    tilts: Sequence[TiltRow]
    schemes: Sequence[SchemeRow]
    stations: Sequence[StationRow]
    slices: Sequence[SliceRow]
    coverage: Sequence[CoverageRow]
    before: EpochRow | None = None
    tilts_before: Sequence[TiltRow] = ()

    @property
    def tilt(self) -> TiltRow | None:
        """The axis that is shown."""
        return self.tilt_of(self.result)

    def tilt_of(self, pair: tuple[str, str]) -> TiltRow | None:
        """The axis of a scheme and method in this epoch."""
        return next((row for row in self.tilts if (row.scheme, row.method) == pair), None)

    def u_before_m(self, pair: tuple[str, str]) -> float | None:
        """Expanded uncertainty of the deviation in the other epoch."""
        return next((_u_m(row) for row in self.tilts_before if (row.scheme, row.method) == pair), None)


def warnings(found: Evidence) -> list[Mind]:
    """All that is to be minded, the gravest first."""
    minds = [
        *_epoch(found),
        *_stations(found),
        *_failed_schemes(found),
        *_axis(found),
        *_said_of_axes(found),
        *_unseen(found),
        *_failed_slices(found),
        *_next_station(found),
    ]
    order = ("quality", "warning", "note")
    return sorted(minds, key=lambda mind: order.index(mind.tone))


def _epoch(found: Evidence) -> Iterator[Mind]:
    epoch = found.epoch
    if epoch.state == "ok":
        return
    used = f"{epoch.n_stations_used} of {epoch.n_stations} stations entered the result"
    rest = _without_stations(epoch.reason or "", found.stations)
    what = f"The epoch is {epoch.state}: {used}" + (f"; {rest}" if rest else "")
    if epoch.state == "failed":
        yield Mind("quality", what, _instead(found))
        return
    yield Mind("quality", what, _less_certain(found) or "The rest was processed.")


def _without_stations(reason: str, stations: Sequence[StationRow]) -> str:
    """What a reason says beyond what stands at its stations."""
    for row in stations:
        if row.reason:
            reason = reason.replace(f"station {row.station}: {row.reason}", "")
    return "; ".join(part.strip() for part in reason.split(";") if part.strip())


def _instead(found: Evidence) -> str:
    if found.before is None:
        return "There is no result, and no other epoch that is whole."
    before = next((row for row in found.tilts_before if (row.scheme, row.method) == found.result), None)
    told = "" if before is None else f": {numbers.mm_with_u(before.deviation_m, before.deviation_sigma_m)}"
    return f"There is no result. The last whole epoch before it is {found.before.epoch}{told}."


def _less_certain(found: Evidence) -> str:
    """How much less certain this epoch is than the one before."""
    parts, before = [], found.before
    if before is None:
        return ""
    now_arcsec, then_arcsec = found.epoch.stations_sigma_arcsec, before.stations_sigma_arcsec
    if now_arcsec is not None and then_arcsec is not None:
        parts.append(
            f"Predicted sigma of the lean {numbers.number(now_arcsec, 2)}\u2033, "
            f"{numbers.number(then_arcsec, 2)}\u2033 in {before.epoch}"
        )
    now_m = None if found.tilt is None else _u_m(found.tilt)
    then_m = found.u_before_m(found.result)
    if now_m is not None and then_m is not None:
        parts.append(f"U of the deviation {numbers.mm(now_m)}, {numbers.mm(then_m)} in {before.epoch}")
    return f"{'; '.join(parts)}." if parts else ""


def _stations(found: Evidence) -> Iterator[Mind]:
    then = {
        "suspect": "Used all the same; see what the result is without before signing.",
        "failed": "Not used; what nobody else has seen is missing.",
    }
    grouped: dict[tuple[str, str], list[str]] = {}
    for row in found.stations:
        if row.state != "ok":
            # one fault of many files is one thing to say
            reason = (row.reason or "no reason is stored").replace(row.station, "…")
            grouped.setdefault((row.state, reason), []).append(row.station)
    for (state, reason), names in grouped.items():
        told = reason.replace("…", names[0]) if len(names) == 1 else reason
        what = f"{_many('Station', names)} {'is' if len(names) == 1 else 'are'} {state}: {told}"
        yield Mind("quality", what, then.get(state, ""))


def _failed_schemes(found: Evidence) -> Iterator[Mind]:
    for row in found.schemes:
        if row.state != "ok":
            what = f"{row.scheme}/{row.method} gave no axis: {row.reason or 'no reason is stored'}"
            is_shown = (row.scheme, row.method) == found.result
            then = (
                "It has neither verdict nor change here."
                if is_shown
                else "The other schemes are not affected."
            )
            yield Mind("quality" if is_shown else "warning", what, then)


def _axis(found: Evidence) -> Iterator[Mind]:
    tilt = found.tilt
    if tilt is None:
        return
    label = f"{tilt.scheme}/{tilt.method}"
    if tilt.deviation_sigma_m is None:
        then = "Neither an uncertainty nor a change can be stated, and no guard band protects the verdict."
        yield Mind("quality", f"{label} has no covariance", then)
    if tilt.azimuth_deg is None and tilt.warning is None:
        then = "The deviation holds, its direction does not."
        yield Mind("warning", f"The lean of {label} is below 3 sigma", then)


def _said_of_axes(found: Evidence) -> Iterator[Mind]:
    grouped: dict[str, list[TiltRow]] = {}
    for row in sorted(found.tilts, key=lambda row: order_of((row.scheme, row.method))):
        if row.warning:
            # one warning with several figures is one thing to say
            grouped.setdefault(re.sub(r"\(p [<=] [^)]*\)", "", row.warning), []).append(row)
    for rows in grouped.values():
        names = [f"{row.scheme}/{row.method}" for row in rows]
        tone = "warning" if any((row.scheme, row.method) == found.result for row in rows) else "note"
        told = rows[0].warning if len(rows) == 1 else re.sub(r" \(p [<=] [^)]*\)", "", rows[0].warning or "")
        yield Mind(tone, f"{', '.join(names)}: {told}", _follows(rows))


def _follows(rows: Sequence[TiltRow]) -> str:
    jackknifed = [row for row in rows if row.covariance_source == "jackknife"]
    if jackknifed:
        parts = [
            f"{row.scheme}/{row.method} {numbers.mm(_u_m(row))} rather than {numbers.mm(_propagated_u_m(row))}"
            for row in jackknifed
        ]
        return f"U of the deviation: {', '.join(parts)}."
    if all(row.azimuth_deg is None for row in rows):
        return "No direction of lean is stated."
    return "Look at it before signing."


def _unseen(found: Evidence) -> Iterator[Mind]:
    for gap in gaps(found.coverage):
        what = (
            f"{gap.z_low_m:.1f} to {gap.z_high_m:.1f} m lacks {gap.lacking_deg:.0f}°: nothing was seen "
            f"{_sectors(gap)}"
        )
        wide = 360.0 - gap.lacking_deg < FULL_COVERAGE_DEG
        yield Mind("warning" if wide else "note", what, _centres_there(found, gap))


def _sectors(gap: Gap) -> str:
    return " and ".join(f"from {begin:.0f}° to {end % 360.0:.0f}°" for begin, end in gap.sectors)


def _centres_there(found: Evidence, gap: Gap) -> str:
    """How well centres within a gap are known, beside those that were seen from all sides."""
    lacking = gaps(found.coverage)
    known = [row for row in _shown_slices(found) if row.sigma_center_m is not None]
    there = [row.sigma_center_m for row in known if gap.z_low_m <= row.z_m < gap.z_high_m]
    whole = [
        row.sigma_center_m for row in known if not any(g.z_low_m <= row.z_m < g.z_high_m for g in lacking)
    ]
    if not there:
        return f"{_label(found)} has no centre there."
    u_there = numbers.mm(numbers.COVERAGE * median(s for s in there if s is not None), 2)
    said = f"U of a centre of {_label(found)} there: {u_there}"
    if whole:
        said += (
            f"; where all sides were seen: {numbers.mm(numbers.COVERAGE * median(s for s in whole if s), 2)}"
        )
    return f"{said}."


def _shown_slices(found: Evidence) -> list[SliceRow]:
    return [row for row in found.slices if (row.scheme, row.method) == found.result]


def _failed_slices(found: Evidence) -> Iterator[Mind]:
    by_pair: dict[tuple[str, str], list[SliceRow]] = {}
    for row in found.slices:
        by_pair.setdefault((row.scheme, row.method), []).append(row)
    failed = {
        pair: lost
        for pair in sorted(by_pair, key=order_of)
        if (lost := [row for row in by_pair[pair] if row.state != "ok"])
    }
    parts = {pair: f"{len(lost)} of {len(by_pair[pair])}" for pair, lost in failed.items()}
    shown = failed.pop(found.result, None)
    if shown:
        what = f"{parts[found.result]} slices of {_label(found)} failed, {_heights(shown)}: {_reasons(shown)}"
        yield Mind("warning", what, f"The {_rests_on(found, found.result)}.")
    if failed:
        lost = [row for rows in failed.values() for row in rows]
        counts = ", ".join(f"{parts[pair]} of {'/'.join(pair)}" for pair in failed)
        then = "; ".join(f"{'/'.join(pair)}: {_rests_on(found, pair)}" for pair in failed)
        yield Mind("note", f"Slices failed, {_heights(lost)}: {counts}; {_reasons(lost)}", f"{then}.")


def _reasons(rows: Sequence[SliceRow]) -> str:
    return "; ".join(counted_reasons([row.reason for row in rows]))


def counted_reasons(reasons: Sequence[str | None]) -> list[str]:
    """Reasons that differ in their last figure alone as one, with how often each was given."""
    grouped: dict[str, list[float]] = {}
    plain: dict[str, int] = {}
    for reason in reasons:
        match = re.fullmatch(r"(.*, got )(\d+)", reason or "")
        if match:
            grouped.setdefault(match[1], []).append(int(match[2]))
        else:
            plain[reason or "no reason is stored"] = plain.get(reason or "no reason is stored", 0) + 1
    told = [
        f"{words}{min(got):.0f}" + (f" to {max(got):.0f}" if max(got) > min(got) else "") + _times(len(got))
        for words, got in grouped.items()
    ]
    return told + [f"{reason}{_times(count)}" for reason, count in plain.items()]


def _times(count: int) -> str:
    return f" ({count} times)" if count > 1 else ""


def _heights(rows: Sequence[SliceRow]) -> str:
    low, high = min(row.z_m for row in rows), max(row.z_m for row in rows)
    return f"at {low:.1f} m" if low == high else f"between {low:.1f} and {high:.1f} m"


def _rests_on(found: Evidence, pair: tuple[str, str]) -> str:
    tilt = found.tilt_of(pair)
    if tilt is None:
        return "no axis"
    before_m = found.u_before_m(pair)
    said = f"axis rests on {tilt.n_centres} centres, U {numbers.mm(_u_m(tilt))}"
    if before_m is not None and found.before is not None:
        said += f" ({numbers.mm(before_m)} in {found.before.epoch})"
    return said


def _next_station(found: Evidence) -> Iterator[Mind]:
    epoch = found.epoch
    now, then, azimuth = (
        epoch.stations_sigma_arcsec,
        epoch.next_station_sigma_arcsec,
        epoch.next_station_azimuth_deg,
    )
    if now is None or then is None or azimuth is None:
        return
    gain = 1.0 - then / now
    seen = epoch.coverage_deg
    is_worth = gain > WORTHWHILE_GAIN or (seen is not None and seen < FULL_COVERAGE_DEG)
    what = (
        f"One more station would help most at {azimuth:.0f}°, clockwise from grid north as seen from the axis"
    )
    said = (
        f"Predicted sigma of the lean {numbers.number(now, 2)}\u2033 would become {numbers.number(then, 2)}\u2033, "
        f"{100.0 * gain:.0f} % less" + ("." if is_worth else ": not worth the way.")
    )
    yield Mind("warning" if is_worth else "note", what, said)


def _u_m(tilt: TiltRow) -> float | None:
    return None if tilt.deviation_sigma_m is None else numbers.COVERAGE * tilt.deviation_sigma_m


def _propagated_u_m(tilt: TiltRow) -> float | None:
    """Expanded uncertainty of the deviation by propagation alone, along the lean."""
    ee, en, nn = tilt.propagated_cov_ee, tilt.propagated_cov_en, tilt.propagated_cov_nn
    lean = math.hypot(tilt.lean_east, tilt.lean_north)
    if ee is None or en is None or nn is None or lean == 0.0:
        return None
    east, north = tilt.lean_east / lean, tilt.lean_north / lean
    variance = ee * east**2 + 2.0 * en * east * north + nn * north**2
    return numbers.COVERAGE * tilt.height_m * math.sqrt(max(variance, 0.0))


def _label(found: Evidence) -> str:
    return "/".join(found.result)


def _many(noun: str, names: Sequence[str]) -> str:
    return f"{noun} {names[0]}" if len(names) == 1 else f"{noun}s {', '.join(names[:-1])} and {names[-1]}"
