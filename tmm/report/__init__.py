"""Scores and previews of texture databases, and the sheets of questions."""
