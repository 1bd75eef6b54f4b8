"""The decorator of every kernel: numba, cached on disk, free of the interpreter's lock.

numba's cache looks at the time stamp of the file that holds a function, and not at the files of the functions that
it calls: after an edit in a callee an old machine code would run on. So every kernel's stamp here covers all files
of this package. Where no folder can be written, kernels are compiled in memory (set NUMBA_CACHE_DIR to one that can).

Each kernel is meant to be compiled for one signature: callers pass contiguous float64, int32 and uint8 arrays, and
every argument (a default argument would make a second signature).
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import event
from numba.np import linalg

from kernel.numeric.notice import compiling


def _import_array_functions() -> None:
    """numba's array functions, without the scipy.linalg that their import loads to see whether there is a BLAS.

    No kernel here needs one, and it takes 0.13 s of the first mesh's 1.3. Whatever else is compiled in this process
    finds the BLAS when it asks for it: the question is only left out once.
    """
    asked = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = asked


_import_array_functions()


class _Listener(event.Listener):  # type: ignore[misc]
    """numba's own event of compiling: not of what the cache holds."""

    def on_start(self, event: event.Event) -> None:
        del event
        compiling()

    def on_end(self, event: event.Event) -> None:
        del event


event.register("numba:compile", _Listener())


def _package_stamp() -> tuple[tuple[str, int, int], ...]:
    """Name, time of change and length of every file in this package."""
    files = sorted(Path(__file__).parent.glob("*.py"))
    return tuple((file.name, (stat := file.stat()).st_mtime_ns, stat.st_size) for file in files)


_STAMP = _package_stamp()


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """`function` as machine code, compiled at its first call or read from the cache."""
    try:
        kernel = numba.njit(nogil=True, cache=True)(function)
    except RuntimeError:  # numba's words: "no locator available": no folder for the cache
        return numba.njit(nogil=True)(function)
    cache_file = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if cache_file is not None:
        cache_file._source_stamp = _STAMP
    return kernel
