"""A PostgreSQL server of the test run's own, in a temporary folder, reached over a socket there."""

import os
import pwd
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path

DEBIAN = Path("/usr/lib/postgresql")
"""Debian keeps the server's programs here, by version, out of PATH."""


def find_programs():
    """Folder of initdb and pg_ctl; where CI is set there has to be one, so that its tests fail there, not skipped."""
    found = shutil.which("initdb")
    if found and shutil.which("pg_ctl", path=Path(found).parent):
        return Path(found).parent
    folders = sorted(DEBIAN.glob("*/bin/initdb"), key=lambda path: int(path.parts[-3]))
    if folders:
        return folders[-1].parent
    return Path("/no/postgresql") if os.environ.get("CI") else None


@contextmanager
def serving(programs):
    """URL of a server that lives as long as the block. Root may not run one: then the user postgres does."""
    assert (programs / "initdb").exists(), "no PostgreSQL found, expected one: where CI is set its tests run"
    user = "postgres" if os.geteuid() == 0 else None
    folder = Path(tempfile.mkdtemp(prefix="csgmesh-postgres-"))
    try:
        if user is not None:
            account = pwd.getpwnam(user)
            os.chown(folder, account.pw_uid, account.pw_gid)

        def run(*command):
            done = subprocess.run(command, user=user, cwd=folder, capture_output=True, text=True, timeout=120)
            assert done.returncode == 0, done.stderr

        data = folder / "data"
        run(programs / "initdb", "-D", data, "-U", "csgmesh", "-A", "trust", "--no-sync", "-E", "UTF8", "--locale", "C")
        options = f"-c listen_addresses='' -c unix_socket_directories={folder} -c fsync=off"
        run(programs / "pg_ctl", "-D", data, "-l", folder / "log", "-o", options, "-w", "start")
        try:
            yield f"postgresql+psycopg://csgmesh@/postgres?host={folder}"
        finally:
            run(programs / "pg_ctl", "-D", data, "-m", "immediate", "stop")
    finally:
        shutil.rmtree(folder, ignore_errors=True)
