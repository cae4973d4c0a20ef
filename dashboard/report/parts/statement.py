"""The result in plain words: lean, limit, change, trend, data."""

from collections.abc import Iterator

from dashboard import numbers
from dashboard.report.facts import Facts
from dashboard.report.parts import phrases
from dashboard.report.words import Words


def statement(facts: Facts, words: Words) -> tuple[str, ...]:
    """Write the paragraphs of the statement."""
    return tuple(_sentences(facts, words))


def _sentences(facts: Facts, words: Words) -> Iterator[str]:
    if facts.now.tilt is None:
        yield words(
            "say.no_result",
            epoch=facts.epoch.epoch,
            reason=phrases.brief(phrases.no_tilt_reason(facts, words)),
        )
        before = next((each for each in reversed(facts.history[:-1]) if each.tilt is not None), None)
        if before is not None and before.tilt is not None:
            found = numbers.mm_with_u(before.tilt.deviation_m, before.tilt.deviation_sigma_m)
            yield words(
                "say.last_result",
                epoch=before.epoch.epoch,
                date=numbers.day(before.epoch.epoch_time),
                found=found,
            )
        return
    yield _lean(facts, words)
    yield _limit(facts, words)
    yield _change(facts, words)
    yield from _trend(facts, words)
    yield from _data(facts, words)


def _lean(facts: Facts, words: Words) -> str:
    tilt = facts.now.tilt
    if tilt is None:
        return ""
    values = {
        "height": f"{tilt.height_m:g}",
        "deviation": numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m),
        "date": numbers.day(facts.epoch.epoch_time),
    }
    if tilt.azimuth_deg is None:
        key = "say.lean_without_direction" if tilt.deviation_sigma_m is not None else "say.lean_without_sigma"
        return words(key, **values)
    azimuth = numbers.degrees(tilt.azimuth_deg, 1)
    return words("say.lean", compass=phrases.compass(tilt.azimuth_deg, words), azimuth=azimuth, **values)


def _limit(facts: Facts, words: Words) -> str:
    tilt, limit = facts.now.tilt, facts.primary_limit
    if tilt is None:
        return ""
    if tilt.allowable_m is None:
        return words("say.no_limit", reason=tilt.verdict_reason or words("phrase.no_reason"))
    values = {"limit": numbers.mm(tilt.allowable_m), "title": phrases.limit_title(limit, words)}
    if limit is not None and limit.kind == "measurement":
        return words("say.limit_of_measurement", reason=limit.reason, **values)
    if tilt.deviation_sigma_m is None:
        return words("say.limit_without_sigma", **values)
    apart = numbers.mm(abs(tilt.deviation_m - tilt.allowable_m))
    times = numbers.number(tilt.deviation_m / tilt.allowable_m, 1)
    share = numbers.number(100.0 * tilt.deviation_m / tilt.allowable_m, 0)
    key = {"pass": "say.below", "fail": "say.above"}.get(tilt.verdict, "say.straddles")
    return words(key, apart=apart, times=times, share=share, **values)


def _change(facts: Facts, words: Words) -> str:
    change = facts.now.change
    if change is None:
        return words("say.reference" if facts.epoch.is_reference else "say.change_unknown")
    values = {
        "reference": change.reference_epoch,
        "date": numbers.day(change.reference_time),
        "change": numbers.mm_with_u(change.d_top_m, change.sigma_top_m),
        "detectable": numbers.mm(change.smallest_detectable_m),
    }
    if change.significant is None:
        return words("say.change_untested", **values)
    towards = phrases.movement_azimuth(change, words)
    return words("say.changed", towards=towards, **values) if towards else words("say.not_changed", **values)


def _trend(facts: Facts, words: Words) -> Iterator[str]:
    trend = facts.trend
    if trend is None or trend.rate_m_per_year is None:
        return
    unit = words("card.mm_per_year")
    rate = numbers.mm_with_u(trend.rate_m_per_year, trend.rate_sigma_m_per_year, f" {unit}")
    if trend.rate_significant:
        yield words("say.moving", rate=rate, epochs=trend.n_epochs, limit=phrases.limit_date(trend, words))
    else:
        yield words("say.not_moving", rate=rate, epochs=trend.n_epochs)


def _data(facts: Facts, words: Words) -> Iterator[str]:
    if facts.epoch.state != "ok":
        yield words("say.degraded", reason=phrases.brief(facts.epoch.reason or words("phrase.no_reason")))
