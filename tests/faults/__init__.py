"""Faults while a run is under way: nothing that was kept is lost, and it goes on to the same end."""
