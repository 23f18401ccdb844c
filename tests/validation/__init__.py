"""Runs compared with answers known from outside; the tolerances stand beside the figures."""
