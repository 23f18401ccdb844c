"""Scenes read from USD stages and saved as such."""

from __future__ import annotations

from pathlib import Path

SCHEMA = Path(__file__).parent / "schema"


def register_schema() -> None:
    """Make the applied schemas of this package (`MpsBodyAPI` and so on) known to USD, so that tools show them.

    Reading does not need them. It may be called again; it must be called before anything else asks USD for a schema.
    """
    from pxr import Plug

    Plug.Registry().RegisterPlugins(str(SCHEMA))
