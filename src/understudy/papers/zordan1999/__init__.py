"""Zordan & Hodgins 1999: its figures with simulations, run again."""
