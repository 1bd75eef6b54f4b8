"""The ledger: where the idealised model counts volume more often, or less often, than the solid has it."""

from __future__ import annotations

from collections.abc import Sequence

from kernel.connect.joints import Joint
from kernel.idealise.members import LedgerRow
from kernel.idealise.parts import Parts


def volume_ledger(parts: Parts, joints: Sequence[Joint]) -> tuple[LedgerRow, ...]:
    """One row for each wall whose region times thickness is not its own volume."""
    rows = []
    for name, wall in parts.walls.items():
        more = wall.region.area * wall.thickness - wall.segment.volume
        if abs(more) > 1e-9 * wall.segment.volume:
            rows.append(LedgerRow((name,), "mid-surface moved to the joints", float(more)))
    return tuple(rows)
