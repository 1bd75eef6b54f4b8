"""A dask cluster of the test run's own: a scheduler and one worker, in processes of their own."""

import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

SCRIPT = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


def environment():
    """The environment for processes that import what is tested here."""
    root = str(Path(__file__).resolve().parents[2])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH")]))}


@contextmanager
def serving(folder):
    """Address of a scheduler that lives as long as the block."""
    script = Path(folder) / "cluster.py"
    script.write_text(SCRIPT)
    command = [sys.executable, str(script)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment(), cwd=folder
    ) as cluster:
        yield cluster.stdout.readline().strip()
        cluster.communicate("", timeout=120)
