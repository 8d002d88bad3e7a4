"""The documentation site: pages of the checkout, references made from schemas, commands and docstrings."""
