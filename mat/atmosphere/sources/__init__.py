"""Sun and Moon: positions in the sky and spectral irradiance."""
