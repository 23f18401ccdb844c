"""Results as USD animations, with what makes them look right when they are opened."""
