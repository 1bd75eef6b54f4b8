"""The process that runs pytetwild: started by tets.py with this file's path, never imported.

Arguments: memory in bytes, deadline in seconds, id of the process that started it. The working folder holds input.npz
and gets output.npz; a Python exception ends in exit status 3 with its text on stderr.
"""

from __future__ import annotations

import ctypes
import math
import os
import signal
import sys

_DIE_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of Linux's prctl."""


def limit(memory: int, deadline: float, parent: int) -> None:
    """Bound this process's memory and processor time, and let it end with the process that started it."""
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
        if os.getppid() != parent:  # it had ended already: nobody would be told
            sys.exit(0)
    try:
        import resource
    except ImportError:  # Windows: the deadline alone guards
        return
    seconds = math.ceil(deadline) * 64 + 10  # processor time of all threads: only a last resort
    for kind, amount in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, seconds), (resource.RLIMIT_CORE, 0)):
        _, hard = resource.getrlimit(kind)
        resource.setrlimit(kind, (amount if hard == resource.RLIM_INFINITY else min(amount, hard), hard))


def leave_pyvista_out() -> None:
    """Let pytetwild 0.4 import where pyvista is not installed.

    Its metadata calls pyvista optional, but its package imports it to register an accessor; an empty module has no
    registry, which pytetwild takes as a version without accessors.
    """
    from importlib.util import find_spec
    from types import ModuleType

    if find_spec("pyvista") is None:
        sys.modules["pyvista"] = ModuleType("pyvista")


def main() -> None:
    """Read, mesh, write."""
    leave_pyvista_out()
    limit(int(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3]))
    import numpy as np
    from pytetwild.pytetwild import tetrahedralize

    with np.load("input.npz") as given:
        vertices, triangles, numbers = given["vertices"], given["triangles"], given["numbers"]
    size, epsilon = float(numbers[0]), float(numbers[1])
    nodes, tets = tetrahedralize(
        vertices,
        triangles,
        edge_length_abs=size,
        epsilon=epsilon,
        optimize=True,
        quiet=True,
        vtk_ordering=True,
    )
    np.savez("output.npz", nodes=np.asarray(nodes, np.float64), tets=np.asarray(tets, np.int64))


if __name__ == "__main__":
    try:
        main()
    except Exception as error:  # noqa: BLE001  whatever it is, the parent tells it
        sys.stderr.write(f"{type(error).__name__}: {error}\n")
        sys.exit(3)
