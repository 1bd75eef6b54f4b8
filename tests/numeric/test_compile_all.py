"""Compiling ahead covers every kernel, once; a cache never outlives an edit; without numba's JIT all still runs."""

from __future__ import annotations

import importlib
import os
import pkgutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kernel.numeric
from kernel.numeric import compiled as compiled_module
from kernel.numeric.compile_all import compile_all
from kernel.numeric.compiled import compiled

ROOT = Path(__file__).parents[2]
SIGNATURES = """
import importlib, pkgutil, kernel.mesh, kernel.numeric
from kernel.numeric.compile_all import compile_all
compile_all()
names = [f"kernel.{part}.{found.name}" for part, package in (("numeric", kernel.numeric), ("mesh", kernel.mesh))
         for found in pkgutil.iter_modules(package.__path__)]
for name in names:
    module = importlib.import_module(name)
    for key, found in vars(module).items():
        if hasattr(found, "signatures"):
            called = name.startswith("kernel.mesh")
            print(name, key, len(found.signatures), sum(found.stats.cache_misses.values()), called)
"""


def run(code: str, **environment: str) -> str:
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env={**os.environ, **environment}, cwd=ROOT, check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip


def test_compiling_ahead_leaves_nothing_to_compile() -> None:
    compile_all()  # fills the cache
    lines = [line.split() for line in run(SIGNATURES).splitlines()]
    assert len(lines) > 60
    assert [line for line in lines if line[4] == "True" and line[2] != "1"] == []
    assert [line for line in lines if int(line[2]) > 1] == []
    assert [line for line in lines if int(line[3]) > 0] == []


def test_who_asks_hears_once_that_kernels_are_compiled_and_not_that_they_are_read(tmp_path: Path) -> None:
    code = """
from kernel.numeric.notice import when_compiling
when_compiling(lambda: print("compiling"))
from kernel.numeric.compiled import compiled
@compiled
def twice(x): return 2 * x
@compiled
def half(x): return x / 2
print(twice(1), half(1.0))
"""
    script = tmp_path / "kernels.py"
    script.write_text(code)
    command = f"import sys, runpy; sys.path.insert(0, {str(ROOT)!r}); runpy.run_path({str(script)!r})"
    assert run(command, NUMBA_CACHE_DIR=str(tmp_path)) == "compiling\n2 0.5\n"
    assert run(command, NUMBA_CACHE_DIR=str(tmp_path)) == "2 0.5\n"


def test_every_file_of_kernels_says_what_it_does() -> None:
    for found in pkgutil.iter_modules(kernel.numeric.__path__):
        assert importlib.import_module(f"kernel.numeric.{found.name}").__doc__


def test_an_edit_in_any_kernel_makes_every_cache_stale() -> None:
    stamp = compiled_module._package_stamp()
    assert {"predicates.py", "triangulation.py"} <= {name for name, _, _ in stamp}

    @compiled
    def twice(x):
        return 2 * x

    assert twice._cache._cache_file._source_stamp == compiled_module._STAMP


def test_kernels_work_where_no_cache_can_be_written(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = compiled_module.numba.njit

    def refuse(**options: bool):
        def decorate(function):
            if options.get("cache"):
                raise RuntimeError("cannot cache function: no locator available")
            return plain(**options)(function)

        return decorate

    monkeypatch.setattr(compiled_module.numba, "njit", refuse)
    assert compiled(lambda x: x + 1)(2) == 3


def test_the_interpreted_kernels_give_the_same_mesh() -> None:
    code = """
import sys
sys.path.insert(0, "tests/mesh")
from planar_regions import hole, rectangle, region
from kernel.mesh.planar import mesh_region
plane = region([rectangle(12, 8, 1), hole(6, 4, 1.5, 1)], (1,))
for faces in ("quad", "tri"):
    mesh = mesh_region(plane, 1.0, faces)
    print(mesh.points.round(9).tolist(), mesh.quads.tolist(), mesh.triangles.tolist())
"""
    assert run(code, NUMBA_DISABLE_JIT="1") == run(code)


def test_two_threads_mesh_at_once() -> None:
    from concurrent.futures import ThreadPoolExecutor

    from kernel.mesh.planar import mesh_region
    from kernel.mesh.region import Region

    t = 2 * np.pi * np.arange(64) / 64
    disc = Region(
        np.column_stack([np.cos(t), np.sin(t)]),
        np.column_stack([np.arange(64), (np.arange(64) + 1) % 64]),
        np.ones(64, bool),
        np.ones(64, bool),
    )
    with ThreadPoolExecutor(2) as pool:
        meshes = list(pool.map(lambda _: mesh_region(disc, 0.1), range(8)))
    assert len({mesh.points.tobytes() for mesh in meshes}) == 1
