"""How good a classification is: confusion, calibration, texels held out."""
