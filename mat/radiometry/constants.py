"""Physical constants and units that several folders use; `scipy.constants` has the same, but takes 0.1 s to import.

References
----------
BIPM 2019, The International System of Units, 9th edition: h, c, k, N_A, standard gravity and the atmosphere are exact;
ITS-90 for 0 degree Celsius. The millimetre of mercury is that of 760 to the atmosphere, as the torr.
"""

from __future__ import annotations

import math

PLANCK = 6.62607015e-34  # J s
LIGHT_SPEED = 299792458.0  # m s^-1
BOLTZMANN = 1.380649e-23  # J K^-1
AVOGADRO = 6.02214076e23  # mol^-1
GAS_CONSTANT = AVOGADRO * BOLTZMANN  # J mol^-1 K^-1
STEFAN_BOLTZMANN = 2 * math.pi**5 * BOLTZMANN**4 / (15 * PLANCK**3 * LIGHT_SPEED**2)  # W m^-2 K^-4
STANDARD_GRAVITY = 9.80665  # m s^-2
ZERO_CELSIUS = 273.15  # K
STANDARD_ATMOSPHERE = 101325.0  # Pa
MMHG = STANDARD_ATMOSPHERE / 760  # Pa
FOOT = 0.3048  # m

# First radiation constant of radiance, 2 h c^2. Wavenumber in cm^-1: the factor 1e8 turns (cm^-1)^3 per m^-1 into m^-3
# per cm^-1 (1e6 * 1e2). Wavelength in um: um^-5 to m^-5 is 1e30, per m to per um 1e-6.
C1_WAVENUMBER = 2.0 * PLANCK * LIGHT_SPEED**2 * 1e8  # W m^-2 sr^-1 (cm^-1)^-4
C1_WAVELENGTH = 2.0 * PLANCK * LIGHT_SPEED**2 * 1e24  # W m^-2 sr^-1 um^4
# Second radiation constant, h c / k.
C2_WAVENUMBER = PLANCK * LIGHT_SPEED / BOLTZMANN * 1e2  # cm K
C2_WAVELENGTH = PLANCK * LIGHT_SPEED / BOLTZMANN * 1e6  # um K
# The same cut after ten digits, as CODATA 2018 prints it. Line intensities, continua and the packaged absorption table
# are computed with it; the exact value would change their last digits.
C2 = 1.438776877  # cm K
