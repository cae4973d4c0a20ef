"""The control chart of a structure: CUSUM of what an epoch is off all earlier ones."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class ControlChartRow:
    """An epoch in the control chart of a scheme and method.

    The lean of an epoch against the mean of the earlier ones, made independent and of unit variance by the covariances;
    its two components are charted each by a two-sided CUSUM.
    """

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    epoch_time: Annotated[datetime, Column("time of the epoch, as an instant", "UTC")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    standardised_1: Annotated[
        float, Column("first component against the mean of the earlier epochs, in sigmas", "1")
    ]
    standardised_2: Annotated[float, Column("second component, independent of the first", "1")]
    cusum_up_1: Annotated[float, Column("upper CUSUM of the first component", "1")]
    cusum_down_1: Annotated[float, Column("lower CUSUM of the first component", "1")]
    cusum_up_2: Annotated[float, Column("upper CUSUM of the second component", "1")]
    cusum_down_2: Annotated[float, Column("lower CUSUM of the second component", "1")]
    cusum: Annotated[float, Column("largest of the four", "1")]
    watch_limit: Annotated[
        float, Column("from here on: watch (a false one every 167 epochs on average)", "1")
    ]
    alarm_limit: Annotated[
        float, Column("from here on: alarm (a false one every 455 epochs on average)", "1")
    ]
    signal: Annotated[str, Column("none, watch or alarm")]
