/* A runtime's reader of the databases with libhdf5: the radiance of the pixels of a scene.
 *
 * Usage: runtime SCENE.json
 *
 * The scene and the result are described in ../README.md. Equation numbers are those of DSTO-TN-0193. */
#include "database.h"
#include "json.h"
#include "shade.h"
#include "texture.h"

#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_SIZE = 4096 };

static const double RADIAN = 0.017453292519943295;

/* Code of a material given by code or by name. */
static double material_code(const struct database *band, const struct json *given)
{
    if (given && given->kind == JSON_NUMBER) return given->number;
    if (!given || given->kind != JSON_TEXT) fail("the scene lacks 'material'");
    const struct axis *codes = &array_of(band, "reflectance")->axes[0];
    size_t matches = 0, at = 0;
    for (size_t i = 0; i < codes->count; ++i)
        if (!strcmp(band->material_names[i], given->text)) at = i, ++matches;
    if (matches != 1) fail("material: found '%s'; allowed: a name that the file has once", given->text);
    return codes->nodes[at];
}

static double number(const struct json *object, const char *key)
{
    const struct json *found = json_get(object, key);
    if (!found || found->kind != JSON_NUMBER) fail("the scene lacks the number '%s'", key);
    return found->number;
}

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

/* L_ambient, as `light_at`, of a face with a normal in the frame of the source's azimuth; temperature of the ground and
 * what it emits. */
static void ambient(const struct database *air, const double *centre, const double *normal, const double *ground, double *to)
{
    const struct axis *codes = codes_of(air, LIGHT), *zones = codes_of(air, GLOW);
    const double up[3] = {0.0, 0.0, 1.0}, square = normal[2] * normal[2];
    const double share = codes->count == 6 ? ((35 * square - 30) * square + 3) / 8 : (((231 * square - 315) * square + 105) * square - 5) / 16;
    const size_t parts = parts_of(air);
    double facing[HARMONICS], upright[HARMONICS], *light = allocate(parts, sizeof *light);
    irradiance_harmonics(normal, facing);
    irradiance_harmonics(up, upright);
    light_at(air, "ambient_radiance", centre, to);
    for (size_t b = 0; b < parts; ++b) to[b] *= share;
    for (size_t h = 0; h < codes->count; ++h) {
        const double factor = facing[h] - upright[h] * share;
        light_at(air, LIGHT, (double[]){centre[0], centre[1], centre[2], centre[3], codes->nodes[h]}, light);
        for (size_t b = 0; b < parts; ++b) to[b] += factor * light[b];
        for (size_t z = 0; z < zones->count; ++z)
            if (codes->nodes[h] == zones->nodes[z]) {
                light_at(air, GLOW, (double[]){centre[0], centre[1], centre[2], ground[0], zones->nodes[z]}, light);
                for (size_t b = 0; b < parts; ++b) to[b] += factor * ground[1] * light[b];
            }
    }
    for (size_t b = 0; b < parts; ++b) to[b] = fmax(to[b], 0.0);
    free(light);
}

/* Where Sun or Moon stands: elevation, azimuth from the line of sight, azimuth from north eastward (NaN where the pixel
 * does not say), and the direction to it, of length 1. */
struct position {
    double elevation, azimuth, heading, direction[3];
};

