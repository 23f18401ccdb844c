"""The paper's elastic model: springs along and across pairs, and particle rotation."""
