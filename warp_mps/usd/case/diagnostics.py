"""What USD says of a stage that it cannot read, without the places and types of its own source."""

from __future__ import annotations

import re

# frames that USD reports: the place in its own source, then the message
_FRAME = re.compile(r"Error in '.*?' at line \d+ in file .*? : '(.*?)'(?=\s+Error in '|\s*$)", re.DOTALL)
# a message with its place in the stage: the file, the line and the column
_PLACED = re.compile(r"^.*?:(\d+):\d+: (.*)$", re.DOTALL)
# words of USD's parser that mean nothing to the writer of a stage
_GRAMMAR = re.compile(r"parse error matching .*?(?= at ')| \(at sub-part .*?\)")
_SESSION = re.compile(r",@anon:[^@]*@")


def reason_of(error: Exception) -> str:
    """The message among the frames that USD reports, with the line of the file for its path."""
    messages = [" ".join(found.split()) for found in _FRAME.findall(str(error))]
    placed = [found for found in map(_PLACED.match, messages) if found]
    if placed:
        line, text = placed[0].groups()
        return f"line {line}: {_plain(text)}"
    return _plain(messages[0]) if messages else "it is damaged"


def composition_error(error: object) -> str:
    """An error of composition in one line, without the layer that USD adds to every stage."""
    return _SESSION.sub("", " ".join(str(error).split()))


def _plain(text: str) -> str:
    text = _GRAMMAR.sub(lambda found: "cannot be parsed" if found[0].startswith("parse") else "", text)
    return text.strip() or "it is damaged"