/* L_ambient of a pixel's face, as `light_at`; of a level one where the file or the pixel says no more. */
static void ambient_of_pixel(const struct database *surface, const struct database *band, const struct database *air, const double *centre,
                             const struct json *given, const struct position *source, double *to)
{
    if (!air->tilted || isnan(source->heading)) {
        light_at(air, "ambient_radiance", centre, to);
        return;
    }
    double ground[2] = {air->ground[1], air->ground[2]};
    const struct json *material = json_get(given, "ground_material");
    if (material) {
        const double level[] = {material_code(band, material), number(given, "surface_altitude"), 0.0, 0.0, number(given, "time")};
        ground[0] = value_at(surface, "temperature", level);
        ground[1] = air->ground[0] * value_at(band, "blackbody_radiance", &ground[0]);
    }
    const double slope = RADIAN * number(given, "surface_slope");
    const double turn = RADIAN * (number(given, "surface_azimuth") - source->heading);
    const double normal[3] = {sin(slope) * cos(turn), sin(slope) * sin(turn), cos(slope)};
    ambient(air, centre, normal, ground, to);
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void direction(const struct json *pixel, const char *key, double *unit)
{
    const struct json *list = json_get(pixel, key), *part = list ? list->children : NULL;
    for (int k = 0; k < 3; ++k, part = part->next) {
        if (!part || part->kind != JSON_NUMBER) fail("'%s' must be three numbers", key);
        unit[k] = part->number;
    }
    double length = sqrt(dot(unit, unit));
    if (!(length > 0.0) || !isfinite(length)) fail("'%s' must be three finite numbers that are not all 0", key);
    for (int k = 0; k < 3; ++k) unit[k] /= length;
}

/* Equations (37) and (38): chi of the half vector to the power of the shininess. */
static double lobe(const double *normal, const double *to_source, const double *to_observer, double shininess)
{
    double between[3];
    for (int k = 0; k < 3; ++k) between[k] = to_source[k] + to_observer[k];
    double length = sqrt(dot(between, between));
    double chi = length > 0.0 ? dot(between, normal) / length : 0.0;
    return pow(fmin(fmax(chi, 0.0), 1.0), shininess);
}

/* Equation (44), rounded to the nearest integer: the nearest to x - 1/2, halves upwards, is the floor of x. */
static long pixel_value(double radiance, const struct json *scene)
{
    double size = pow(2.0, number(scene, "bits"));
    double share = fmin(fmax(radiance / number(scene, "gain"), 0.0), 1.0);
    double value = floor(size * number(scene, "buffer_gain") * (share - number(scene, "offset")));
    return (long)fmin(fmax(value, 0.0), size - 1.0);
}

/* Angle between line of sight and source, all in degree. */
static double scattering_angle(double elevation, double source_elevation, double azimuth)
{
    const double degree = acos(-1.0) / 180.0;
    const double apart = sin((elevation - source_elevation) * degree / 2), turn = sin(azimuth * degree / 2);
    const double half = apart * apart + cos(elevation * degree) * cos(source_elevation * degree) * turn * turn;
    return 2.0 * asin(sqrt(fmin(fmax(half, 0.0), 1.0))) / degree;
}

/* The source of a pixel: as it says, or from the tracks of the surface file. */
static struct position source_of(const struct database *surface, const struct database *air, const struct json *given)
{
    struct position source = {0, 0, NAN, {0}};
    if (json_get(given, "source_elevation")) {
        source.elevation = number(given, "source_elevation");
        source.azimuth = number(given, "source_azimuth");
        if (json_get(given, "source_heading")) source.heading = number(given, "source_heading");
        direction(given, "to_source", source.direction);
        return source;
    }
    if (!surface->tracked) fail("the surface file holds no tracks of Sun and Moon");
    const double time = number(given, "time");
    source.elevation = value_at(surface, air->lunar ? "moon_elevation" : "sun_elevation", &time);
    const double heading = value_at(surface, air->lunar ? "moon_azimuth" : "sun_azimuth", &time);
    source.azimuth = json_get(given, "source_azimuth") ? number(given, "source_azimuth") : heading - number(given, "line_heading");
    source.heading = json_get(given, "source_heading") ? number(given, "source_heading") : heading;
    source.direction[0] = cos(RADIAN * source.elevation) * sin(RADIAN * heading);
    source.direction[1] = cos(RADIAN * source.elevation) * cos(RADIAN * heading);
    source.direction[2] = sin(RADIAN * source.elevation);
    if (json_get(given, "to_source")) direction(given, "to_source", source.direction);
    return source;
}

/* Codes and shares of the materials that a pixel sees, those of a texel or one; returns how many. */
static size_t materials_of(const struct database *band, struct texture *texture, const struct json *given, double *codes, double *shares)
{
    const struct json *texel = json_get(given, "texel");
    if (!texel) {
        codes[0] = material_code(band, json_get(given, "material"));
        shares[0] = 1.0;
        return 1;
    }
    if (!texture->path) fail("the scene lacks 'texture'");
    const struct json *across = texel->kind == JSON_LIST ? texel->children : NULL, *down = across ? across->next : NULL;
    if (!down || down->next || across->kind != JSON_NUMBER || down->kind != JSON_NUMBER) fail("'texel' must be two numbers");
    const double level = json_get(given, "level") ? number(given, "level") : 0.0;
    return mixture_at(texture, across->number, down->number, level, codes, shares);
}

struct pixel {
    double material, temperature, blackbody, beta, tau, thermal, path, skyshine, diffuse, specular, radiance;
    long value;
};

/* Temperature of the table, or with the heat or the surroundings that the pixel has. */
static double temperature_of(const struct database *surface, const double *face, const struct json *given)
{
    const struct json *around = json_get(given, "surroundings"), *list = json_get(given, "absorbed_change");
    if (around && around->kind == JSON_OBJECT) return temperature_beside(surface, face, around);
    if (!list || list->kind != JSON_LIST) return value_at(surface, "temperature", face);
    size_t count = 0, at = 0;
    for (const struct json *each = list->children; each; each = each->next) ++count;
    double *absorbed = allocate(count, sizeof *absorbed);
    for (const struct json *each = list->children; each; each = each->next) absorbed[at++] = each->kind == JSON_NUMBER ? each->number : NAN;
    const double temperature = temperature_under(surface, face, absorbed, count);
    free(absorbed);
    return temperature;
}

/* Of a material at a temperature: reflectance, and the share in what a black body emits, at each wavelength or in the
 * whole band. */
static void spectra_of(const struct database *band, size_t parted, double code, double temperature, double *rho, double *emission)
{
    if (!parted) {
        *rho = value_at(band, "reflectance", &code);
        *emission = 1.0;
        return;
    }
    const double *nodes = array_of(band, "emission_share")->axes[1].nodes;
    for (size_t b = 0; b < parted; ++b) {
        rho[b] = interpolated(band, "reflectance_spectrum", (double[]){code, nodes[b]});
        emission[b] = interpolated(band, "emission_share", (double[]){temperature, nodes[b]});
    }
}

/* Equations (1) to (44) for one pixel. */
static struct pixel compute(const struct json *scene, const struct database *surface, const struct database *band,
                            const struct database *air, struct texture *texture, const struct json *given)
{
    const struct position source = source_of(surface, air, given);
    double centre[] = {number(given, "centre_range"), number(given, "altitude"), number(given, "centre_elevation"), source.elevation, source.azimuth};
    double codes[COMPONENTS], shares[COMPONENTS], normal[3], to_observer[3];
    const size_t count = materials_of(band, texture, given, codes, shares);
    struct pixel pixel = {.material = codes[0]};
    pixel.beta = value_at(air, "beta_star", centre);
    const double depth = 5.5 * number(given, "range") / pixel.beta;
    pixel.tau = exp(-depth); /* (9) */
    direction(given, "normal", normal);
    direction(given, "to_observer", to_observer);
    const double incidence = fmax(dot(normal, source.direction), 0.0);
    const size_t parts = parts_of(air);
    double *light = allocate(5 * parts, sizeof *light), *beam = light + parts, *through = beam + parts, *rho = through + parts, *emission = rho + parts;
    if (incidence > 0.0) light_at(air, "direct_radiance", centre, beam);
    ambient_of_pixel(surface, band, air, centre, given, &source, light);
    transmittance_at(air, centre, number(given, "range"), through);
    for (size_t k = 0; k < count; ++k) {
        const double code = codes[k], share = shares[k];
        const double face[] = {code, number(given, "surface_altitude"), number(given, "surface_azimuth"), number(given, "surface_slope"), number(given, "time")};
        const double temperature = temperature_of(surface, face, given);
        const double blackbody = value_at(band, "blackbody_radiance", &temperature); /* (7) */
        const double fraction = value_at(band, "specular_fraction", &code);
        double emitted = 0.0, sky = 0.0, direct = 0.0;
        spectra_of(band, air->parted, code, temperature, rho, emission);
        for (size_t b = 0; b < parts; ++b) {
            emitted += (1.0 - rho[b]) * emission[b] * through[b];
            sky += rho[b] * light[b];
            direct += rho[b] * beam[b];
        }
        direct = fmax(direct, 0.0) * pixel.tau;
        pixel.temperature += share * temperature;
        pixel.blackbody += share * blackbody;
        pixel.thermal += share * blackbody * emitted; /* (5), or (6) */
        pixel.skyshine += share * fmax(sky, 0.0) * pixel.tau; /* (18), or (19) */
        pixel.diffuse += share * direct * incidence * (1.0 - fraction); /* (34) */
        const double shape = lobe(normal, source.direction, to_observer, value_at(band, "shininess", &code));
        pixel.specular += share * direct * shape * fraction * value_at(band, "normalisation", &code); /* (35) */
    }
    free(light);
    if (air->channels.present || !strcmp(array_of(air, "path_radiance_ratio")->axes[4].name, "scattering_angle"))
        centre[4] = scattering_angle(centre[2], centre[3], centre[4]);
    pixel.path = value_at(air, "path_radiance_ratio", centre) * -expm1(-depth); /* (11) */
    pixel.radiance = pixel.diffuse + pixel.specular + pixel.skyshine + pixel.thermal + pixel.path; /* (1) */
    pixel.value = pixel_value(pixel.radiance, scene);
    return pixel;
}

static void print(const struct pixel *pixel)
{
    printf("{\"material\": %.17g, \"temperature\": %.17g, \"blackbody_radiance\": %.17g, \"beta_star\": %.17g, \"transmittance\": %.17g, "
           "\"thermal\": %.17g, \"path\": %.17g, \"skyshine\": %.17g, \"diffuse\": %.17g, \"specular\": %.17g, "
           "\"radiance\": %.17g, \"pixel_value\": %ld}",
           pixel->material, pixel->temperature, pixel->blackbody, pixel->beta, pixel->tau, pixel->thermal, pixel->path, pixel->skyshine,
           pixel->diffuse, pixel->specular, pixel->radiance, pixel->value);
}

static char *read_whole(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) fail("%s: cannot be read", path);
    size_t size = 0, room = 4096;
    char *text = allocate(room, 1);
    while (!feof(file) && !ferror(file)) {
        if (room - size < 2 && !(text = realloc(text, room *= 2))) fail("no memory is left");
        size += fread(text + size, 1, room - size - 1, file);
    }
    fclose(file);
    text[size] = 0;
    return text;
}

