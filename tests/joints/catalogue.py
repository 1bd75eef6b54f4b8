"""The catalogue: a small model for every way in which members meet, with the joints that it is to have."""

from __future__ import annotations

from catalogue_beams import BEAMS
from catalogue_bricks import BRICKS
from catalogue_careless import CARELESS
from catalogue_lines import LINES
from catalogue_pipes import PIPES
from catalogue_plates import PLATES
from catalogue_tubes import TUBES
from joined_model import Joined

__all__ = ["CATALOGUE", "Joined"]

CATALOGUE = {**PLATES, **BEAMS, **TUBES, **PIPES, **LINES, **BRICKS, **CARELESS}
