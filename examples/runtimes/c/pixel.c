/* Equations (1) to (44) for one pixel. */
#include "channels.h"
#include "shade.h"
#include "tables.h"

#include <math.h>
#include <string.h>

static const double RADIAN = 0.017453292519943295;

/* A_l / pi times Y_lm of a unit normal, in the order of the codes. */
static void irradiance_harmonics(const double *n, double *to)
{
    const double x = n[0], y = n[1], z = n[2], even = x * x - y * y;
    to[0] = 0.28209479177387814;
    to[1] = 0.32573500793527993 * z;
    to[2] = 0.32573500793527993 * x;
    to[3] = 0.15769578262626002 * (3 * z * z - 1) / 2;
    to[4] = 0.2731371076480198 * x * z;
    to[5] = 0.1365685538240099 * even;
    to[6] = -0.03526184897173477 * ((35 * z * z - 30) * z * z + 3) / 8;
    to[7] = -0.0557538786297741 * x * z * (7 * z * z - 3) / 2;
    to[8] = -0.039423945656565 * even * (7 * z * z - 1) / 2;
    to[9] = -0.14751089748166088 * x * z * (x * x - 3 * y * y) / 2;
    to[10] = -0.026076488977049006 * (even * even - 4 * x * x * y * y);
}

void sky_bases(const struct database *air, const double *normal, double *to)
{
    const double square = normal[2] * normal[2];
    const int second_degree = sky_codes_of(air, "scattered_harmonics")->count == 6;
    to[0] = second_degree ? ((35 * square - 30) * square + 3) / 8 : (((231 * square - 315) * square + 105) * square - 5) / 16;
    irradiance_harmonics(normal, to + 1);
}

/* Light at each wavelength, or in the whole band where one value is asked for. */
static void light_of(const struct database *air, const char *name, const double *place, size_t parts, double *to)
{
    if (parts > 1) sky_light_by_wavelength(air, name, place, to);
    else *to = sky_quantity_at(air, name, place);
}

size_t sky_ambient_weights(const struct database *air, const double *place, int tilted, const double *ground, size_t parts, double *to)
{
    light_of(air, "ambient_radiance", place, parts, to);
    if (!tilted) return 1;
    const struct axis *codes = sky_codes_of(air, "scattered_harmonics"), *zones = sky_codes_of(air, "ground_harmonics");
    double upright[HARMONICS], *glow = sky_allocate(parts, sizeof *glow);
    irradiance_harmonics((double[]){0.0, 0.0, 1.0}, upright);
    for (size_t h = 0; h < codes->count; ++h) {
        double *light = to + (1 + h) * parts;
        light_of(air, LIGHT, (double[]){place[0], place[1], place[2], place[3], codes->nodes[h]}, parts, light);
        for (size_t z = 0; z < zones->count; ++z)
            if (codes->nodes[h] == zones->nodes[z]) {
                light_of(air, GLOW, (double[]){place[0], place[1], place[2], ground[0], zones->nodes[z]}, parts, glow);
                for (size_t b = 0; b < parts; ++b) light[b] += ground[1] * glow[b];
            }
        for (size_t b = 0; b < parts; ++b) to[b] -= upright[h] * light[b];
    }
    sky_release(glow);
    return 1 + codes->count;
}

/* Temperature of the ground: of a material at an altitude; for 0 of the material that the file names, or as it states it. */
static double ground_temperature(const skyshine_tables *tables, int32_t material, double altitude, double time)
{
    const struct database *air = &tables->air, *surface = &tables->surface;
    double code = material;
    if (!material && !*air->ground_material) {
        if (isnan(air->ground[1])) sky_fail("%s: does not state the temperature of the ground", air->path);
        return air->ground[1];
    }
    if (!material) {
        const struct axis *codes = &sky_array_of(&tables->band, "reflectance")->axes[0];
        for (size_t i = 0; i < codes->count; ++i)
            if (!strcmp(tables->band.material_names[i], air->ground_material)) code = codes->nodes[i];
        if (code == 0.0) sky_fail("%s: names the ground '%s', a material that the band lacks", air->path, air->ground_material);
        altitude = sky_array_of(surface, "temperature")->axes[ALTITUDE].nodes[0];
    }
    return sky_value_at(surface, "temperature", (double[]){code, altitude, 0.0, 0.0, time});
}

