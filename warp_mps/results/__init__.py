"""Results of a run: summary, history, measurements, settings, energies; independent of the method."""
