"""Air and bent rays of the reference spectra of the limb that `test_limb_line_by_line` cites."""

import numpy as np

# Altitude km, pressure hPa, temperature K, water vapour ppm: the mid-latitude air of the reference.
AIR = """
3 702.227 268.30 3845;4 617.614 263.24 2770;5 541.644 256.55 1897;6 473.437 250.20 1272;7 412.288 242.82 827
8 357.603 236.17 539;9 308.960 229.87 346.9;10 265.994 225.04 157.9;11 228.348 221.19 31.34;12 195.619 218.85 13.41
13 167.351 217.19 6.764;14 143.039 216.20 4.498;15 122.198 215.68 3.703;16 104.369 215.42 3.724;17 89.141 215.55 3.899
18 76.1528 215.92 4.002;19 65.0804 216.40 4.122;20 55.641 216.93 4.277;21 47.591 217.45 4.438;22 40.7233 218.00 4.558
23 34.8637 218.68 4.673;24 29.8633 219.39 4.763;25 25.5956 220.25 4.809;26 21.9534 221.30 4.856;27 18.8445 222.41 4.936
28 16.1909 223.88 5.021;29 13.9258 225.42 5.114;30 11.9913 227.20 5.222;31 10.340 229.52 5.331;32 8.92988 231.89 5.414
33 7.72454 234.51 5.488;34 6.6924 236.85 5.563;35 5.80701 239.42 5.633;36 5.04654 241.94 5.704;37 4.39238 244.57 5.767
38 3.82902 247.36 5.819;39 3.34337 250.32 5.872;40 2.92413 253.34 5.914;42 2.2464 258.27 5.984;44 1.73384 262.03 6.044
46 1.34242 264.20 6.104;48 1.04086 264.67 6.167;50 0.806832 263.24 6.208;52 0.624101 260.02 6.212
54 0.480974 255.63 6.158;55 0.421507 253.28 6.114;57 0.322408 247.81 6.018;60 0.213465 240.38 5.582
65 0.104568 229.53 4.886;70 0.0496902 220.33 4.242;75 0.0229699 212.52 3.491;80 0.0103181 204.11 2.252
"""
CARBON_DIOXIDE, NITROGEN = 368.32e-6, 0.78084
TOP = 80e3  # m, of the air
EARTH = 6367.421e3  # m, as the reference has it
REFRACTIVITY = 77.6e-6 / 100  # K Pa^-1
C1, C2 = 1.191042972e-8, 1.438776877  # W m^-2 sr^-1 (cm^-1)^-4 and cm K (CODATA 2018)


def air(altitude):
    """Pressure [Pa], temperature [K] and water vapour at altitudes [m]."""
    rows = np.array([[float(v) for v in row.split()] for row in AIR.replace("\n", ";").split(";") if row.strip()])
    z = 1e3 * rows[:, 0]
    pressure = np.exp(np.interp(altitude, z, np.log(100 * rows[:, 1])))
    water = np.exp(np.interp(altitude, z, np.log(1e-6 * rows[:, 3])))
    return pressure, np.interp(altitude, z, rows[:, 2]), water


def radius_times_index(altitude):
    pressure, temperature, _ = air(altitude)
    return (EARTH + altitude) * (1 + REFRACTIVITY * pressure / temperature)


def shells(tangent):
    """Middles and lengths of half the ray [m] through shells above its lowest point, and that point's altitude."""
    impact = EARTH + 1e3 * tangent
    fine = np.linspace(3e3, TOP, 77_001)
    lowest = np.interp(impact, radius_times_index(fine), fine)
    edges = np.unique(
        np.concatenate(
            [
                lowest + np.array([0, 0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 6, 8]) * 1e3,
                np.arange(lowest + 10e3, TOP, 3e3),
            ]
        )
    )
    length = np.sqrt(np.maximum(radius_times_index(edges) ** 2 - impact**2, 0.0))
    middle = 0.5 * (edges[1:] + edges[:-1])
    index = radius_times_index(middle) / (EARTH + middle)
    return middle, np.diff(length) / index, lowest


def emerging(depths, planck):
    """Radiance at the observer of shells of one half of a ray, counted from the lowest point: depth and Planck radiance
    (N, ...) of each.
    """
    total = passed = 0.0
    for number in [*range(len(depths) - 1, -1, -1), *range(len(depths))]:  # inwards to the lowest point, then outwards
        total = total + planck[number] * np.exp(-passed) * -np.expm1(-depths[number])
        passed = passed + depths[number]
    return total
