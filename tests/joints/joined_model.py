"""A model of the catalogue, and what is to become of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Joined:
    """text: the model. kinds: of its joints, each once, in alphabetical order. types: of its segments, likewise.

    overrides: by node path. size: of the elements.
    """

    text: str
    kinds: str
    types: str
    overrides: Mapping[str, str] = field(default_factory=dict)
    size: float = 20.0
