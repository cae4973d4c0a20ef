"""A change against the reference epoch that chance does not explain."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import log, sqrt

from tasks.alarms.model import Finding, Point, RuleKind, millimetres
from tasks.alarms.record import Change, EpochState, Record
from tasks.geometry.probability_text import p_text


@dataclass(frozen=True, slots=True, kw_only=True)
class MovedRule:
    """Broken where the change of a quantity is significant at ``p``.

    With ``confirm`` a second witness has to agree: the epoch before, or a control that was measured by other means in the
    same epoch (schemes of one epoch share its scans and their levels); the witness is significant at ``p``, too, and shows
    into the same half of the compass where both have a direction. It eases when the change is below ``clear_ratio`` of
    what is significant.
    """

    p: float
    quantity: str
    confirm: bool
    clear_ratio: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge every epoch with a test of the quantity; the reference epoch has none."""
        points = []
        before: Change | None = None
        for epoch in record.epochs:
            change = epoch.changes.get(self.quantity)
            points.append(Point(epoch.epoch, epoch.epoch, self._finding(epoch, before)))
            before = change or before
        return points

    def _finding(self, epoch: EpochState, before: Change | None) -> Finding | None:
        change = epoch.changes.get(self.quantity)
        smallest_m = None if change is None else self._significant_m(change)
        if change is None or change.p_value is None or smallest_m is None:
            return None
        significant = change.p_value < self.p
        witness = self._witness(change, before, epoch.control_changes)
        said = "" if not (self.confirm and significant) else f", {witness or 'not confirmed yet'}"
        return Finding(
            value=change.size_m,
            limit_value=smallest_m,
            unit="m",
            broken=significant and (witness is not None or not self.confirm),
            eased=not significant and change.size_m < self.clear_ratio * smallest_m,
            what=f"the {self.quantity} changed by {millimetres(change.size_m)} since {change.reference_epoch}"
            f" ({p_text(change.p_value)}; from {millimetres(smallest_m)} on it is significant at {self.p:g}){said}",
        )

    def _significant_m(self, change: Change) -> float | None:
        """Size that would just be significant: the statistic grows with the square of the change."""
        if change.statistic is None or change.freedom is None:
            return None
        needed = _critical(change.freedom, self.p)
        if change.statistic > 0.0 and change.size_m > 0.0:
            return change.size_m * sqrt(needed / change.statistic)
        return None if change.sigma_m is None else change.sigma_m * sqrt(needed)

    def _witness(self, change: Change, before: Change | None, control: Mapping[str, Change]) -> str | None:
        if before is not None and self._agrees(change, before):
            return "confirmed by the epoch before"
        other = control.get(self.quantity)
        if other is not None and self._agrees(change, other):
            return "confirmed by the control"
        return None

    def _agrees(self, change: Change, other: Change) -> bool:
        if other.p_value is None or other.p_value >= self.p:
            return False
        if change.east is None or change.north is None or other.east is None or other.north is None:
            return True
        return change.east * other.east + change.north * other.north > 0.0


@cache
def _critical(freedom: int, p: float) -> float:
    """Chi-square of so many degrees of freedom that chance exceeds with probability p; of two it is -2 ln p."""
    if freedom == 2:
        return -2.0 * log(p)
    from scipy.special import chdtri  # noqa: PLC0415 (slow to import, and every run asks for the alarms)

    return float(chdtri(freedom, p))


KIND = RuleKind(
    name="moved",
    description="a change against the reference epoch is significant",
    advice="Compare the schemes and, where there is one, the reference measurement (tiltwatch compare); measure again "
    "before anything is decided.",
    rule=MovedRule,
)
