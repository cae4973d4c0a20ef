"""How the lean of a structure goes on over its epochs."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True, kw_only=True)
class TrendRow:
    """The trend of the lean over all epochs of a structure, under one scheme and method.

    Movements are those of the axis at ``height_m`` relative to z = 0: the lean times the height. NULL stands where the
    epochs are too few to tell; ``reason`` says so. Where a change point is significant, rate and dates are those after it.
    """

    structure: Annotated[str, Column("id of the structure")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    n_epochs: Annotated[int, Column("epochs with an axis and a covariance")]
    first_epoch: Annotated[str, Column("earliest of them")]
    last_epoch: Annotated[str, Column("latest of them")]
    first_time: Annotated[datetime, Column("time of the earliest", "UTC")]
    last_time: Annotated[datetime, Column("time of the latest", "UTC")]
    height_m: Annotated[float, Column("height H at which movements are stated", "m")]
    model: Annotated[str, Column("terms of the model, as rate + season + temperature + random walk")]
    reason: Annotated[str, Column("why these terms, or why there is no rate")]
    rate_east_m_per_year: Annotated[float | None, Column("rate to the east", "m/a")] = None
    rate_north_m_per_year: Annotated[float | None, Column("rate to the north", "m/a")] = None
    rate_cov_ee: Annotated[float | None, Column("variance of the rate to the east", "m2/a2")] = None
    rate_cov_en: Annotated[float | None, Column("covariance of both rates", "m2/a2")] = None
    rate_cov_nn: Annotated[float | None, Column("variance of the rate to the north", "m2/a2")] = None
    rate_m_per_year: Annotated[float | None, Column("length of the rate", "m/a")] = None
    rate_sigma_m_per_year: Annotated[float | None, Column("standard deviation along the rate", "m/a")] = None
    rate_p_value: Annotated[
        float | None, Column("probability of such a rate or a larger one if there is none", "1")
    ] = None
    rate_significant: Annotated[bool | None, Column("whether rate_p_value is below 0.01")] = None
    random_walk_m_per_sqrt_year: Annotated[
        float | None, Column("standard deviation of a component's random walk after one year", "m/sqrt(a)")
    ] = None
    season_m: Annotated[float | None, Column("amplitude of the yearly swing", "m")] = None
    season_sigma_m: Annotated[float | None, Column("standard deviation of season_m", "m")] = None
    temperature_m_per_degree: Annotated[
        float | None, Column("length of the movement with temperature", "m/K")
    ] = None
    temperature_sigma_m_per_degree: Annotated[float | None, Column("its standard deviation", "m/K")] = None
    misfit_p_value: Annotated[
        float | None, Column("probability of residuals as large as these if the stated covariances hold", "1")
    ] = None
    limit_m: Annotated[
        float | None, Column("allowable deviation at height_m that is extrapolated to", "m")
    ] = None
    limit_reached_at: Annotated[
        datetime | None,
        Column("when the deviation reaches limit_m at this rate; NULL if never within 100 years", "UTC"),
    ] = None
    limit_earliest_at: Annotated[
        datetime | None, Column("when the upper 95 % bound of the deviation reaches it", "UTC")
    ] = None
    limit_latest_at: Annotated[
        datetime | None, Column("when the lower 95 % bound does; NULL if never within 100 years", "UTC")
    ] = None
    change_point_epoch: Annotated[
        str | None,
        Column("epoch from which on the structure moves otherwise; NULL where none is significant"),
    ] = None
    change_point_time: Annotated[datetime | None, Column("when it began to, as estimated", "UTC")] = None
    change_point_earliest: Annotated[datetime | None, Column("lower end of its 95 % interval", "UTC")] = None
    change_point_latest: Annotated[datetime | None, Column("upper end of its 95 % interval", "UTC")] = None
    change_point_kind: Annotated[str | None, Column("step or rate")] = None
    change_point_p_value: Annotated[
        float | None, Column("probability of a change point as clear as this if there is none", "1")
    ] = None
    rate_before_m_per_year: Annotated[float | None, Column("length of the rate before it", "m/a")] = None
    rate_after_m_per_year: Annotated[float | None, Column("length of the rate after it", "m/a")] = None
    rate_after_sigma_m_per_year: Annotated[float | None, Column("its standard deviation", "m/a")] = None
    step_m: Annotated[float | None, Column("length of the step, where it is one", "m")] = None
    step_sigma_m: Annotated[float | None, Column("its standard deviation", "m")] = None
