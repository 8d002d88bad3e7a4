"""Lines of small molecules from their published constants and band strengths."""
