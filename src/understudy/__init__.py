"""Turns a recorded motion into a physically simulated performance."""
