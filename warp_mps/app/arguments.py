"""Parsing of the command line; an error is reported in one line."""

from __future__ import annotations

import contextlib
import functools
import io
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import tyro
from tyro.conf import FlagCreatePairsOff, OmitArgPrefixes

from warp_mps.errors import InputError

# box-drawing characters around Tyro's messages
_FRAME = "\u2500\u2502\u256d\u256e\u2570\u256f"
_HINT = "Perhaps you meant: "
# Tyro's messages about values of another type: for one of several types, and for one
_UNFIT = re.compile(r"Error parsing (\S+): no type matching \{None\}\|\{?([A-Z ]+)\}? could .* from \[(.*)\]")
_NO_NUMBER = re.compile(r"Error parsing (\S+): (?:invalid literal for int|could not convert string).*?: '(.*)'")


def parse(commands: Mapping[str, Callable[..., int]], arguments: Sequence[str]) -> Callable[[], int]:
    """The command that is asked for, with its arguments.

    Args:
        commands: Functions by the name of their command.
        arguments: The command line.

    Raises:
        InputError: There is no such command or option, or a value is not allowed.
        SystemExit: Help was asked for, and printed.
    """
    _refuse_empty(arguments)
    text = io.StringIO()
    try:
        with contextlib.redirect_stderr(text):
            chosen: Any = tyro.extras.subcommand_cli_from_dict(
                {name: _bind_later(command) for name, command in commands.items()},
                prog="warp-mps",
                description="Elastic structures and water by the Moving Particle Semi-implicit method: USD in and out.",
                args=arguments,
                config=(OmitArgPrefixes, FlagCreatePairsOff),
            )
            return chosen
    except SystemExit as error:
        if not error.code:
            raise
        raise InputError("", "", _one_line(text.getvalue())) from None


def _refuse_empty(arguments: Sequence[str]) -> None:
    """Refuse arguments without text: a path would stand for the present folder.

    Raises:
        InputError: There is one, or one that is not UTF-8.
    """
    for before, argument in zip(["", *arguments], arguments, strict=False):
        option, equals, value = argument.partition("=")
        if not argument or (option.startswith("--") and equals and not value):
            named = option or (before if before.startswith("--") else "")
            raise InputError(named, "", "an argument is empty; give a value, such as . for the present folder")


def _bind_later(command: Callable[..., int]) -> Callable[..., Callable[[], int]]:
    """A function with the arguments of a command that returns the bound call instead of making it."""

    @functools.wraps(command)
    def bind(*arguments: Any, **options: Any) -> Callable[[], int]:
        return functools.partial(command, *arguments, **options)

    return bind


def _one_line(message: str) -> str:
    """The first sentence of a framed message, and the option that it suggests."""
    sections = [" ".join(part.split()) for part in _sections(message)]
    hints = [section.removeprefix(_HINT).split()[0] for section in sections if section.startswith(_HINT)]
    says = sections[0] if sections else "the command line cannot be understood"
    return "; ".join([_reworded(says).rstrip("."), *(f"did you mean {hint}?" for hint in hints), "see warp-mps --help"])


def _reworded(message: str) -> str:
    """A message about types, reworded as value and constraint."""
    if unfit := _UNFIT.match(message):
        option, kinds, given = unfit.group(1), unfit.group(2).split(), unfit.group(3)
        whole, count = "whole " * (kinds[0] == "INT"), len(kinds)
        wanted = f"a {whole}number" if count == 1 else f"{count} {whole}numbers"
        return f"{option}: is {given.replace(',', '')}, must be {wanted}"
    if number := _NO_NUMBER.match(message):
        whole = "whole " * ("for int" in message)
        return f"{number.group(1)}: is '{number.group(2)}', must be a {whole}number"
    return message


def _sections(message: str) -> list[str]:
    """The texts below the title of a frame, between its lines; each up to its first empty line."""
    lines = [line.strip(_FRAME + " ") for line in message.splitlines()]
    # ASCII terminals get dashes instead of box-drawing characters
    text = "\n".join("" if line.strip("-") == "" else line for line in lines).strip()
    return [part.strip() for part in re.split(r"\n\n+", text.partition("\n")[2]) if part.strip()]
