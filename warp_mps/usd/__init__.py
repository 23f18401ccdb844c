"""Scenes read from USD stages and saved as such."""

from __future__ import annotations

from pathlib import Path

from warp_mps.core.interrupts import defer_interrupts

# USD's modules discard an exception that a signal raises while they are imported, and are incomplete afterwards
with defer_interrupts():
    from pxr import Ar, Gf, Pcp, Plug, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade, UsdUtils, Vt  # noqa: F401

SCHEMA = Path(__file__).parent / "schema"


def register_schema() -> None:
    """Make the applied schemas of this package (`MpsBodyAPI` and so on) known to USD, so that tools show them.

    Reading does not need them. It may be called again; it must be called before anything else asks USD for a schema.
    """
    Plug.Registry().RegisterPlugins(str(SCHEMA))
