// What files of each type must hold, and how their axes are read.
const RESPONSE = ["material", "response_altitude", "response_slope", "response_hour"];
const OVERHEAD = ["altitude", "forcing_time"];
const PATH = ["range", "altitude", "elevation", "source_elevation", "source_azimuth"];
export const FORMATS = { htt: ["1."], band: ["1."], atmq: ["2.", "3."] };
// What a file must hold: axes, least and largest value of each array.
export const ARRAYS = {
  htt: { temperature: [["material", "altitude", "azimuth", "slope", "time"], 1, 1e4] },
  band: {
    blackbody_radiance: [["temperature"], 0, Infinity],
    reflectance: [["material"], 0, 1],
    specular_fraction: [["material"], 0, 1],
    shininess: [["material"], 0, Infinity],
    normalisation: [["material"], 0, Infinity],
  },
  atmq: {
    beta_star: [PATH.slice(0, 3), 1e-12, Infinity],
    path_radiance_ratio: [PATH, 0, Infinity],
    ambient_radiance: [PATH.slice(0, 4), 0, Infinity],
    direct_radiance: [PATH.slice(0, 4), 0, Infinity],
  },
};
// What an .htt that holds the first of them must hold, to shade surfaces.
export const SHADE = {
  response_kernel: [[...RESPONSE, "lag"], -Infinity, Infinity],
  response_temperature: [RESPONSE, 0, 1e4],
  heat_loss_slope: [RESPONSE, 1e-6, Infinity],
  heat_loss_excess: [[...RESPONSE, "temperature_offset"], -Infinity, Infinity],
  solar_absorptance: [["material"], 0, 1],
  thermal_emissivity: [["material"], 0, 1],
  melting_heat: [RESPONSE, 0, Infinity],
  highest_temperature: [["material"], 1, 1e4],
  direct_normal_irradiance: [OVERHEAD, 0, Infinity],
  diffuse_irradiance: [OVERHEAD, 0, Infinity],
  sky_irradiance: [OVERHEAD, 0, Infinity],
  air_temperature: [OVERHEAD, 1, 1e4],
  solar_elevation: [["forcing_time"], -90, 90],
  solar_azimuth: [["forcing_time"], -360, 360],
  extraterrestrial_irradiance: [["forcing_time"], 1e-6, Infinity],
};
// Of an .htt that holds the first of them: films of water on surfaces, which last longer in the shade.
export const FILM = {
  film_heat_loss: [[...RESPONSE, "temperature_offset"], -Infinity, Infinity],
  film_evaporation: [[...RESPONSE, "temperature_offset"], -Infinity, Infinity],
  film_sunlight: [RESPONSE, -Infinity, Infinity],
  absorbed_sunlight: [RESPONSE, 0, Infinity],
  film_capacity: [["material"], 0, Infinity],
  rain: [["forcing_time"], 0, Infinity],
};
// Of an .htt whose day does not repeat.
export const FILM_BEFORE = { film_before: [RESPONSE.slice(0, 3), 0, Infinity] };
// Of an .htt that holds the first of them: where Sun and Moon stand.
export const TRACKS = {
  sun_elevation: [["track_time"], -90, 90],
  sun_azimuth: [["track_time"], -1080, 1080],
  sun_distance: [["track_time"], 0.9, 1.1],
  moon_elevation: [["track_time"], -90, 90],
  moon_azimuth: [["track_time"], -1080, 1080],
  moon_distance: [["track_time"], 3e5, 4.5e5],
  moon_phase_angle: [["track_time"], 0, 180],
  moon_illuminated_fraction: [["track_time"], 0, 1],
};
// Of an .atmq file that has them: coefficients of the light around faces of any direction.
export const [LIGHT, GLOW] = ["ambient_radiance_harmonics", "ground_radiance_harmonics"];
export const HARMONICS = {
  [LIGHT]: [[...PATH.slice(0, 4), "harmonic"], -Infinity, Infinity],
  [GLOW]: [[...PATH.slice(0, 3), "ground_temperature", "zonal_harmonic"], -Infinity, Infinity],
};
// Of an .atmq that holds the first of them: its quantities without the source.
export const NIGHT = {
  thermal_path_radiance_ratio: [PATH.slice(0, 3), 0, Infinity],
  thermal_ambient_radiance: [PATH.slice(0, 3), 0, Infinity],
};
export const NIGHT_HARMONICS = { thermal_radiance_harmonics: [[...PATH.slice(0, 3), "harmonic"], -Infinity, Infinity] };
export const WITHOUT_SOURCE = {
  path_radiance_ratio: "thermal_path_radiance_ratio",
  ambient_radiance: "thermal_ambient_radiance",
  direct_radiance: "",
  [LIGHT]: "thermal_radiance_harmonics",
};
export const CIVIL_TWILIGHT = -6; // degree: a table whose lowest source elevation is above says nothing of twilight
// Codes 10 l + m of the harmonics, and of those without azimuth; a file has as many as suit its l.
export const CODES = { harmonic: [0, 10, 11, 20, 21, 22, 40, 41, 42, 43, 44], zonal_harmonic: [0, 10, 20, 40] };
export const COUNTS = { harmonic: [6, 11], zonal_harmonic: [3, 4] };
export const GROUND = ["ground_emissivity", "ground_temperature", "ground_radiance"];
// Of an .atmq of format 3: what transmittance, path radiance and light on surfaces are computed from.
const NODES = ["share", "height_root", "direction"];
export const CHANNELS = {
  effective_radius: [["height_root"], 1e-3, Infinity],
  log_mean_extinction: [["absorber", ...NODES], -200, 200],
  absorber_factor: [["channel", "absorber"], -Infinity, Infinity],
  channel_weight: [["channel"], 0, 1.00001],
  thermal_reference: [["channel"], 0, Infinity],
  thermal_ratio: [NODES, 0, Infinity],
  source_reference: [["channel"], 0, Infinity],
  scattered_ratio: [["source_part", ...NODES], 0, Infinity],
  source_factor: [["source_part", "source_elevation", "scattering_angle"], -Infinity, Infinity],
  source_rise: [["target_height"], -90, 90],
  direct_light: [["direct_light_part", "target_height", "elevation_above_rise"], -Infinity, Infinity],
  direct_light_factor: [["channel", "direct_light_part"], -Infinity, Infinity],
  thermal_sky: [["thermal_sky_part", "surface_height"], -Infinity, Infinity],
  thermal_sky_factor: [["channel", "thermal_sky_part"], -Infinity, Infinity],
  scattered_sky: [["scattered_sky_part", "surface_height", "sky_source_elevation"], -Infinity, Infinity],
  scattered_sky_factor: [["channel", "scattered_sky_part"], -Infinity, Infinity],
};
// Of one that holds any of them.
export const CHANNEL_HARMONICS = {
  thermal_harmonics: [["thermal_harmonics_part", "surface_height", "harmonic"], -Infinity, Infinity],
  thermal_harmonics_factor: [["channel", "thermal_harmonics_part"], -Infinity, Infinity],
  scattered_harmonics: [["scattered_harmonics_part", "surface_height", "sky_source_elevation", "harmonic"], -Infinity, Infinity],
  scattered_harmonics_factor: [["channel", "scattered_harmonics_part"], -Infinity, Infinity],
  ground_harmonics: [["ground_harmonics_part", "surface_height", "zonal_harmonic"], -Infinity, Infinity],
  ground_harmonics_factor: [["channel", "ground_harmonics_part"], -Infinity, Infinity],
  ground_emission: [["ground_temperature", "channel"], 0, Infinity],
};
// Of one whose paths refraction bends far: height of their ends above those of straight lines, over the range.
export const CHANNEL_BENDING = { end_rise: [["share", "height_root", "direction"], -1, 1] };
// Of one that holds either of them, and of a .band that does: what light is parted with at the wavelengths of the band.
export const CHANNEL_SHARES = {
  thermal_wavelength_share: [["channel", "band_wavelength"], 0, 1.00001],
  source_wavelength_share: [["channel", "band_wavelength"], 0, 1.00001],
};
export const SPECTRA = {
  reflectance_spectrum: [["material", "band_wavelength"], 0, 1],
  emission_share: [["planck_temperature", "band_wavelength"], 0, 1.00001],
};
export const SHARES = [...Object.keys(CHANNEL_SHARES), "emission_share"]; // their rows sum to 1
export const WAVELENGTH_ROUNDING = 1e-6; // relative: the files of one band have the same wavelengths
// What it must state: how many numbers, the least and the largest.
export const STATED = {
  ground_altitude_km: [1, -1, 10],
  scale_height_km: [1, 1e-12, 1000],
  range_km: [2, 0, 1e9],
  altitude_km: [2, -1, 1e9],
};
export const WEIGHT_ROUNDING = 1e-5; // of the sum of the channels' weights, and of a row of shares, which is 1
// Read at the nearest node outside, whatever the file says.
export const CLAMPED = [...NODES, "surface_height", "target_height", "elevation_above_rise", "planck_temperature"];
// Axes of codes and of numbers of parts.
const PARTS = Object.values({ ...CHANNELS, ...CHANNEL_HARMONICS }).map(([axes]) => axes[0]).filter((name) => name.endsWith("_part"));
const EXACT = new Set(["material", "channel", "absorber", ...PARTS]);
// How the format reads an axis: rules and period; others are linear and do not repeat.
export const RULES = {
  ...Object.fromEntries([...EXACT].map((name) => [name, [["exact"], 0]])),
  harmonic: [["exact"], 0],
  zonal_harmonic: [["exact"], 0],
  azimuth: [["linear_periodic"], 360],
  source_azimuth: [["linear_folded"], 360],
  time: [["linear_periodic", "linear"], 24],
  response_hour: [["linear_periodic"], 24],
  forcing_time: [["linear_periodic"], 24],
};
export const LAST_CODE = 65535;
