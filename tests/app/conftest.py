"""One service for all tests of the session, with a client that speaks to it."""

import dask_cluster
import postgres
import pytest
from fastapi.testclient import TestClient
from sqlalchemy import create_engine

from app.api.server import create_app
from app.settings import load_settings

BLOCK = "cube(size = [100, 60, 5], center = false);\n"


@pytest.fixture(scope="session")
def client(tmp_path_factory):
    settings = load_settings(data=str(tmp_path_factory.mktemp("data")), workers=1)
    with TestClient(create_app(settings), raise_server_exceptions=False) as client:
        yield client


@pytest.fixture
def block(client):
    """The id of a thin block, newly sent."""
    return client.post("/v1/models?name=block.csg", content=BLOCK, headers={"Content-Type": "text/plain"}).json()["id"]


@pytest.fixture(scope="session")
def server():
    """URL of a PostgreSQL server."""
    programs = postgres.find_programs()
    if programs is None:
        pytest.skip("PostgreSQL is a program of the system, not of Python")
    with postgres.serving(programs) as url:
        yield url


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request, tmp_path):
    """URL of a new, empty database."""
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path / 'state.db'}"
        return
    server = request.getfixturevalue("server")
    name = f"t{abs(hash(request.node.name)) % 10**12}"
    engine = create_engine(server, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql(f"DROP DATABASE IF EXISTS {name} WITH (FORCE)")
        connection.exec_driver_sql(f"CREATE DATABASE {name}")
    engine.dispose()
    yield server.replace("/postgres?", f"/{name}?")


@pytest.fixture(scope="session")
def cluster(tmp_path_factory):
    """Address of a dask scheduler with a worker."""
    pytest.importorskip("distributed")
    with dask_cluster.serving(tmp_path_factory.mktemp("cluster")) as address:
        yield address
