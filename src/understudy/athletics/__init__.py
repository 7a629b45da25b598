"""athletics."""
