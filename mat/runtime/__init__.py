"""What a runtime computes from the tables."""
