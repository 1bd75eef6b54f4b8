"""A command line that cannot be parsed, in our own words: what is wrong, and what was expected."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from kernel.words import did_you_mean

EXPECTED = {"integer": "a whole number", "float": "a number", "number": "a number"}
"""By the word that the parser's message has for a type."""


def usage_message(error: Any, arguments: Sequence[str]) -> str:
    """One line for the parser's `error` (one of click's, whichever package brings them along)."""
    kind = type(error).__name__
    context = getattr(error, "ctx", None)
    command = None if context is None else context.command
    parameter = getattr(error, "param", None)
    if kind == "MissingParameter" and parameter is not None and context is not None:
        return f"{_shown(parameter)} is missing, expected {_usage(context)}"
    if kind == "BadParameter" and parameter is not None:
        given = _given(parameter, arguments)
        said = error.format_message().lower()
        wanted = next((expected for word, expected in EXPECTED.items() if word in said), None)
        if given is not None and wanted is not None:
            return f"{_option(parameter)}: {given!r} is wrong, expected {wanted}"
    if kind == "NoSuchOption" and command is not None:
        known = [name for known in command.params for name in known.opts]
        return f"unknown option {error.option_name}, expected {_usage(context)}{did_you_mean(error.option_name, known)}"
    unknown = next((word for word in arguments if word in error.format_message()), None)
    if command is not None and hasattr(command, "commands") and unknown is not None:
        names = list(command.commands)
        return f"unknown command {unknown!r}, expected one of {', '.join(names)}{did_you_mean(unknown, names)}"
    message: str = error.format_message()
    return message if context is None else f"{message.rstrip('.')}, expected {_usage(context)}"


def _usage(context: Any) -> str:
    """`csgmesh mesh MODEL -o DECK [OPTIONS]`."""
    needed = [_shown(parameter) for parameter in context.command.params if parameter.required]
    return f"{' '.join([context.command_path, *needed, '[OPTIONS]'])} (more by {context.command_path} --help)"


def _shown(parameter: Any) -> str:
    """An argument by its name, an option with the name of its value."""
    if not parameter.opts or not parameter.opts[0].startswith("-"):
        return str(parameter.metavar or parameter.human_readable_name)
    shortest = min(parameter.opts, key=len)
    return f"{shortest} {parameter.metavar}" if parameter.metavar else shortest


def _option(parameter: Any) -> str:
    return str(max(parameter.opts, key=len)) if parameter.opts else str(parameter.human_readable_name)


def _given(parameter: Any, arguments: Sequence[str]) -> str | None:
    """The value that the command line gives an option."""
    for index, argument in enumerate(arguments):
        name, equals, value = argument.partition("=")
        if name in parameter.opts:
            return value if equals else next(iter(arguments[index + 1 : index + 2]), None)
    return None
