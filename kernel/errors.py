"""Every error that csgmesh raises on purpose.

    CsgmeshError
     +- InputError            the input is wrong                          exit status 2, HTTP 422
     |   +- ReadError         the model's text: syntax, names, numbers
     |   +- GeometryError     the model's solid: empty, degenerate, open
     |   +- OverrideError     an override that names no node, or cannot be
     |   |   +- AmbiguousNameError  a name of several nodes
     |   +- RuleError         a rule file
     |   +- OptionError       an option, a format, a material, an output path
     +- CannotMeshError       the input is fine, this part cannot be done  exit status 3, HTTP 409
     |   +- MeshError         a segment that cannot be meshed
     |   +- ConnectError      a joint that cannot be connected
     |   +- CheckError        a model that does not pass its own checks
     |   +- DeckError         a model that a format cannot carry
     +- DefectError           an invariant of ours is broken              exit status 1, HTTP 500

A message says what is wrong, where, and what was expected; `str(error)` is one line, with the place first.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Place:
    """Where something stands in the input: file name ("-" for standard input), line and column from 1."""

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


class CsgmeshError(Exception):
    """Root of all errors that are raised on purpose."""

    exit_status = 1

    def __init__(self, message: str, *, place: Place | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.place = place

    def __str__(self) -> str:
        text = " ".join(self.message.split())
        return f"{self.place}: {text}" if self.place else text


class InputError(CsgmeshError):
    """The input is wrong; the user can mend it."""

    exit_status = 2


class ReadError(InputError):
    """The model's text cannot be read."""


class GeometryError(InputError):
    """The model reads well but describes no usable solid."""


class OverrideError(InputError):
    """An override names a node that does not exist, or a type that the node cannot be."""


class AmbiguousNameError(OverrideError):
    """A node's name that stands more than once where one node is meant."""


class RuleError(InputError):
    """A rule file is wrong."""


class OptionError(InputError):
    """An option is wrong: a format, a size, a material, a path."""


class CannotMeshError(CsgmeshError):
    """The input is fine, but this part of it cannot be done; the message names the segment."""

    exit_status = 3


class MeshError(CannotMeshError):
    """A segment cannot be meshed."""


class ConnectError(CannotMeshError):
    """A joint cannot be connected."""


class CheckError(CannotMeshError):
    """The model does not pass its own checks."""


class DeckError(CannotMeshError):
    """The model holds something that the format cannot carry."""


class DefectError(CsgmeshError):
    """An invariant of ours does not hold: a defect of csgmesh, not of the input."""

    exit_status = 1
