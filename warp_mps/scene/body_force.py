"""A force per mass that depends on place and time, given as a function."""

from __future__ import annotations

import functools
import hashlib
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from types import CodeType
from typing import Any

import numpy as np

from warp_mps.scene.fields import attribute, described
from warp_mps.scene.record import Record


@described
@dataclass(frozen=True, kw_only=True, repr=False)
class BodyForce(Record):
    """A force per mass that depends on place and time, beside the scene's gravity.

    It is for scenes made in Python: a stage cannot hold a function. The function is one of

    - a Python function of arrays: positions x [m], shape [n, d], and the time t [s] to accelerations [m/s^2], shape
      [n, d]. It runs on the host: in every step positions are copied from the device and accelerations to it, and the
      steps of elastic bodies are no longer replayed as one graph;
    - a Warp function (``@wp.func``) of one position and the time to one acceleration, compiled into a kernel of its
      own. Its types are those of the run: ``wp.vec2d`` or ``wp.vec3d`` and ``wp.float64``, in single precision
      ``wp.vec2`` or ``wp.vec3`` and ``wp.float32``; with arguments annotated as ``Any`` it serves both.

    Fluids take the force that holds at the midpoint of a step, with another scheme than `conservative` at its
    beginning. Explicit steps of elastic bodies take it at both ends of a step, and implicit ones at the places to
    which the velocities at the step's beginning lead. Its work is part of the energies' `work`. Beside walls it is
    also evaluated at the places of their particles, for the pressure there.

    A run is resumed only with the same function: its code and the values that it encloses are compared, but not the
    global variables that it reads.
    """

    name: str = field(metadata=attribute(text="label"))
    """Name, unique in the scene."""
    acceleration: Callable = field(metadata=attribute(unit="m/s^2"))
    """The function, which gives the force per mass."""
    acts_on: tuple[str, ...] = ()
    """Names of the bodies and fluids that it acts on, all if empty. Fluids are one liquid: all or none."""
    path: str = ""
    """Where it was described, for error messages."""

    def __repr__(self) -> str:
        """The fields, with the function as `function_identity` tells it, which is the same in every process."""
        return f"BodyForce(name={self.name!r}, acceleration={self.identity}, acts_on={self.acts_on!r})"

    @property
    def identity(self) -> str:
        """Name of the function and a hash of what it computes."""
        return function_identity(self.acceleration)

    @property
    def is_warp_function(self) -> bool:
        """Whether the function is one of Warp, and not of Python."""
        warp = sys.modules.get("warp")
        return warp is not None and isinstance(self.acceleration, warp.Function)


def function_identity(function: Any) -> str:
    """Name of a function and a hash of its code, its defaults and the values that it encloses.

    Args:
        function: A Python function, a Warp function, a `functools.partial`, or an object that can be called.
    """
    digest = hashlib.sha256(_Description().of_function(function).encode()).hexdigest()
    return f"{function_name(function)}#{digest[:16]}"


def function_name(function: Any) -> str:
    """Name of a function without its module, which is another one where a script is run and where it is imported."""
    inner = getattr(function, "func", function)
    return str(getattr(inner, "__qualname__", type(inner).__qualname__))


class _Description:
    """Describes functions and values as text that does not depend on where they lie in memory."""

    def __init__(self) -> None:
        self._seen: set[int] = set()

    def of_function(self, function: Any) -> str:
        if id(function) in self._seen:  # a function may enclose itself
            return function_name(function)
        self._seen.add(id(function))
        if isinstance(function, functools.partial):
            return self.of_function(function.func) + self.of((function.args, function.keywords))
        function = getattr(function, "func", function)  # of a Warp function
        if hasattr(function, "__func__"):  # a method
            return self.of_function(function.__func__) + self.of(vars(function.__self__))
        if hasattr(function, "__code__"):
            cells = [cell.cell_contents for cell in function.__closure__ or ()]
            return self.of((function.__code__, function.__defaults__, function.__kwdefaults__, cells))
        call = type(function).__call__
        own = self.of_function(call) if hasattr(call, "__code__") else ""
        return function_name(function) + own + self.of(getattr(function, "__dict__", {}))

    def of(self, value: Any) -> str:
        if callable(value) and not isinstance(value, type):
            return self.of_function(value)
        if isinstance(value, CodeType):
            value = (value.co_code, value.co_names, value.co_consts)
        elif isinstance(value, dict):
            value = sorted(value.items(), key=repr)
        elif isinstance(value, set | frozenset):
            value = sorted(map(self.of, value))
        elif isinstance(value, np.ndarray | np.generic):
            value = (str(value.dtype), value.shape, value.tobytes())
        elif type(value).__repr__ is object.__repr__:
            value = (type(value).__qualname__, *sorted(getattr(value, "__dict__", {}).items()))
        return f"({', '.join(map(self.of, value))})" if isinstance(value, list | tuple) else repr(value)
