"""Elastic bodies: the models, contact, loads, supports and the clockwork of a step. Knows no file."""
