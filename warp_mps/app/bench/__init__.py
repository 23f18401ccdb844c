"""Benchmarks: the speed of solids, fluids and coupled cases."""
