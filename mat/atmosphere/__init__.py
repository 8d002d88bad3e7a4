"""The atmosphere: state, gases, particles, Sun and Moon, radiative transfer, compiled bands, spectra."""
