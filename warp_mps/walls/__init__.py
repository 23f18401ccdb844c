"""Rigid walls: where their prescribed motions have them at a time, and where that puts their particles."""