/* Path of a file that the scene names, relative to the scene's folder. */
static const char *path_of(const struct json *scene, const char *key, const char *scene_path)
{
    const struct json *name = json_get(scene, key);
    if (!name || name->kind != JSON_TEXT) fail("the scene lacks '%s'", key);
    const char *slash = name->text[0] == '/' ? NULL : strrchr(scene_path, '/');
    const int folder = slash ? (int)(slash - scene_path + 1) : 0;
    char *path = allocate(PATH_SIZE, 1);
    if (snprintf(path, PATH_SIZE, "%.*s%s", folder, scene_path, name->text) >= PATH_SIZE) fail("the path of '%s' is too long", key);
    return path;
}

int main(int count, char **arguments)
{
    if (count != 2) fail("usage: runtime SCENE.json");
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const struct json *scene = json_parse(read_whole(arguments[1]));
    if (!scene) fail("%s: is not JSON", arguments[1]);
    const struct json *pixels = json_get(scene, "pixels"), *clamped = json_get(scene, "clamp");
    if (!pixels || pixels->kind != JSON_LIST) fail("the scene lacks the list 'pixels'");
    static struct database surface, band, air;
    open_database(&surface, path_of(scene, "surface", arguments[1]), "htt", clamped);
    open_database(&band, path_of(scene, "band", arguments[1]), "band", clamped);
    open_database(&air, path_of(scene, "atmosphere", arguments[1]), "atmq", clamped);
    part_light(&air, &band);
    static struct texture texture;
    if (json_get(scene, "texture")) open_texture(&texture, path_of(scene, "texture", arguments[1]));
    size_t total = 0, done = 0;
    for (const struct json *each = pixels->children; each; each = each->next) ++total;
    struct pixel *computed = allocate(total, sizeof *computed); /* nothing is printed where one pixel fails */
    for (const struct json *each = pixels->children; each; each = each->next)
        computed[done++] = compute(scene, &surface, &band, &air, &texture, each);
    printf("{\"pixels\": [");
    for (size_t i = 0; i < total; ++i) {
        if (i) printf(", ");
        print(&computed[i]);
    }
    printf("]}\n");
    return 0;
}
