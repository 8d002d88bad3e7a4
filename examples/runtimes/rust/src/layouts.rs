//! What files of each type must hold, and how their axes are read.

/// What a file must hold: axes, least and largest value of each array.
pub type Layout = (&'static str, &'static [&'static str], f32, f32);
pub const PATH: &[&str] = &["range", "altitude", "elevation", "source_elevation", "source_azimuth"];
pub const SURFACE: &[Layout] = &[("temperature", &["material", "altitude", "azimuth", "slope", "time"], 1.0, 1e4)];
pub const RESPONSE: &[&str] = &["material", "response_altitude", "response_slope", "response_hour", "lag"];
pub const EXCESS: &[&str] = &["material", "response_altitude", "response_slope", "response_hour", "temperature_offset"];
pub const OVERHEAD: &[&str] = &["altitude", "forcing_time"];
/// What an .htt that holds the first of them must hold, to shade surfaces.
pub const SHADE: &[Layout] = &[
    ("response_kernel", RESPONSE, f32::MIN, f32::MAX),
    ("response_temperature", RESPONSE.split_at(4).0, 0.0, 1e4),
    ("heat_loss_slope", RESPONSE.split_at(4).0, 1e-6, f32::MAX),
    ("heat_loss_excess", EXCESS, f32::MIN, f32::MAX),
    ("solar_absorptance", &["material"], 0.0, 1.0),
    ("thermal_emissivity", &["material"], 0.0, 1.0),
    ("melting_heat", RESPONSE.split_at(4).0, 0.0, f32::MAX),
    ("highest_temperature", &["material"], 1.0, 1e4),
    ("direct_normal_irradiance", OVERHEAD, 0.0, f32::MAX),
    ("diffuse_irradiance", OVERHEAD, 0.0, f32::MAX),
    ("sky_irradiance", OVERHEAD, 0.0, f32::MAX),
    ("air_temperature", OVERHEAD, 1.0, 1e4),
    ("solar_elevation", &["forcing_time"], -90.0, 90.0),
    ("solar_azimuth", &["forcing_time"], -360.0, 360.0),
    ("extraterrestrial_irradiance", &["forcing_time"], 1e-6, f32::MAX),
];
/// Of an .htt that holds the first of them: films of water on surfaces, which last longer in the shade.
pub const FILM: &[Layout] = &[
    ("film_heat_loss", EXCESS, f32::MIN, f32::MAX),
    ("film_evaporation", EXCESS, f32::MIN, f32::MAX),
    ("film_sunlight", RESPONSE.split_at(4).0, f32::MIN, f32::MAX),
    ("absorbed_sunlight", RESPONSE.split_at(4).0, 0.0, f32::MAX),
    ("film_capacity", &["material"], 0.0, f32::MAX),
    ("rain", &["forcing_time"], 0.0, f32::MAX),
];
/// Of an .htt whose day does not repeat.
pub const FILM_BEFORE: &[Layout] = &[("film_before", RESPONSE.split_at(3).0, 0.0, f32::MAX)];
/// Of an .htt that holds the first of them: where Sun and Moon stand.
pub const TRACKS: &[Layout] = &[
    ("sun_elevation", &["track_time"], -90.0, 90.0),
    ("sun_azimuth", &["track_time"], -1080.0, 1080.0),
    ("sun_distance", &["track_time"], 0.9, 1.1),
    ("moon_elevation", &["track_time"], -90.0, 90.0),
    ("moon_azimuth", &["track_time"], -1080.0, 1080.0),
    ("moon_distance", &["track_time"], 3e5, 4.5e5),
    ("moon_phase_angle", &["track_time"], 0.0, 180.0),
    ("moon_illuminated_fraction", &["track_time"], 0.0, 1.0),
];
pub const BAND: &[Layout] = &[
    ("blackbody_radiance", &["temperature"], 0.0, f32::MAX),
    ("reflectance", &["material"], 0.0, 1.0),
    ("specular_fraction", &["material"], 0.0, 1.0),
    ("shininess", &["material"], 0.0, f32::MAX),
    ("normalisation", &["material"], 0.0, f32::MAX),
];
pub const ATMOSPHERE: &[Layout] = &[
    ("beta_star", PATH.split_at(3).0, 1e-12, f32::MAX),
    ("path_radiance_ratio", PATH, 0.0, f32::MAX),
    ("ambient_radiance", PATH.split_at(4).0, 0.0, f32::MAX),
    ("direct_radiance", PATH.split_at(4).0, 0.0, f32::MAX),
];
/// Of an .atmq file that has them: coefficients of the light around faces of any direction.
pub const LIGHT: &str = "ambient_radiance_harmonics";
pub const GLOW: &str = "ground_radiance_harmonics";
pub const TILTED: &[Layout] = &[
    (LIGHT, &["range", "altitude", "elevation", "source_elevation", "harmonic"], -f32::MAX, f32::MAX),
    (GLOW, &["range", "altitude", "elevation", "ground_temperature", "zonal_harmonic"], -f32::MAX, f32::MAX),
];
/// Of an .atmq that holds the first of them: its quantities without the source; the last beside harmonics alone.
pub const NIGHT: &[Layout] = &[
    ("thermal_path_radiance_ratio", PATH.split_at(3).0, 0.0, f32::MAX),
    ("thermal_ambient_radiance", PATH.split_at(3).0, 0.0, f32::MAX),
    ("thermal_radiance_harmonics", &["range", "altitude", "elevation", "harmonic"], -f32::MAX, f32::MAX),
];
/// What each quantity that depends on the source equals without it; direct light nothing.
pub const WITHOUT_SOURCE: &[(&str, Option<&str>)] = &[
    ("path_radiance_ratio", Some("thermal_path_radiance_ratio")),
    ("ambient_radiance", Some("thermal_ambient_radiance")),
    ("direct_radiance", None),
    (LIGHT, Some("thermal_radiance_harmonics")),
];
/// Degree: a table whose lowest source elevation is above says nothing of twilight.
pub const CIVIL_TWILIGHT: f64 = -6.0;
/// Codes 10 l + m of the harmonics, and of those without azimuth.
pub const HARMONICS: &[f64] = &[0.0, 10.0, 11.0, 20.0, 21.0, 22.0, 40.0, 41.0, 42.0, 43.0, 44.0];
pub const ZONES: &[f64] = &[0.0, 10.0, 20.0, 40.0];
pub const GROUND: [&str; 3] = ["ground_emissivity", "ground_temperature", "ground_radiance"];
/// Of an .atmq of format 3: what transmittance, path radiance and light on surfaces are computed from.
const NODES: &[&str] = &["share", "height_root", "direction"];
pub const CHANNELS: &[Layout] = &[
    ("effective_radius", &["height_root"], 1e-3, f32::MAX),
    ("log_mean_extinction", &["absorber", "share", "height_root", "direction"], -200.0, 200.0),
    ("absorber_factor", &["channel", "absorber"], -f32::MAX, f32::MAX),
    ("channel_weight", &["channel"], 0.0, 1.00001),
    ("thermal_reference", &["channel"], 0.0, f32::MAX),
    ("thermal_ratio", NODES, 0.0, f32::MAX),
    ("source_reference", &["channel"], 0.0, f32::MAX),
    ("scattered_ratio", &["source_part", "share", "height_root", "direction"], 0.0, f32::MAX),
    ("source_factor", &["source_part", "source_elevation", "scattering_angle"], -f32::MAX, f32::MAX),
    ("source_rise", &["target_height"], -90.0, 90.0),
    ("direct_light", &["direct_light_part", "target_height", "elevation_above_rise"], -f32::MAX, f32::MAX),
    ("direct_light_factor", &["channel", "direct_light_part"], -f32::MAX, f32::MAX),
    ("thermal_sky", &["thermal_sky_part", "surface_height"], -f32::MAX, f32::MAX),
    ("thermal_sky_factor", &["channel", "thermal_sky_part"], -f32::MAX, f32::MAX),
    ("scattered_sky", &["scattered_sky_part", "surface_height", "sky_source_elevation"], -f32::MAX, f32::MAX),
    ("scattered_sky_factor", &["channel", "scattered_sky_part"], -f32::MAX, f32::MAX),
];
/// Of one that holds any of them.
pub const CHANNEL_HARMONICS: &[Layout] = &[
    ("thermal_harmonics", &["thermal_harmonics_part", "surface_height", "harmonic"], -f32::MAX, f32::MAX),
    ("thermal_harmonics_factor", &["channel", "thermal_harmonics_part"], -f32::MAX, f32::MAX),
    ("scattered_harmonics", &["scattered_harmonics_part", "surface_height", "sky_source_elevation", "harmonic"], -f32::MAX, f32::MAX),
    ("scattered_harmonics_factor", &["channel", "scattered_harmonics_part"], -f32::MAX, f32::MAX),
    ("ground_harmonics", &["ground_harmonics_part", "surface_height", "zonal_harmonic"], -f32::MAX, f32::MAX),
    ("ground_harmonics_factor", &["channel", "ground_harmonics_part"], -f32::MAX, f32::MAX),
    ("ground_emission", &["ground_temperature", "channel"], 0.0, f32::MAX),
];
/// Of one whose paths refraction bends far: height of their ends above those of straight lines, over the range.
pub const CHANNEL_BENDING: &[Layout] = &[("end_rise", &["share", "height_root", "direction"], -1.0, 1.0)];
/// Of one that holds either of them, and of a .band that does: what light is parted with at the wavelengths of the band.
pub const CHANNEL_SHARES: &[Layout] = &[
    ("thermal_wavelength_share", &["channel", "band_wavelength"], 0.0, 1.00001),
    ("source_wavelength_share", &["channel", "band_wavelength"], 0.0, 1.00001),
];
pub const SPECTRA: &[Layout] = &[
    ("reflectance_spectrum", &["material", "band_wavelength"], 0.0, 1.0),
    ("emission_share", &["planck_temperature", "band_wavelength"], 0.0, 1.00001),
];
/// Arrays whose rows sum to 1.
pub const SHARES: [&str; 3] = [CHANNEL_SHARES[0].0, CHANNEL_SHARES[1].0, SPECTRA[1].0];
/// Relative: the files of one band have the same wavelengths.
pub const WAVELENGTH_ROUNDING: f64 = 1e-6;
/// What it must state: how many numbers, the least and the largest.
pub const STATED: &[(&str, usize, f64, f64)] = &[
    ("ground_altitude_km", 1, -1.0, 10.0),
    ("scale_height_km", 1, 1e-12, 1000.0),
    ("range_km", 2, 0.0, 1e9),
    ("altitude_km", 2, -1.0, 1e9),
];
/// Of the sum of the channels' weights, and of a row of shares, which is 1.
pub const WEIGHT_ROUNDING: f64 = 1e-5;
/// Read at the nearest node outside, whatever the file says.
pub const CLAMPED: &[&str] =
    &["share", "height_root", "direction", "surface_height", "target_height", "elevation_above_rise", "planck_temperature"];
pub const LAST_CODE: f64 = 65535.0;

/// How the format reads an axis: rules and period.
pub fn rules_of(axis: &str) -> (&'static [&'static str], f64) {
    match axis {
        "material" | "harmonic" | "zonal_harmonic" | "channel" | "absorber" => (&["exact"], 0.0),
        part if part.ends_with("_part") => (&["exact"], 0.0),
        "azimuth" => (&["linear_periodic"], 360.0),
        "source_azimuth" => (&["linear_folded"], 360.0),
        "time" => (&["linear_periodic", "linear"], 24.0),
        "response_hour" | "forcing_time" => (&["linear_periodic"], 24.0),
        _ => (&["linear"], 0.0),
    }
}
