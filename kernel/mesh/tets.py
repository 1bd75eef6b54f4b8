"""Tetrahedra inside a closed triangulated surface, by fTetWild (Hu et al. 2020) in a guarded process of its own.

The mesher kills its process on bad input, holds the interpreter's lock, meshes open surfaces without a word, leaves
files in the working folder and never gives the same mesh twice. So: the input is checked first, the mesher runs in a
child with its own folder, a deadline and a memory limit, the result is checked, and kept by the hash of its input.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh import tetcache

DEADLINE = 300.0
"""Seconds that one mesh may take."""

MEMORY = 6_000_000_000
"""Bytes of address space that the mesher may take."""

ENVELOPE = 0.01
ENVELOPE_OF_SIZE = 0.08
ENVELOPE_OF_THICKNESS = 0.05
"""How far the mesh's surface may stray from the given one: at most these shares of the box's diagonal, of the size, and
of the body's thickness (twice its volume over its area). Narrower envelopes cost much time and many small elements;
boundary nodes are put on the true surfaces afterwards (fit.py)."""

VOLUME_TOLERANCE = 0.01
"""The tets' volume is the surface's within this share of it."""

CHILD_SETTINGS = "optimised, 1"
"""Part of the key under which meshes are kept: to be changed with tets_child.py's settings of the mesher."""

MAX_TETS = 5_000_000
"""More than this many would be expected: refused at once."""

_CHILD = Path(__file__).with_name("tets_child.py")


class UnfitTets(MeshError):
    """The mesh is sound, but does not fill the body: a narrower envelope or a smaller size may."""


def tetrahedralise(
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    size: float,
    deadline: float = DEADLINE,
    memory: int = MEMORY,
    envelope: float | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(nodes (n, 3), tets (k, 4)), positively oriented, every node used. Same input, same mesh (tetcache).

    vertices: (n, 3); triangles: (m, 3), closed, counter-clockwise from outside. size: target edge length.
    deadline: seconds; memory: bytes. envelope: length that the surface may stray by, None to choose it.
    MeshError: the surface is no closed body, the size asks for too much, or the
    mesher failed, was stopped, or gave a mesh that is none of this body.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    triangles = np.ascontiguousarray(triangles, dtype=np.int64)
    volume = check_surface(vertices, triangles)
    if not 0.0 < size < float("inf"):
        raise MeshError(f"tetrahedra of size {size:g}, expected a positive number")
    expected = 6.0 * np.sqrt(2.0) * volume / size**3
    if expected > MAX_TETS:
        raise MeshError(
            f"about {expected:.2g} tetrahedra of size {size:g}, expected at most {MAX_TETS:.2g}: take a larger size"
        )
    area = surface_area(vertices, triangles)
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if envelope is None:
        envelope = default_envelope(volume, area, diagonal, size)
    slack = max(VOLUME_TOLERANCE * volume, area * envelope)
    key = tetcache.key_of(vertices, triangles, size, envelope, _mesher_version(), CHILD_SETTINGS)
    kept = tetcache.load(key)
    if kept is not None:
        try:
            return check_tets(*kept, volume, slack)
        except MeshError:
            kept = None  # an entry that was damaged on disk: made anew
    nodes, tets = check_tets(*_run(vertices, triangles, size, envelope / diagonal, deadline, memory), volume, slack)
    return tetcache.keep(key, (nodes, tets))


def surface_area(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> float:
    """Area of the triangles."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def default_envelope(volume: float, area: float, diagonal: float, size: float) -> float:
    """How far the mesh's surface may stray from that of a body, as a length."""
    return min(ENVELOPE * diagonal, ENVELOPE_OF_SIZE * size, ENVELOPE_OF_THICKNESS * 2.0 * volume / area)


def check_surface(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> float:
    """Volume inside the surface. MeshError where it is not finite, not closed, not oriented outwards, or flat."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise MeshError(f"a surface of shapes {vertices.shape} and {triangles.shape}, expected (n, 3) and (m, 3)")
    if len(triangles) < 4:
        raise MeshError(f"a surface of {len(triangles)} triangles, expected at least four")
    if not np.isfinite(vertices).all():
        raise MeshError("a vertex of the surface is not finite")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise MeshError(f"a triangle names vertex {triangles.max()}, expected 0 to {len(vertices) - 1}")
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    if (start == end).any():
        raise MeshError("a triangle of the surface names one vertex twice")
    n = len(vertices)
    if not np.array_equal(np.sort(start * n + end), np.sort(end * n + start)):
        raise MeshError("the surface is not closed, or its triangles are not consistently oriented")
    a, b, c = (vertices[triangles[:, k]] - vertices.mean(axis=0) for k in range(3))
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
    if not volume > 0.0:
        raise MeshError(f"the surface encloses a volume of {volume:g}, expected more than 0 (outside out)")
    return volume


def check_tets(
    nodes: NDArray[np.float64], tets: NDArray[np.int64], volume: float, slack: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The tets, turned to positive volume, on the nodes they use. UnfitTets where they do not fill volume +- slack."""
    if len(tets) == 0:
        raise MeshError("the tetrahedral mesher gave no elements")
    if not np.isfinite(nodes).all() or tets.min() < 0 or tets.max() >= len(nodes):
        raise MeshError("the tetrahedral mesher gave nodes that are not finite or do not exist")
    used = np.unique(tets)
    place = np.full(len(nodes), -1, np.int64)
    place[used] = np.arange(len(used))
    nodes, tets = nodes[used], place[tets]
    signed = tet_volumes(nodes, tets)
    if (signed < 0.0).all():
        tets, signed = tets[:, [0, 2, 1, 3]], -signed
    bad = int((~(signed > 0.0)).sum())
    if bad:
        raise MeshError(f"{bad} of {len(tets)} tetrahedra are flat or inverted")
    if abs(float(signed.sum()) - volume) > slack:
        raise UnfitTets(
            f"the tetrahedra fill {signed.sum():g}, the surface encloses {volume:g}: expected the same within "
            f"{slack:g}; a smaller size may resolve its thin parts"
        )
    faces = np.sort(tets[:, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]].reshape(-1, 3), axis=1)
    _, count = np.unique(faces, axis=0, return_counts=True)
    if count.max() > 2:
        raise MeshError("more than two tetrahedra share a face")
    return nodes, tets


def tet_volumes(nodes: NDArray[np.float64], tets: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k,) signed volumes."""
    origin = nodes[tets[:, 0]]
    a, b, c = (nodes[tets[:, k]] - origin for k in (1, 2, 3))
    signed: NDArray[np.float64] = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    return signed


def tet_shapes(nodes: NDArray[np.float64], tets: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k,) 1 for the regular tet, 0 for a flat one, negative inside out: volume over cubed root mean square edge."""
    p = nodes[tets]
    volume = np.einsum("ij,ij->i", p[:, 1] - p[:, 0], np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 0])) / 6.0
    square = sum(np.einsum("ij,ij->i", p[:, a] - p[:, b], p[:, a] - p[:, b]) for a in range(4) for b in range(a))
    shapes: NDArray[np.float64] = 6.0 * np.sqrt(2.0) * volume / np.maximum((square / 6.0) ** 1.5, np.finfo(float).tiny)
    return shapes


