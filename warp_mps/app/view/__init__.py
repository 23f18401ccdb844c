"""Pictures, videos and plots of a run."""
