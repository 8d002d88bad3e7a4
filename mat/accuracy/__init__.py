"""How wrong the tables are, measured."""
