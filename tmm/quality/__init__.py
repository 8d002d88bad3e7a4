"""Quality of a classification: confusion, calibration, held-out texels."""