def _mesher_version() -> str:
    from importlib.metadata import version

    return version("pytetwild")


def _run(
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    size: float,
    envelope: float,
    deadline: float,
    memory: int,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Nodes and tets as the child gives them; MeshError that says how it failed."""
    with tempfile.TemporaryDirectory(prefix="csgmesh-tets-") as folder:
        place = Path(folder)
        np.savez(
            place / "input.npz",
            vertices=vertices,
            triangles=triangles.astype(np.int32),
            numbers=np.array([size, envelope]),
        )
        said = run_guarded([str(_CHILD), str(int(memory)), f"{deadline:g}", str(os.getpid())], place, deadline)
        output = place / "output.npz"
        if not output.exists():
            raise MeshError(f"the tetrahedral mesher ended without a mesh{_quoted(said)}")
        with np.load(output, allow_pickle=False) as given:
            return given["nodes"].astype(np.float64), given["tets"].astype(np.int64)


def run_guarded(arguments: Sequence[str], folder: Path, deadline: float) -> str:
    """Run Python with the arguments in the folder; what it wrote to stderr. MeshError: it failed, or took too long."""
    with (folder / "stderr.txt").open("w+b") as errors:
        child = subprocess.Popen(
            [sys.executable, "-P", *arguments],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
        )
        try:
            status = child.wait(timeout=deadline)
        except subprocess.TimeoutExpired:
            raise MeshError(
                f"the tetrahedral mesher took longer than {deadline:g} s and was stopped; take a larger size"
            ) from None
        finally:
            if child.poll() is None:
                child.kill()
                child.wait()
        errors.seek(0)
        said = errors.read().decode(errors="replace")
    if status == 0:
        return said
    raise MeshError(f"the tetrahedral mesher {_how_it_ended(status, said)}")


def _how_it_ended(status: int, said: str) -> str:
    if "MemoryError" in said or "bad_alloc" in said:
        return "ran out of the memory it may take; take a larger size"
    if status < 0 or status > 128:
        number = -status if status < 0 else status - 128
        try:
            name = signal.Signals(number).name
        except ValueError:
            name = f"signal {number}"
        if name == "SIGKILL":
            return "was killed from outside (SIGKILL): perhaps the machine ran out of memory"
        return f"crashed ({name}){_quoted(said)}"
    return f"failed with status {status}{_quoted(said)}"


def _quoted(said: str) -> str:
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return f": {lines[-1][:200]}" if lines else ""