void sky_ground_of(const skyshine_tables *tables, int32_t material, double altitude, double time, double *ground)
{
    ground[0] = tables->air.ground[1];
    ground[1] = tables->air.ground[2];
    if (!material && !*tables->air.ground_material) return;
    ground[0] = ground_temperature(tables, material, altitude, time);
    ground[1] = tables->air.ground[0] * sky_value_at(&tables->band, "blackbody_radiance", ground);
}

/* Angle between line of sight and source, all in degree. */
static double scattering_angle(double elevation, double source_elevation, double azimuth)
{
    const double degree = acos(-1.0) / 180.0;
    const double apart = sin((elevation - source_elevation) * degree / 2), turn = sin(azimuth * degree / 2);
    const double half = apart * apart + cos(elevation * degree) * cos(source_elevation * degree) * turn * turn;
    return 2.0 * asin(sqrt(fmin(fmax(half, 0.0), 1.0))) / degree;
}

double sky_path_ratio_at(const struct database *air, const double *place)
{
    const double angle = scattering_angle(place[2], place[3], place[4]);
    return sky_quantity_at(air, "path_radiance_ratio", (double[]){place[0], place[1], place[2], sky_source_at_entry(air, place), angle});
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void unit_of(const double *direction, const char *name, double *unit)
{
    const double length = sqrt(dot(direction, direction));
    if (!(length > 0.0) || !isfinite(length)) sky_fail("'%s' must be three finite numbers that are not all 0", name);
    for (int k = 0; k < 3; ++k) unit[k] = direction[k] / length;
}

/* Equations (37) and (38): chi of the half vector to the power of the shininess. */
static double lobe(const double *normal, const double *to_source, const double *to_observer, double shininess)
{
    double between[3];
    for (int k = 0; k < 3; ++k) between[k] = to_source[k] + to_observer[k];
    const double length = sqrt(dot(between, between));
    const double chi = length > 0.0 ? dot(between, normal) / length : 0.0;
    return pow(fmin(fmax(chi, 0.0), 1.0), shininess);
}

/* A row of an array of the band at each wavelength: what a material reflects, or the share of what a black body emits. */
static void spectrum_of(const struct database *band, const char *name, double row, double *to)
{
    const struct axis *wavelength = &sky_array_of(band, name)->axes[1];
    for (size_t b = 0; b < wavelength->count; ++b) to[b] = sky_value_at(band, name, (double[]){row, wavelength->nodes[b]});
}

/* L_ambient of the pixel's face at each wavelength; of a level one where the file or the pixel says no more. */
static void ambient_of(const skyshine_tables *tables, const skyshine_pixel *pixel, const double *place, double *to)
{
    const size_t parts = sky_wavelengths_of(&tables->air);
    if (!tables->air.tilted || isnan(pixel->source_heading)) {
        sky_light_by_wavelength(&tables->air, "ambient_radiance", place, to);
        return;
    }
    double ground[2], bases[BASES], *weights = sky_allocate(BASES * parts, sizeof *weights);
    sky_ground_of(tables, pixel->ground_material, pixel->surface_altitude, pixel->time, ground);
    const double slope = RADIAN * pixel->surface_slope, turn = RADIAN * (pixel->surface_azimuth - pixel->source_heading);
    const size_t count = sky_ambient_weights(&tables->air, place, 1, ground, parts, weights);
    sky_bases(&tables->air, (double[]){sin(slope) * cos(turn), sin(slope) * sin(turn), cos(slope)}, bases);
    for (size_t b = 0; b < parts; ++b) {
        double light = 0.0;
        for (size_t k = 0; k < count; ++k) light += bases[k] * weights[k * parts + b];
        to[b] = fmax(light, 0.0);
    }
}

/* What black bodies beside a pixel emit, at each wavelength as `sky_light_by_wavelength` gives light there. */
static void glow_of(const skyshine_tables *tables, const double *place, double temperature, double *to)
{
    const size_t parts = sky_wavelengths_of(&tables->air);
    const double radiance = sky_value_at(&tables->band, "blackbody_radiance", &temperature);
    const double tau = exp(-5.5 * place[0] / sky_quantity_at(&tables->air, "beta_star", place));
    double *extinction = sky_allocate(parts, sizeof *extinction);
    sky_extinction_by_wavelength(&tables->air, place, extinction);
    spectrum_of(&tables->band, "emission_share", temperature, to);
    for (size_t b = 0; b < parts; ++b) to[b] *= tau > 0.0 ? radiance * exp(-extinction[b] * place[0]) / tau : 0.0;
}

/* Put what hides a share of the sky in its place: the formula of schemas/formats/atmq-4.md. */
static void hide_sky(const skyshine_tables *tables, const skyshine_pixel *pixel, const double *place, double hidden, double *sky)
{
    const size_t parts = sky_wavelengths_of(&tables->air);
    double *level = sky_allocate(3 * parts, sizeof *level), *wall = level + parts, *ground = wall + parts;
    sky_light_by_wavelength(&tables->air, "ambient_radiance", place, level);
    glow_of(tables, place, sky_air_temperature(&tables->surface, pixel->surface_altitude, pixel->time), wall);
    glow_of(tables, place, ground_temperature(tables, pixel->ground_material, pixel->surface_altitude, pixel->time), ground);
    const double share = hidden * 0.5 * (1.0 + cos(RADIAN * pixel->surface_slope));
    for (size_t b = 0; b < parts; ++b) {
        const double light = SKY_WALL_EMISSIVITY * wall[b] + (1.0 - SKY_WALL_EMISSIVITY) * 0.5 * (level[b] + ground[b]);
        sky[b] = fmax(sky[b] + share * (light - level[b]), 0.0);
    }
}

/* What a pixel is lit by and seen through, at each wavelength. */
struct light {
    size_t parts;
    double *sky, *beam, *through;
    double normal[3], to_source[3], to_observer[3], incidence;
};

/* A share of the pixel that emits at a temperature. */
static void add_emission(const skyshine_tables *tables, const struct light *light, const double *rho, double share, double temperature, skyshine_terms *terms)
{
    double emitted = 0.0, *emission = sky_allocate(light->parts, sizeof *emission);
    const double blackbody = sky_value_at(&tables->band, "blackbody_radiance", &temperature);
    spectrum_of(&tables->band, "emission_share", temperature, emission);
    for (size_t b = 0; b < light->parts; ++b) emitted += (1.0 - rho[b]) * emission[b] * light->through[b];
    terms->temperature += share * temperature;
    terms->blackbody_radiance += share * blackbody; /* (7) */
    terms->thermal += share * blackbody * emitted; /* (5) */
}

/* Open share of the sky above what of a pixel lies in the shade. */
static double shaded_view(const skyshine_pixel *pixel)
{
    return fmin(1.0 - pixel->hidden_sky, pixel->shaded_sky);
}

static void add_material(const skyshine_tables *tables, const skyshine_pixel *pixel, size_t k, const struct light *light, skyshine_terms *terms)
{
    static const double ALL_DAY[][2] = {{0.0, 24.0}};
    const struct database *band = &tables->band;
    const double code = pixel->material[k], lit = 1.0 - pixel->shade, share = pixel->share[k];
    const double face[] = {code, pixel->surface_altitude, pixel->surface_azimuth, pixel->surface_slope, pixel->time};
    double temperature = pixel->temperature[k], sky = 0.0, direct = 0.0, *rho = sky_allocate(light->parts, sizeof *rho);
    if (isnan(temperature)) temperature = sky_value_at(&tables->surface, "temperature", face);
    spectrum_of(band, "reflectance_spectrum", code, rho);
    add_emission(tables, light, rho, share * lit, temperature, terms);
    if (pixel->shade > 0.0) {
        const skyshine_surroundings around = {ALL_DAY, 1, shaded_view(pixel), NAN, NAN};
        const double given = pixel->shaded_temperature[k];
        add_emission(tables, light, rho, share * pixel->shade, isnan(given) ? sky_temperature_beside(&tables->surface, face, &around) : given, terms);
    }
    for (size_t b = 0; b < light->parts; ++b) {
        sky += rho[b] * light->sky[b];
        direct += rho[b] * light->beam[b];
    }
    const double fraction = sky_value_at(band, "specular_fraction", &code);
    direct = fmax(direct, 0.0) * terms->transmittance * lit;
    terms->skyshine += share * fmax(sky, 0.0) * terms->transmittance; /* (18) */
    terms->diffuse += share * direct * light->incidence * (1.0 - fraction); /* (34) */
    const double shape = lobe(light->normal, light->to_source, light->to_observer, sky_value_at(band, "shininess", &code));
    terms->specular += share * direct * shape * fraction * sky_value_at(band, "normalisation", &code); /* (35) */
}

static void check_share(const char *name, double value)
{
    if (!(value >= 0.0 && value <= 1.0)) sky_fail("%s: found %g; allowed: 0 to 1", name, value);
}

static void compute(const skyshine_tables *tables, const skyshine_pixel *pixel, skyshine_terms *terms)
{
    const struct database *air = &tables->air;
    const double place[] = {pixel->centre_range, pixel->altitude, pixel->centre_elevation, pixel->source_elevation, pixel->source_azimuth};
    struct light light = {.parts = sky_wavelengths_of(air)};
    memset(terms, 0, sizeof *terms);
    if (pixel->materials < 1 || pixel->materials > SKYSHINE_COMPONENTS) sky_fail("materials: found %zu; allowed: 1 to %d", pixel->materials, SKYSHINE_COMPONENTS);
    if (!(pixel->range >= 0.0 && isfinite(pixel->range))) sky_fail("range: found %g; allowed: finite numbers from 0", pixel->range);
    check_share("shade", pixel->shade);
    check_share("hidden_sky", pixel->hidden_sky);
    if (pixel->shade > 0.0) check_share("shaded_sky", pixel->shaded_sky);
    terms->beta_star = sky_quantity_at(air, "beta_star", place);
    const double depth = 5.5 * pixel->range / terms->beta_star;
    terms->transmittance = exp(-depth); /* (9) */
    unit_of(pixel->normal, "normal", light.normal);
    unit_of(pixel->to_source, "to_source", light.to_source);
    unit_of(pixel->to_observer, "to_observer", light.to_observer);
    light.incidence = fmax(dot(light.normal, light.to_source), 0.0);
    light.sky = sky_allocate(3 * light.parts, sizeof(double));
    light.beam = light.sky + light.parts;
    light.through = light.beam + light.parts;
    if (light.incidence > 0.0) sky_light_by_wavelength(air, "direct_radiance", place, light.beam);
    ambient_of(tables, pixel, place, light.sky);
    const double open = 1.0 - pixel->hidden_sky, seen = pixel->shade > 0.0 ? open - pixel->shade * (open - shaded_view(pixel)) : open;
    if (seen < 1.0) hide_sky(tables, pixel, place, 1.0 - seen, light.sky);
    sky_extinction_by_wavelength(air, place, light.through);
    for (size_t b = 0; b < light.parts; ++b) light.through[b] = exp(-pixel->range * light.through[b]);
    for (size_t k = 0; k < pixel->materials; ++k) add_material(tables, pixel, k, &light, terms);
    terms->path = sky_path_ratio_at(air, place) * -expm1(-depth); /* (11) */
    terms->radiance = terms->diffuse + terms->specular + terms->skyshine + terms->thermal + terms->path; /* (1) */
}

skyshine_status skyshine_pixel_radiance(const skyshine_tables *tables, const skyshine_pixel *pixel, skyshine_terms *terms, skyshine_error *error)
{
    struct call call;
    skyshine_terms computed;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        compute(tables, pixel, &computed);
        *terms = computed;
    }
    return sky_end(&call, error);
}

long skyshine_pixel_value(double radiance, int bits, double gain, double buffer_gain, double offset)
{
    const double size = ldexp(1.0, bits), share = fmin(fmax(radiance / gain, 0.0), 1.0);
    /* The nearest integer to x - 1/2, halves upwards, is the floor of x. */
    return (long)fmin(fmax(floor(size * buffer_gain * (share - offset)), 0.0), size - 1.0);
}
