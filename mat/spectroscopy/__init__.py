"""The band model of gas absorption: line-by-line spectra, continua, and the choice of spectral points."""
