"""A large model from text to deck: seconds by stage, CPU seconds and peak memory of a process of its own.

    python bench/frame.py [SEGMENTS] [--kind touching|overlapping|plates|deck|mixed] [--size H] [--formats]
                      [--profile FILE]

SEGMENTS: about as many, 1,000 by default. Asked for: 1,000 members under 15 s, 10,000 segments under 3 minutes and
4 GB. --formats writes every format there is, each timed. --profile leaves a cProfile file.
"""

from __future__ import annotations

import argparse
import cProfile
import hashlib
import resource
import time
from collections import Counter
from collections.abc import Callable

from app.collector import collect_rarely
from app.pipeline import classify, mesh, write_deck
from kernel.csg.reader import read_model
from kernel.deck.deck import formats
from kernel.errors import CsgmeshError
from kernel.mesh.options import MeshOptions


def block(size: tuple[float, float, float], corner: tuple[float, float, float]) -> str:
    """A PADL-like block with its corner at a place."""
    placed = ", ".join(f"MOV{axis}={value:g}" for axis, value in zip("XYZ", corner))
    return f"(BLO({size[0]:g}, {size[1]:g}, {size[2]:g}) AT ({placed}))"


def floor_frame(bays: int, overlap: float) -> list[str]:
    """bays x bays columns of 40 x 40, beams of 40 x 40 on them both ways; members run `overlap` into one another."""
    solids = []
    for i in range(bays):
        for j in range(bays):
            x, y = 1000.0 * i, 1000.0 * j
            if i < bays - 1 or j < bays - 1:  # no beam begins at the last corner
                solids.append(block((40, 40, 960 + overlap), (x, y, 0)))
            if i < bays - 1:
                solids.append(block((1000 + overlap, 40, 40), (x, y, 960)))
            if j < bays - 1:
                solids.append(block((40, 1000 + overlap, 40), (x, y, 960)))
    return solids


def frame(segments: int) -> list[str]:
    """A floor of touching columns and beams: 3 members a bay."""
    return floor_frame(_least(segments, lambda n: n * n + 2 * n * (n - 1)), 0)


def overlapping(segments: int) -> list[str]:
    """The same, all members running through their joints: every joint is an overlap to be settled."""
    return floor_frame(_least(segments, lambda n: n * n + 2 * n * (n - 1)), 40)


def deck(segments: int) -> list[str]:
    """A box deck: a floor, girders that run through, and a web in every bay between two of them."""
    bays = _least(segments, lambda n: n * (n + 1) + n + 2)
    pitch, t, height = 60.0, 4.0, 50.0
    length = bays * pitch + t
    solids = [block((length, length, t), (0, 0, 0))]
    for i in range(bays + 1):
        solids.append(block((t, length, height), (i * pitch, 0, t)))
    for i in range(bays):
        for j in range(bays + 1):
            solids.append(block((pitch - t, t, height), (i * pitch + t, j * pitch, t)))
    return solids


def rooms(segments: int) -> list[str]:
    """Storeys of 9 x 9 rooms: a floor, walls one way that run through, walls the other way room by room."""
    bays, pitch, height, t = 9, 300.0, 300.0, 10.0
    storeys = max(1, round(segments / (1 + bays + 1 + bays * (bays + 1))))
    length = bays * pitch + t
    solids = []
    for level in range(storeys):
        base = level * (height + t)
        solids.append(block((length, length, t), (0, 0, base)))
        solids += [block((t, length, height), (i * pitch, 0, base + t)) for i in range(bays + 1)]
        solids += [
            block((pitch - t, t, height), (i * pitch + t, j * pitch, base + t))
            for i in range(bays)
            for j in range(bays + 1)
        ]
    return solids


def mixed(segments: int) -> list[str]:
    """The frame with floor plates on every other bay, as on a chess board (side by side they would be one plate)."""
    bays = _least(segments, lambda n: n * n + 2 * n * (n - 1) + (n - 1) ** 2 // 2)
    solids = floor_frame(bays, 0)
    for i in range(bays - 1):
        for j in range(i % 2, bays - 1, 2):
            solids.append(block((1000, 1000, 20), (1000.0 * i, 1000.0 * j, 1000)))
    return solids


def _least(segments: int, count: Callable[[int], int]) -> int:
    return next(n for n in range(2, 1000) if count(n) >= segments)


KINDS = {"touching": frame, "overlapping": overlapping, "plates": rooms, "deck": deck, "mixed": mixed}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("segments", type=int, nargs="?", default=1000)
    parser.add_argument("--kind", choices=KINDS, default="touching")
    parser.add_argument("--size", type=float, help="of the elements, automatic if not given")
    parser.add_argument("--formats", action="store_true")
    parser.add_argument("--profile")
    arguments = parser.parse_args()
    text = "MODEL = " + " UN &\n".join(KINDS[arguments.kind](arguments.segments)) + "\nOUT MODEL\n"
    profile = cProfile.Profile(time.process_time)  # the machine may be busy with other work
    if arguments.profile:
        profile.enable()
    collect_rarely()  # as the command line does
    start, cpu = time.perf_counter(), time.process_time()
    csg = read_model(text, "frame.csg")
    reading = time.perf_counter() - start
    meshed = mesh(classify(csg), MeshOptions(size=arguments.size))
    middle = time.perf_counter()
    written = write_deck(meshed, "frame.bdf")
    end = time.perf_counter()
    cpu = time.process_time() - cpu
    if arguments.profile:
        profile.disable()
        profile.dump_stats(arguments.profile)
    segments = Counter(element.kind for element in meshed.model.properties)
    elements = sum(len(each.connectivity) for each in meshed.model.mesh.blocks)
    print(
        f"{arguments.kind}: {', '.join(f'{count:,} {kind}' for kind, count in segments.items())}, "
        f"{len(meshed.classified.joints):,} joints, {elements:,} elements, {meshed.checks.components} component"
    )
    stages = {"read": reading, **meshed.seconds, "write": end - middle}
    print(", ".join(f"{stage} {seconds:.2f}" for stage, seconds in stages.items()))
    print(
        f"all {end - start:.1f} s, {cpu:.1f} CPU s, {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:,.0f} MB"
        f"; deck {len(written):,} bytes {hashlib.sha256(written).hexdigest()[:12]}"
        f"; {'; '.join(meshed.checks.failures) or 'checked'}"
    )
    if arguments.formats:
        for name in (each.name for each in formats()):
            start = time.perf_counter()
            try:
                size = f"{len(write_deck(meshed, 'frame', name)):,} bytes"
            except CsgmeshError as error:
                size = error.message
            print(f"  {name}: {time.perf_counter() - start:.2f} s, {size}")


if __name__ == "__main__":
    main()
