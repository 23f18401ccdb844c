"""Observers of a run: frames, probes, progress, guard and checkpoint, each one object with a trigger."""
