"""Browser tests are skipped where there is no browser, but never unnoticed in CI."""

import pytest
from browser import Browser, find_browser


@pytest.fixture(autouse=True)
def no_browser(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))


def test_without_a_browser_there_is_none_to_test_with(monkeypatch):
    monkeypatch.delenv("CI", raising=False)
    assert find_browser() is None


def test_in_ci_a_missing_browser_fails(monkeypatch, tmp_path):
    monkeypatch.setenv("CI", "true")
    with pytest.raises(AssertionError, match="no browser found"):
        Browser(find_browser(), tmp_path)
