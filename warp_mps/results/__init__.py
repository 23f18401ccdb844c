"""What a run leaves behind: summary, history, measurements, settings, energies. Knows no method."""
