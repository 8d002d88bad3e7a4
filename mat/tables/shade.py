"""Names of the arrays of light, longwave and air over surfaces, in a ``.htt`` database."""

FORCING_TIME = "forcing_time"
DIRECT, DIFFUSE, LONGWAVE, AIR = "direct_normal_irradiance", "diffuse_irradiance", "sky_irradiance", "air_temperature"
SUN_ELEVATION, SUN_AZIMUTH = "solar_elevation", "solar_azimuth"
ABSORPTANCE, EMISSIVITY = "solar_absorptance", "thermal_emissivity"
AUREOLE = "aureole_share"
LIGHT = (DIRECT, DIFFUSE, LONGWAVE, AIR, SUN_ELEVATION, SUN_AZIMUTH, AUREOLE, ABSORPTANCE, EMISSIVITY)
