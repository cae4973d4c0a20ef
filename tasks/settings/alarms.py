"""The tables [[alarms]]: which findings raise an alarm, how grave it is, and who is told."""

from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from tasks.settings.section import SafeId, Section, problem

Severity = Literal["info", "warning", "alarm"]
Quantity = Literal["lean", "base", "bending", "radius", "centres"]

COMMON_KEYS: Final = frozenset({"id", "when", "severity", "notify", "mute_hours_between"})
"""Keys of every rule; the others are those of its kind."""

ClearRatio = Annotated[
    float,
    Field(
        gt=0.0,
        le=1.0,
        description="the alarm eases when the value is back below this share of its limit (above limit over ratio where"
        " a smaller value is worse) [1]",
    ),
]


def _one_of(table: Section, keys: tuple[str, ...]) -> None:
    given = [key for key in keys if getattr(table, key) is not None]
    if len(given) != 1:
        came = " and ".join(given) or "none"
        raise problem(
            f"needs one of {', '.join(keys)}, got {came}", "write one [[alarms]] table for each that is meant"
        )


class AlarmTable(Section):
    """A rule: what it is called, how grave it is, who is told."""

    id: SafeId = Field(
        description="name of the rule; unique in the campaign, part of the names of its alarms"
    )
    severity: Severity = Field(
        default="warning", description="info, warning (status: exit code 5) or alarm (exit code 6)"
    )
    notify: Annotated[tuple[SafeId, ...], Field(strict=False)] = Field(
        default=(), description="ids of [[notify]] tables that are told; nobody where it is missing"
    )
    mute_hours_between: float = Field(
        default=0.0,
        ge=0.0,
        le=8784.0,
        description="a target hears of this rule at most once in so many hours; what comes in between is told after [h]",
    )


class LimitAlarm(AlarmTable):
    """The deviation is beyond the allowable one, by the guard band of the verdict."""

    when: Literal["limit"] = Field(description="kind of rule: deviation against the allowable one")
    at_least: Literal["fail", "cannot tell"] = Field(
        default="fail", description="verdict from which on it is broken: fail, or cannot tell already"
    )
    clear_ratio: ClearRatio = 0.9


class ShareOfLimitAlarm(AlarmTable):
    """The deviation is above a share of the allowable one, without a guard band."""

    when: Literal["share-of-limit"] = Field(
        description="kind of rule: deviation against a share of the limit"
    )
    share: float = Field(gt=0.0, le=1.0, description="share of the allowable deviation, as 0.8 [1]")
    clear_ratio: ClearRatio = 0.9


class MovedAlarm(AlarmTable):
    """A quantity changed significantly against the reference epoch."""

    when: Literal["moved"] = Field(description="kind of rule: significant change against the reference epoch")
    p: float = Field(
        default=0.01,
        gt=0.0,
        le=0.5,
        description="probability below which chance is no explanation: the share of false findings where nothing moves [1]",
    )
    quantity: Quantity = Field(default="lean", description="lean, base, bending, radius or centres")
    confirm: bool = Field(
        default=False,
        description="only where the epoch before, or [report] control in the same epoch, is significant at p, too, in the"
        " same direction",
    )
    clear_ratio: ClearRatio = 0.9


class RateAlarm(AlarmTable):
    """The structure moves too fast, or reaches its limit too soon."""

    when: Literal["rate"] = Field(description="kind of rule: the trend over all epochs")
    mm_per_year: float | None = Field(
        default=None,
        gt=0.0,
        le=1e5,
        description="broken where the rate at the height of the deviation is above this by more than twice its standard"
        " deviation [mm/year]",
    )
    limit_within_years: float | None = Field(
        default=None,
        gt=0.0,
        lt=100.0,
        description="broken where the rate is significant and the upper 95 % bound of the deviation reaches the limit"
        " within so many years after the last epoch [years]",
    )
    clear_ratio: ClearRatio = 0.9

    @model_validator(mode="after")
    def _one(self) -> Self:
        _one_of(self, ("mm_per_year", "limit_within_years"))
        return self


class CusumAlarm(AlarmTable):
    """Small changes add up in the control chart."""

    when: Literal["cusum"] = Field(description="kind of rule: control chart of the lean")
    signal: Literal["watch", "alarm"] = Field(
        default="alarm",
        description="watch (a false one every 167 epochs on average) or alarm (every 455)",
    )
    clear_ratio: ClearRatio = 0.9


class QualityAlarm(AlarmTable):
    """The data of an epoch are not good enough in one respect."""

    when: Literal["quality"] = Field(description="kind of rule: data that are not good enough")
    state: Literal["degraded", "failed"] | None = Field(
        default=None, description="broken where the epoch is so or worse, or the primary gave no axis"
    )
    sigma_mm: float | None = Field(
        default=None,
        gt=0.0,
        le=1e5,
        description="broken where the standard deviation of the deviation is above this [mm]",
    )
    coverage_deg: float | None = Field(
        default=None,
        gt=0.0,
        le=360.0,
        description="broken where less of the circumference was seen, mean over the height [deg]",
    )
    stations: int | None = Field(
        default=None, ge=1, le=1000, description="broken where fewer stations entered the result"
    )
    clear_ratio: ClearRatio = 0.9

    @model_validator(mode="after")
    def _one(self) -> Self:
        _one_of(self, ("state", "sigma_mm", "coverage_deg", "stations"))
        return self


class MissedCampaignAlarm(AlarmTable):
    """Nothing was measured for too long."""

    when: Literal["missed-campaign"] = Field(description="kind of rule: no epoch for too long, by the clock")
    interval_days: float = Field(gt=0.0, le=36525.0, description="time between two campaigns [days]")
    grace_days: float = Field(
        default=0.0, ge=0.0, le=36525.0, description="how much longer it may take [days]"
    )


class LateStationAlarm(AlarmTable):
    """A station of an epoch that has begun does not arrive."""

    when: Literal["late-station"] = Field(description="kind of rule: what an inbox waits for, by the clock")
    hours: float = Field(
        gt=0.0, le=87660.0, description="time after the first station of the epoch arrived [h]"
    )


Alarm = Annotated[
    LimitAlarm
    | ShareOfLimitAlarm
    | MovedAlarm
    | RateAlarm
    | CusumAlarm
    | QualityAlarm
    | MissedCampaignAlarm
    | LateStationAlarm,
    Field(discriminator="when"),
]
"""A rule; ``when`` says of which kind."""

DEFAULT_ALARMS: Final[tuple[Alarm, ...]] = (
    MovedAlarm(id="moved-5pct", when="moved", p=0.05, severity="info"),
    MovedAlarm(id="moved-1pct", when="moved", p=0.01, severity="warning"),
    MovedAlarm(id="moved-confirmed", when="moved", p=0.001, confirm=True, severity="alarm"),
    CusumAlarm(id="cusum-watch", when="cusum", signal="watch", severity="warning"),
    CusumAlarm(id="cusum-alarm", when="cusum", signal="alarm", severity="alarm"),
    LimitAlarm(id="limit", when="limit", at_least="fail", severity="alarm"),
    QualityAlarm(id="quality", when="quality", state="degraded", severity="info"),
)
"""The rules of a campaign file without [[alarms]]; nobody is told of them."""
