"""A Griffe extension: the fields of a scene's classes as the table that their docstrings list when they are imported.

The meaning of a field stands below it and its unit, limits and name in a stage in its metadata; `described` makes the
section "Attributes" of the class of them (`warp_mps.scene.fields`), which is there only once the class exists.
"""

from __future__ import annotations

import inspect
from importlib import import_module
from typing import Any

import griffe


class Described(griffe.Extension):
    """Replaces the docstring of every class that is decorated with `described` by that of the imported class."""

    def on_class_members(self, *, cls: griffe.Class, **_: Any) -> None:
        """Take over the docstring, and leave out the fields that it lists."""
        if cls.docstring is None or "described" not in {str(decorator.value) for decorator in cls.decorators}:
            return
        cls.docstring.value = inspect.getdoc(getattr(import_module(cls.module.path), cls.name)) or ""
        for member in cls.members.values():
            if member.is_attribute and "property" not in member.labels:
                member.docstring = None
