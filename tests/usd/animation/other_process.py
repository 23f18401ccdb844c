"""Animations as a process other than their writer reads them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

READER = """
import sys
from pxr import Usd
stage = Usd.Stage.Open(sys.argv[1])
counts = set()
for prim in stage.GetDefaultPrim().GetChildren():
    points, velocities = prim.GetAttribute("points"), prim.GetAttribute("velocities")
    sizes = {len(a.Get(t)) for a in (points, velocities) for t in points.GetTimeSamples()}
    assert sizes == {len(prim.GetAttribute("ids").Get())}
    counts.add(points.GetNumTimeSamples())
assert stage.GetEndTimeCode() == points.GetTimeSamples()[-1]
print(*counts)
"""


def frames_seen_by_another_process(path: Path) -> int:
    """Number of complete frames of an animation, as another process reads it."""
    result = subprocess.run([sys.executable, "-c", READER, str(path)], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return int(result.stdout)
