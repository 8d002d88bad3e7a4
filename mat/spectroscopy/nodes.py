"""The pressures, temperatures and water vapour fractions at which cross sections are tabulated."""

import numpy as np

# Pa; even steps of 0.35 in the logarithm where air is dense, wider where cross sections near their Doppler limit.
PRESSURE = 100.0 * np.array(
    [
        1e-5,
        1e-3,
        5e-3,
        0.02,
        0.06,
        0.15,
        0.35,
        0.75,
        1.5,
        2.8,
        5,
        9,
        15,
        25,
        40,
        60,
        90,
        130,
        185,
        260,
        365,
        510,
        700,
        900,
        1100,
    ]
)
TEMPERATURE = np.array([150.0, 174.0, 199.0, 225.0, 252.0, 281.0, 313.0, 350.0])  # K
H2O_FRACTION = np.array([0.0, 0.03, 0.08])  # mole fraction, for self broadening
HUMID_PRESSURE = 13  # first pressure (25 hPa) at which water vapour's own amount matters to its line widths
