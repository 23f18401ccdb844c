"""Faults during a run: nothing that was saved is lost, and the run resumes to the same results."""
