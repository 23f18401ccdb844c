"""Cases as USD stages: read, checked and saved."""
