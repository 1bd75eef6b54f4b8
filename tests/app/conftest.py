"""One service for all tests of the session, with a client that speaks to it."""

import pytest
from fastapi.testclient import TestClient

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
