"""The web page in a real browser: open, understand, override, mesh, download."""

import json
import re
import subprocess
import sys
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest
from browser import Browser, find_browser

from app.settings import load_settings
from app.store import Store
from app.tokens import create_token

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

pytestmark = pytest.mark.skipif(find_browser() is None, reason="Chromium is a program of the system, not of Python")


@pytest.fixture(scope="module")
def url(tmp_path_factory):
    with serving(str(tmp_path_factory.mktemp("data"))) as url:
        yield url


@contextmanager
def serving(data):
    command = [sys.executable, "-c", "from app.cli import main; main()", "serve", "--port", "0", "--data", data]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as service:
        yield re.search(r"http://[\d.:]+/", service.stderr.readline()).group()
        service.terminate()
        service.communicate(timeout=120)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = Browser(find_browser(), tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


@pytest.fixture
def page(browser, url):
    browser.open(url)
    browser.wait("document.querySelector('[data-testid=deck-format]').options.length > 0")
    yield browser
    assert browser.errors == []


def by(testid):
    return f"document.querySelector('[data-testid={testid}]')"


def choose(page, selector, value):
    page.run(f"(() => {{ const s = {selector}; s.value = {value!r}; s.dispatchEvent(new Event('change')); }})()")


def types(page):
    return page.run("[...document.querySelectorAll('[data-testid=segment-row]')].map(row => row.dataset.type)")


def open_example(page, name, count):
    choose(page, by("example-select"), name)
    page.wait(f"document.querySelectorAll('[data-testid=segment-row]').length === {count}")
    page.wait("!document.body.hasAttribute('aria-busy')")


# How many pixels of the viewer are not white.
DRAWN_PIXELS = (
    f"(() => {{ const gl = {by('viewer')}.getContext('webgl2'); const w = gl.drawingBufferWidth, "
    "h = gl.drawingBufferHeight, p = new Uint8Array(4 * w * h); "
    "gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p); "
    "let n = 0; for (let k = 0; k < p.length; k += 4) n += p[k] < 250 || p[k + 1] < 250; return n; })()"
)


def test_an_example_shows_its_tree_its_segments_and_itself(page):
    open_example(page, "Table", 5)
    assert types(page) == ["plate", "beam", "beam", "beam", "beam"]
    assert "TOP: block" in page.run(f"{by('csg-tree')}.innerText")
    page.wait(f"{DRAWN_PIXELS} > 10000")


def test_the_empty_viewer_says_what_to_do_until_a_model_is_open(page):
    hint = by("viewer-hint")
    assert "choose an example" in page.run(f"{hint}.innerText") and not page.run(f"{hint}.hidden")
    open_example(page, "Table", 5)
    assert page.run(f"{hint}.hidden")


def test_order_units_and_material_go_into_the_mesh(page, url):
    open_example(page, "Table", 5)
    page.run(f"{by('mesh-size')}.value = '100'")
    choose(page, by("mesh-order"), "2")
    choose(page, by("mesh-units"), "mm")
    page.run(f"{by('mesh-material')}.value = 'aluminium'")
    page.run(f"{by('mesh-button')}.click()")
    page.wait(f"!{by('mesh-button')}.disabled && {by('quality-summary')}.innerText.includes('quad8')")
    deck = urllib.request.urlopen(page.run(f"{by('download-deck')}.href")).read().decode()
    assert "mm-t-s-N" in deck and "aluminium" in deck.lower()


def test_a_segment_says_why_it_is_what_it_is(page):
    open_example(page, "Table", 5)
    page.run("document.querySelectorAll('[data-testid=segment-row]')[1].click()")
    said = page.run(f"{by('explanation')}.innerText")
    assert "beam" in said and "span 735" in said and "not brick" in said


def test_an_override_is_chosen_in_its_row_and_taken_back(page):
    open_example(page, "Table", 5)
    choose(page, "document.querySelectorAll('[data-testid=segment-type]')[1]", "brick")
    page.wait("document.querySelectorAll('[data-testid=segment-row]')[1].dataset.type === 'brick'")
    choose(page, "document.querySelectorAll('[data-testid=segment-type]')[1]", "auto")
    page.wait("document.querySelectorAll('[data-testid=segment-row]')[1].dataset.type === 'beam'")


def test_an_override_that_cannot_be_is_told_and_undone(page, tmp_path):
    (tmp_path / "ball.csg").write_text("BALL = SPH(R=10)\nOUT BALL\n")
    page.give_file("[data-testid=open-model]", tmp_path / "ball.csg")
    page.wait("document.querySelectorAll('[data-testid=segment-row]').length === 1")
    page.wait("!document.body.hasAttribute('aria-busy')")
    choose(page, by("segment-type"), "beam")
    page.wait("!document.getElementById('message').hidden")
    assert "beam" in page.run("document.getElementById('message').textContent")
    assert types(page) == ["brick"] and page.run(f"{by('segment-type')}.value") == "brick"


def test_a_mesh_is_made_shown_and_downloaded(page, url):
    open_example(page, "Bracket", 3)
    page.wait(f"{DRAWN_PIXELS} > 10000")
    before = page.run(DRAWN_PIXELS)
    page.run(f"{by('mesh-size')}.value = '8'")
    page.run(f"{by('mesh-button')}.click()")
    page.wait(f"{by('quality-summary')}.innerText.includes('quad4')")
    page.wait("document.querySelector('[data-view=mesh]').getAttribute('aria-selected') === 'true'")
    assert "1 component" in page.run(f"{by('quality-summary')}.innerText")
    page.wait(f"{DRAWN_PIXELS} !== {before}")
    for name, start in (("nastran", b"$"), ("gmsh", b"$MeshFormat")):
        choose(page, by("deck-format"), name)
        link = page.run(f"{by('download-deck')}.href")
        assert link.startswith(url) and urllib.request.urlopen(link, timeout=30).read().startswith(start)


def test_a_mesh_is_coloured_by_quality_with_a_legend(page):
    open_example(page, "Bracket", 3)
    assert page.run(f"{by('by-quality')}.parentElement.hidden")
    page.run(f"{by('mesh-size')}.value = '8'")
    page.run(f"{by('mesh-button')}.click()")
    page.wait(f"!{by('by-quality')}.parentElement.hidden")
    page.wait("!document.body.hasAttribute('aria-busy')")
    plain = page.run(f"{by('viewer')}.toDataURL()")
    page.run(f"{by('by-quality')}.click()")
    page.wait(f"{by('quality-legend')}.textContent.includes('scaled Jacobian from:  0.9')")
    page.wait(f"{by('viewer')}.toDataURL() !== {plain!r}")
    page.run(f"{by('by-quality')}.click()")
    page.wait(f"{by('viewer')}.toDataURL() === {plain!r}")
    assert page.run(f"{by('quality-legend')}.hidden")


def test_a_file_is_opened_and_a_wrong_one_is_refused_with_its_place(page, tmp_path):
    page.give_file("[data-testid=open-model]", EXAMPLES / "pipe.csg")
    page.wait("document.querySelectorAll('[data-testid=segment-row]').length === 1")
    assert types(page) == ["cylinder_plate"]
    (tmp_path / "bad.csg").write_text("kube();\n")
    page.give_file("[data-testid=open-model]", tmp_path / "bad.csg")
    page.wait("!document.getElementById('message').hidden")
    assert page.run("document.getElementById('message').textContent").startswith("bad.csg:1:1: ")


def test_a_reload_shows_the_same_model(page):
    open_example(page, "I-beam", 1)
    page.open(page.run("location.href"))
    page.wait("document.querySelectorAll('[data-testid=segment-row]').length === 1")
    assert types(page) == ["beam"]


def test_every_operation_is_listed_with_what_it_wants_and_gives(page, url):
    page.open(f"{url}docs")
    page.wait("document.querySelectorAll('#operations details').length > 0")
    described = json.load(urllib.request.urlopen(f"{url}openapi.json", timeout=30))
    count = sum(len(operations) for operations in described["paths"].values())
    assert page.run("document.querySelectorAll('#operations details').length") == count
    said = page.run("document.getElementById('operations').textContent")
    assert "POST /v1/models/{model_id}/meshes" in said and "target length of an element's edge" in said
    assert page.run("document.getElementById('message').hidden")


def test_a_service_with_tokens_asks_for_one_and_then_works(browser, tmp_path):
    store = Store(load_settings(data=str(tmp_path)).database)
    secret, _ = create_token(store, "anna")
    store.close()
    with serving(str(tmp_path)) as url:
        browser.open(url)
        browser.wait(f"{by('token-dialog')}.open")
        browser.run(f"{by('token')}.value = 'csgmesh_wrong'; {by('token-button')}.click()")
        browser.wait("!document.getElementById('token-message').hidden")
        browser.run(f"{by('token')}.value = {secret!r}; {by('token-button')}.click()")
        browser.wait(f"!{by('token-dialog')}.open")
        browser.wait(f"{by('deck-format')}.options.length > 0")
        open_example(browser, "Table", 5)
        browser.run(f"{by('mesh-button')}.click()")
        browser.wait(f"{by('quality-summary')}.innerText.includes('node')", 120)
        path = browser.run(f"{by('download-deck')}.getAttribute('href')")
        assert browser.run(f"fetch({path!r}).then(answer => answer.text())").startswith("$")
        browser.open(url)  # the cookie stays
        browser.wait(f"{by('deck-format')}.options.length > 0")
        assert not browser.run(f"{by('token-dialog')}.open")
    assert browser.errors == []


def write_rules(page, text):
    page.run(
        f"(() => {{ const e = {by('rules-editor')}; e.value = {text!r}; e.dispatchEvent(new Event('input')); }})()"
    )


def count_of(kind):
    return f"document.querySelectorAll('[data-testid=segment-row][data-type={kind}]').length"


def problems():
    return f"{by('rules-problems')}.innerText"


def test_rules_are_looked_at_as_they_are_written(page):
    page.wait(f"{problems()}.includes('nothing wrong')")
    write_rules(page, "name: house\nextends: base\nrules:\n  - id: x\n    when: [slendernes > 3]\n")
    page.wait(f"{problems()}.includes(\"did you mean 'slenderness'\")")
    assert "5:12" in page.run(problems())
    assert page.run(f"{by('rules-use')}.disabled")
    buttons = f"[...{by('rules-problems')}.querySelectorAll('button')]"
    page.run(f"{buttons}.find(button => button.innerText === '5:12').click()")
    chosen = page.run(f"(() => {{ const e = {by('rules-editor')}; return e.value.slice(e.selectionStart); }})()")
    assert chosen.startswith("slendernes > 3]")


def test_rules_show_what_they_would_change_and_then_decide(page):
    open_example(page, "Table", 5)
    page.wait(f"{problems()}.includes('nothing wrong')")
    write_rules(page, "name: house\nextends: base\nparameters:\n  beam_slenderness: {value: 16}\n")
    page.run(f"{by('rules-use')}.disabled = true")
    page.wait(f"!{by('rules-use')}.disabled")
    page.run(f"{by('rules-compare')}.click()")
    page.wait(f"{by('rules-diff')}.innerText.includes('differ from base')")
    told = page.run(f"{by('rules-diff')}.innerText")
    assert told.startswith("4 of 6 decisions in table.csg")
    assert "\n1\tbeam\tbrick\tthe-rest-is-brick" in told
    assert types(page) == ["plate", "beam", "beam", "beam", "beam"]
    page.run(f"{by('rules-test')}.click()")
    page.wait(f"{by('rules-diff')}.innerText.includes('cases hold')")
    page.run(f"{by('rules-use')}.click()")
    page.wait(f"{by('rules-in-use')}.innerText.startsWith('house ')")
    page.wait(f"{count_of('brick')} === 4")
    page.run(f"{by('rules-own')}.click()")
    page.wait(f"{by('rules-in-use')}.innerText.startsWith('base ')")
    page.wait(f"{count_of('beam')} === 4")
