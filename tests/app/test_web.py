"""The web page: whole, with the handles that browser tests use, and examples that work."""

import re
from pathlib import Path

import pytest

import app

WEB = Path(app.__file__).parent / "web"
HANDLES = (
    "open-model", "example-select", "viewer", "csg-tree", "segment-row", "segment-type", "explanation", "mesh-size",
    "mesh-button", "job-progress", "quality-summary", "download-deck", "deck-format",
    "mesh-order", "mesh-volumes", "mesh-units", "mesh-material", "viewer-hint",
)  # fmt: skip
EXAMPLES = re.findall(r'"([^"]+)": \["([^"]+)", `([^`]+)`\]', (WEB / "examples.js").read_text())
TYPES = {
    "Table": ["plate", "beam", "beam", "beam", "beam"],
    "Plate with holes": ["plate"],
    "I-beam": ["beam"],
    "Pipe with a hole": ["cylinder_plate"],
    "Bracket": ["plate", "plate", "plate"],
}


def test_the_page_is_served_with_everything_that_it_asks_for(client):
    page = client.get("/")
    assert page.status_code == 200 and page.headers["content-type"].startswith("text/html")
    assert client.head("/").status_code == 200
    assert client.get("/favicon.ico").status_code == 200
    linked = re.findall(r'(?:src|href)="(/web/[^"]+)"', page.text)
    imported = re.findall(r'from "(/web/[^"]+)"', client.get("/web/app.js").text)
    assert linked and imported
    for path in linked + imported:
        assert client.get(path).status_code == 200, path


def test_the_operations_are_listed_without_another_server(client):
    page = client.get("/docs")
    assert page.status_code == 200 and client.head("/docs").status_code == 200
    assert "//" not in page.text
    for path in re.findall(r'(?:src|href)="(/[^"]+)"', page.text):
        assert client.get(path).status_code == 200, path
    assert client.get("/redoc").status_code == 404


def test_nothing_comes_from_another_server():
    for path in WEB.iterdir():
        foreign = [url for url in re.findall(r"https?://[^\s\"'`<]+", path.read_text()) if "w3.org" not in url]
        assert foreign == [], path.name


@pytest.mark.parametrize("handle", HANDLES)
def test_browser_tests_find_their_handles(handle):
    page, script = (WEB / "index.html").read_text(), (WEB / "app.js").read_text()
    assert f'data-testid="{handle}"' in page or f'"{handle}"' in script


def test_every_example_is_listed():
    assert [name for name, _, _ in EXAMPLES] == list(TYPES)


@pytest.mark.parametrize("name, file, text", EXAMPLES, ids=[name for name, _, _ in EXAMPLES])
def test_an_example_becomes_the_segments_that_its_name_promises(client, name, file, text):
    sent = client.post(f"/v1/models?name={file}", content=text, headers={"Content-Type": "text/plain"})
    answer = client.get(f"{sent.headers['location']}/segments").json()
    assert [segment["type"] for segment in answer["segments"]] == TYPES[name]
