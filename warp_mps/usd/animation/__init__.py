"""Results as USD animations, with camera, lights and materials."""
