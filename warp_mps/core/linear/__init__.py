"""Preconditioned conjugate gradients on the device."""
