"""Fixtures of the segmentation tests."""

from __future__ import annotations

import pytest
from segmenting import plain_decide

from rules.engine import load_rule_base


@pytest.fixture(scope="session", params=["plain", "rule base"])
def decide(request):
    """The plain stand-in, and the rule base that comes with csgmesh."""
    return plain_decide if request.param == "plain" else load_rule_base().decide
