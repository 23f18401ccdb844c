"""Water and elastic bodies in one step: each feels the other within it."""
