"""The command line, the pictures, plots and reports of results, conversion, and benchmarks."""
