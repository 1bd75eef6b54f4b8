"""Fixtures of the segmentation tests."""

from __future__ import annotations

import pytest
from segmenting import plain_decide


@pytest.fixture(scope="session")
def decide():
    """The plain stand-in for the rule base."""
    return plain_decide
