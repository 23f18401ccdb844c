"""Contact and friction between bodies and walls."""
