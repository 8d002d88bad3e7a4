"""Sun and Moon: where they stand and what they radiate."""
