"""Classifiers of texels: Gaussian maximum likelihood, trained models, box averages, calibrated confidence."""
