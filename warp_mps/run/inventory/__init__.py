"""Inventory of a case: what its bodies, walls and fluids are once they are filled, told before anything runs."""
