/* What each file type must hold; included by database.c alone. */
#ifndef LAYOUTS_H
#define LAYOUTS_H

#include "database.h"

#include <math.h>

static const struct layout SURFACE[] = {
    {"temperature", {"material", "altitude", "azimuth", "slope", "time"}, 1.0, 1e4},
    {NULL, {NULL}, 0, 0},
};
/* What an .htt that holds the first of them must hold, to shade surfaces. */
static const struct layout SHADE[] = {
    {"response_kernel", {"material", "response_altitude", "response_slope", "response_hour", "lag"}, -HUGE_VALF, HUGE_VALF},
    {"response_temperature", {"material", "response_altitude", "response_slope", "response_hour"}, 0.0, 1e4},
    {"heat_loss_slope", {"material", "response_altitude", "response_slope", "response_hour"}, 1e-6, HUGE_VALF},
    {"heat_loss_excess", {"material", "response_altitude", "response_slope", "response_hour", "temperature_offset"}, -HUGE_VALF, HUGE_VALF},
    {"solar_absorptance", {"material"}, 0.0, 1.0},
    {"thermal_emissivity", {"material"}, 0.0, 1.0},
    {"melting_heat", {"material", "response_altitude", "response_slope", "response_hour"}, 0.0, HUGE_VALF},
    {"highest_temperature", {"material"}, 1.0, 1e4},
    {"direct_normal_irradiance", {"altitude", "forcing_time"}, 0.0, HUGE_VALF},
    {"diffuse_irradiance", {"altitude", "forcing_time"}, 0.0, HUGE_VALF},
    {"sky_irradiance", {"altitude", "forcing_time"}, 0.0, HUGE_VALF},
    {"air_temperature", {"altitude", "forcing_time"}, 1.0, 1e4},
    {"solar_elevation", {"forcing_time"}, -90.0, 90.0},
    {"solar_azimuth", {"forcing_time"}, -360.0, 360.0},
    {"aureole_share", {"forcing_time"}, 0.0, 1.0},
    {NULL, {NULL}, 0, 0},
};
/* Of an .htt that holds the first of them: films of water on surfaces, which last longer in the shade. */
static const struct layout FILM[] = {
    {"film_heat_loss", {"material", "response_altitude", "response_slope", "response_hour", "temperature_offset"}, -HUGE_VALF, HUGE_VALF},
    {"film_evaporation", {"material", "response_altitude", "response_slope", "response_hour", "temperature_offset"}, -HUGE_VALF, HUGE_VALF},
    {"film_sunlight", {"material", "response_altitude", "response_slope", "response_hour"}, -HUGE_VALF, HUGE_VALF},
    {"absorbed_sunlight", {"material", "response_altitude", "response_slope", "response_hour"}, 0.0, HUGE_VALF},
    {"film_capacity", {"material"}, 0.0, HUGE_VALF},
    {"rain", {"forcing_time"}, 0.0, HUGE_VALF},
    {NULL, {NULL}, 0, 0},
};
/* Of an .htt whose day does not repeat. */
static const struct layout FILM_BEFORE[] = {
    {"film_before", {"material", "response_altitude", "response_slope"}, 0.0, HUGE_VALF},
    {NULL, {NULL}, 0, 0},
};
/* Of an .htt that holds the first of them: where Sun and Moon stand. */
static const struct layout TRACKS[] = {
    {"sun_elevation", {"track_time"}, -90.0, 90.0},
    {"sun_azimuth", {"track_time"}, -1080.0, 1080.0},
    {"sun_distance", {"track_time"}, 0.9, 1.1},
    {"moon_elevation", {"track_time"}, -90.0, 90.0},
    {"moon_azimuth", {"track_time"}, -1080.0, 1080.0},
    {"moon_distance", {"track_time"}, 3e5, 4.5e5},
    {"moon_phase_angle", {"track_time"}, 0.0, 180.0},
    {"moon_illuminated_fraction", {"track_time"}, 0.0, 1.0},
    {NULL, {NULL}, 0, 0},
};
static const struct layout BAND[] = {
    {"blackbody_radiance", {"temperature"}, 0.0, HUGE_VALF},
    {"reflectance", {"material"}, 0.0, 1.0},
    {"specular_fraction", {"material"}, 0.0, 1.0},
    {"shininess", {"material"}, 0.0, HUGE_VALF},
    {"normalisation", {"material"}, 0.0, HUGE_VALF},
    {"reflectance_spectrum", {"material", "band_wavelength"}, 0.0, 1.0},
    {"emission_share", {"planck_temperature", "band_wavelength"}, 0.0, 1.00001},
    {NULL, {NULL}, 0, 0},
};
/* Of an atmosphere: what transmittance, path radiance and light on surfaces are computed from. */
static const struct layout CHANNELS[] = {
    {"effective_radius", {"height_root"}, 1e-3, HUGE_VALF},
    {"log_mean_extinction", {"absorber", "share", "height_root", "direction"}, -200.0, 200.0},
    {"absorber_factor", {"channel", "absorber"}, -HUGE_VALF, HUGE_VALF},
    {"channel_weight", {"channel"}, 0.0, 1.00001},
    {"thermal_reference", {"channel"}, 0.0, HUGE_VALF},
    {"thermal_ratio", {"share", "height_root", "direction"}, 0.0, HUGE_VALF},
    {"source_reference", {"channel"}, 0.0, HUGE_VALF},
    {"scattered_ratio", {"source_part", "share", "height_root", "direction"}, 0.0, HUGE_VALF},
    {"source_factor", {"source_part", "source_elevation", "scattering_angle"}, -HUGE_VALF, HUGE_VALF},
    {"source_rise", {"target_height"}, -90.0, 90.0},
    {"direct_light", {"direct_light_part", "target_height", "elevation_above_rise"}, -HUGE_VALF, HUGE_VALF},
    {"direct_light_factor", {"channel", "direct_light_part"}, -HUGE_VALF, HUGE_VALF},
    {"thermal_sky", {"thermal_sky_part", "surface_height"}, -HUGE_VALF, HUGE_VALF},
    {"thermal_sky_factor", {"channel", "thermal_sky_part"}, -HUGE_VALF, HUGE_VALF},
    {"scattered_sky", {"scattered_sky_part", "surface_height", "sky_source_elevation"}, -HUGE_VALF, HUGE_VALF},
    {"scattered_sky_factor", {"channel", "scattered_sky_part"}, -HUGE_VALF, HUGE_VALF},
    {"thermal_wavelength_share", {"channel", "band_wavelength"}, 0.0, 1.00001},
    {"source_wavelength_share", {"channel", "band_wavelength"}, 0.0, 1.00001},
    {NULL, {NULL}, 0, 0},
};
/* Of one that holds any of them. */
static const struct layout CHANNEL_HARMONICS[] = {
    {"thermal_harmonics", {"thermal_harmonics_part", "surface_height", "harmonic"}, -HUGE_VALF, HUGE_VALF},
    {"thermal_harmonics_factor", {"channel", "thermal_harmonics_part"}, -HUGE_VALF, HUGE_VALF},
    {"scattered_harmonics", {"scattered_harmonics_part", "surface_height", "sky_source_elevation", "harmonic"}, -HUGE_VALF, HUGE_VALF},
    {"scattered_harmonics_factor", {"channel", "scattered_harmonics_part"}, -HUGE_VALF, HUGE_VALF},
    {"ground_harmonics", {"ground_harmonics_part", "surface_height", "zonal_harmonic"}, -HUGE_VALF, HUGE_VALF},
    {"ground_harmonics_factor", {"channel", "ground_harmonics_part"}, -HUGE_VALF, HUGE_VALF},
    {"ground_emission", {"ground_temperature", "channel"}, 0.0, HUGE_VALF},
    {NULL, {NULL}, 0, 0},
};
/* Of one whose paths refraction bends far: height of their ends above those of straight lines, over the range. */
static const struct layout CHANNEL_BENDING[] = {
    {"end_rise", {"share", "height_root", "direction"}, -1.0, 1.0},
    {NULL, {NULL}, 0, 0},
};

#endif
