"""Runs: the simulation of a scene on a device, its schedule, its folder, and what it costs."""
