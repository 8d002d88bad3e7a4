/* The program of this folder: the radiance of the pixels of a scene, by the public calls of skyshine.h alone.
 *
 * Usage: runtime SCENE.json
 *
 * The scene and the result are described in ../README.md. */
#include "json.h"
#include "skyshine.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_SIZE = 4096 };

static const double RADIAN = 0.017453292519943295;

/* The files of a scene. */
struct scene {
    const struct json *root;
    skyshine_tables *tables;
    skyshine_texture *texture;
};

struct result {
    double material;
    skyshine_terms terms;
    long value;
};

static _Noreturn void stop(const char *format, ...)
{
    char line[SKYSHINE_MESSAGE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    for (char *at = line; *at; ++at)
        if ((unsigned char)*at < ' ') *at = '?';
    fprintf(stderr, "%s\n", line);
    exit(1);
}

static void check(const skyshine_error *error)
{
    if (error->status) stop("%s", error->message);
}

static void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) stop("no memory is left");
    return memory;
}

static double number(const struct json *object, const char *key)
{
    const struct json *found = sky_json_get(object, key);
    if (!found || found->kind != JSON_NUMBER) stop("the scene lacks the number '%s'", key);
    return found->number;
}

static double number_or(const struct json *object, const char *key, double otherwise)
{
    const struct json *found = sky_json_get(object, key);
    if (!found || found->kind == JSON_NULL) return otherwise;
    if (found->kind != JSON_NUMBER || !isfinite(found->number)) stop("surroundings must be finite numbers");
    return found->number;
}

/* Code of a material given by code or by name. */
static int32_t material_code(const skyshine_tables *tables, const struct json *given)
{
    const int32_t *codes;
    const char *const *names;
    const size_t count = skyshine_materials(tables, &codes, &names);
    if (given && given->kind == JSON_NUMBER) {
        if (!(given->number >= 1 && given->number <= 65535 && given->number == floor(given->number)))
            stop("material: found %g; allowed: a code of the file", given->number);
        return (int32_t)given->number;
    }
    if (!given || given->kind != JSON_TEXT) stop("the scene lacks 'material'");
    size_t matches = 0, at = 0;
    for (size_t i = 0; i < count; ++i)
        if (!strcmp(names[i], given->text)) at = i, ++matches;
    if (matches != 1) stop("material: found '%s'; allowed: a name that the file has once", given->text);
    return codes[at];
}

static void direction(const struct json *pixel, const char *key, double *to)
{
    const struct json *list = sky_json_get(pixel, key), *part = list ? list->children : NULL;
    for (int k = 0; k < 3; ++k, part = part->next) {
        if (!part || part->kind != JSON_NUMBER) stop("'%s' must be three numbers", key);
        to[k] = part->number;
    }
}

/* Where the source stands: as the pixel says, or by the tracks of the surface file. */
static void place_source(const struct scene *scene, const struct json *given, skyshine_pixel *pixel)
{
    skyshine_error error;
    double heading;
    pixel->source_heading = NAN;
    if (sky_json_get(given, "source_elevation")) {
        pixel->source_elevation = number(given, "source_elevation");
        pixel->source_azimuth = number(given, "source_azimuth");
        if (sky_json_get(given, "source_heading")) pixel->source_heading = number(given, "source_heading");
        direction(given, "to_source", pixel->to_source);
        return;
    }
    skyshine_source_position(scene->tables, pixel->time, &pixel->source_elevation, &heading, &error);
    check(&error);
    pixel->source_azimuth = sky_json_get(given, "source_azimuth") ? number(given, "source_azimuth") : heading - number(given, "line_heading");
    pixel->source_heading = sky_json_get(given, "source_heading") ? number(given, "source_heading") : heading;
    pixel->to_source[0] = cos(RADIAN * pixel->source_elevation) * sin(RADIAN * heading);
    pixel->to_source[1] = cos(RADIAN * pixel->source_elevation) * cos(RADIAN * heading);
    pixel->to_source[2] = sin(RADIAN * pixel->source_elevation);
    if (sky_json_get(given, "to_source")) direction(given, "to_source", pixel->to_source);
}

/* The materials that a pixel sees: those of a texel, or one. */
static void place_materials(const struct scene *scene, const struct json *given, skyshine_pixel *pixel)
{
    const struct json *texel = sky_json_get(given, "texel");
    if (!texel) {
        pixel->materials = 1;
        pixel->material[0] = material_code(scene->tables, sky_json_get(given, "material"));
        pixel->share[0] = 1.0;
        return;
    }
    if (!scene->texture) stop("the scene lacks 'texture'");
    const struct json *across = texel->kind == JSON_LIST ? texel->children : NULL, *down = across ? across->next : NULL;
    if (!down || down->next || across->kind != JSON_NUMBER || down->kind != JSON_NUMBER) stop("'texel' must be two numbers");
    const double level = sky_json_get(given, "level") ? number(given, "level") : 0.0;
    if (!(level >= 0 && level < 1000) || level != floor(level)) stop("level: found %g; allowed: a level of the texture", level);
    skyshine_error error;
    skyshine_texture_shade(scene->texture, across->number, down->number, (unsigned)level, &pixel->shade, &error);
    check(&error);
    skyshine_texture_mixture(scene->texture, across->number, down->number, (unsigned)level, &pixel->materials, pixel->material, pixel->share, &error);
    check(&error);
}

/* Temperature of a face by the object `surroundings` of a pixel; `whole_day`: in the shade all day, under `most_sky` of the sky. */
static double shaded(const skyshine_tables *tables, const skyshine_face *face, const struct json *around, int whole_day, double most_sky)
{
    static const double ALL_DAY[][2] = {{0.0, 24.0}};
    skyshine_error error;
    double temperature;
    const struct json *list = sky_json_get(around, "shade");
    skyshine_surroundings surroundings = {NULL, 0, number_or(around, "sky_view", 1.0), number_or(around, "facing", NAN),
                                          number_or(around, "facing_emissivity", NAN)};
    for (const struct json *each = list ? list->children : NULL; each; each = each->next) ++surroundings.shade_count;
    double(*hours)[2] = allocate(surroundings.shade_count, sizeof *hours);
    size_t at = 0;
    for (const struct json *each = list ? list->children : NULL; each; each = each->next, ++at) {
        const struct json *first = each->children, *last = first ? first->next : NULL;
        if (!last || first->kind != JSON_NUMBER || last->kind != JSON_NUMBER) stop("surroundings must be finite numbers");
        hours[at][0] = first->number;
        hours[at][1] = last->number;
    }
    surroundings.shade = (const double(*)[2])hours;
    if (whole_day) {
        surroundings.shade = ALL_DAY;
        surroundings.shade_count = 1;
        surroundings.sky_view = fmin(surroundings.sky_view, most_sky);
    }
    skyshine_shaded_temperature(tables, face, &surroundings, &temperature, &error);
    check(&error);
    free(hours);
    return temperature;
}

static double heated(const skyshine_tables *tables, const skyshine_face *face, const struct json *list)
{
    skyshine_error error;
    double temperature;
    size_t count = 0, at = 0;
    for (const struct json *each = list->children; each; each = each->next) ++count;
    double *absorbed = allocate(count, sizeof *absorbed);
    for (const struct json *each = list->children; each; each = each->next) absorbed[at++] = each->kind == JSON_NUMBER ? each->number : NAN;
    skyshine_heated_temperature(tables, face, absorbed, count, &temperature, &error);
    check(&error);
    free(absorbed);
    return temperature;
}

/* Temperatures of the pixel's materials where it has surroundings or other heat; else those of the tables. */
static void place_temperatures(const struct scene *scene, const struct json *given, skyshine_pixel *pixel)
{
    const struct json *around = sky_json_get(given, "surroundings"), *list = sky_json_get(given, "absorbed_change");
    if (pixel->shade > 0.0 && !around && list && list->kind == JSON_LIST) stop("a texel in the shade takes 'surroundings' in place of 'absorbed_change'");
    const double most_sky = fmin(1.0 - pixel->hidden_sky, pixel->shaded_sky);
    for (size_t k = 0; k < pixel->materials; ++k) {
        const skyshine_face face = {pixel->material[k], pixel->surface_altitude, pixel->surface_azimuth, pixel->surface_slope, pixel->time};
        pixel->temperature[k] = pixel->shaded_temperature[k] = NAN;
        if (around && around->kind == JSON_OBJECT) {
            pixel->temperature[k] = shaded(scene->tables, &face, around, 0, 1.0);
            if (pixel->shade > 0.0) pixel->shaded_temperature[k] = shaded(scene->tables, &face, around, 1, most_sky);
        } else if (list && list->kind == JSON_LIST) pixel->temperature[k] = heated(scene->tables, &face, list);
    }
}

static struct result compute(const struct scene *scene, const struct json *given)
{
    skyshine_error error;
    skyshine_pixel pixel = {0};
    struct result result;
    pixel.time = number(given, "time");
    place_source(scene, given, &pixel);
    pixel.surface_altitude = number(given, "surface_altitude");
    pixel.surface_azimuth = number(given, "surface_azimuth");
    pixel.surface_slope = number(given, "surface_slope");
    pixel.range = number(given, "range");
    pixel.centre_range = number(given, "centre_range");
    pixel.centre_elevation = number(given, "centre_elevation");
    pixel.altitude = number(given, "altitude");
    direction(given, "normal", pixel.normal);
    direction(given, "to_observer", pixel.to_observer);
    const struct json *ground = sky_json_get(given, "ground_material");
    pixel.shaded_sky = sky_json_get(scene->root, "shaded_sky") ? number(scene->root, "shaded_sky") : SKYSHINE_SHADED_SKY;
    pixel.hidden_sky = sky_json_get(given, "sky_view") ? 1.0 - number(given, "sky_view") : 0.0;
    if (ground) pixel.ground_material = material_code(scene->tables, ground);
    place_materials(scene, given, &pixel);
    place_temperatures(scene, given, &pixel);
    skyshine_pixel_radiance(scene->tables, &pixel, &result.terms, &error);
    check(&error);
    result.material = pixel.material[0];
    result.value = skyshine_pixel_value(result.terms.radiance, (int)number(scene->root, "bits"), number(scene->root, "gain"),
                                        number(scene->root, "buffer_gain"), number(scene->root, "offset"));
    return result;
}

/* A list of numbers of a frame, one for each pixel; NULL where the frame may lack it and does. */
static double *numbers_of(const struct json *frame, const char *key, size_t count, int needed)
{
    const struct json *list = sky_json_get(frame, key);
    if (!list && !needed) return NULL;
    double *values = allocate(count, sizeof *values);
    size_t at = 0;
    for (const struct json *each = list ? list->children : NULL; each && at < count; each = each->next) {
        if (each->kind != JSON_NUMBER) stop("'%s' must be a list of numbers", key);
        values[at++] = each->number;
    }
    if (at != count) stop("'%s' must have a number for each pixel", key);
    return values;
}

/* Radiances of a frame, opened and computed as often as the scene says. */
static void show_frame(const struct scene *scene, const struct json *given)
{
    skyshine_error error;
    skyshine_frame *frame;
    const struct json *ground = sky_json_get(given, "ground_material"), *list = sky_json_get(given, "material");
    const double frames = sky_json_get(given, "frames") ? number(given, "frames") : 1.0, repeat = sky_json_get(given, "repeat") ? number(given, "repeat") : 1.0;
    const skyshine_view view = {.altitude = number(given, "altitude"), .centre_range = number(given, "centre_range"),
                                .centre_elevation = number(given, "centre_elevation"), .centre_heading = number(given, "centre_heading"),
                                .source_elevation = number(given, "source_elevation"), .source_heading = number(given, "source_heading"),
                                .time = number(given, "time"), .ground_material = ground ? material_code(scene->tables, ground) : 0,
                                .ground_altitude = ground ? number(given, "ground_altitude") : 0.0};
    size_t count = 0, at = 0;
    for (const struct json *each = list ? list->children : NULL; each; each = each->next) ++count;
    int32_t *materials = allocate(count, sizeof *materials);
    for (const struct json *each = list ? list->children : NULL; each; each = each->next) materials[at++] = material_code(scene->tables, each);
    const skyshine_pixels pixels = {materials, numbers_of(given, "range", count, 1), numbers_of(given, "elevation", count, 0),
                                    numbers_of(given, "heading", count, 0), numbers_of(given, "surface_altitude", count, 1),
                                    numbers_of(given, "surface_azimuth", count, 1), numbers_of(given, "surface_slope", count, 1),
                                    numbers_of(given, "temperature", count, 0)};
    double *radiance = allocate(count, sizeof *radiance);
    for (double f = 0; f < frames; ++f) {
        skyshine_frame_open(scene->tables, &view, &frame, &error);
        check(&error);
        for (double k = 0; k < repeat; ++k) {
            skyshine_frame_radiance(frame, &pixels, count, radiance, &error);
            check(&error);
        }
        skyshine_frame_close(frame);
    }
    printf("{\"radiance\": [");
    for (size_t i = 0; i < count; ++i) printf(i ? ", %.17g" : "%.17g", radiance[i]);
    printf("]}\n");
}

static void print(const struct result *result)
{
    const skyshine_terms *of = &result->terms;
    printf("{\"material\": %.17g, \"temperature\": %.17g, \"blackbody_radiance\": %.17g, \"beta_star\": %.17g, \"transmittance\": %.17g, "
           "\"thermal\": %.17g, \"path\": %.17g, \"skyshine\": %.17g, \"diffuse\": %.17g, \"specular\": %.17g, "
           "\"radiance\": %.17g, \"pixel_value\": %ld}",
           result->material, of->temperature, of->blackbody_radiance, of->beta_star, of->transmittance, of->thermal, of->path, of->skyshine,
           of->diffuse, of->specular, of->radiance, result->value);
}

static char *read_whole(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) stop("%s: cannot be read", path);
    size_t size = 0, room = 4096;
    char *text = allocate(room, 1);
    while (!feof(file) && !ferror(file)) {
        if (room - size < 2 && !(text = realloc(text, room *= 2))) stop("no memory is left");
        size += fread(text + size, 1, room - size - 1, file);
    }
    fclose(file);
    text[size] = 0;
    return text;
}

/* Path of a file that the scene names, relative to the scene's folder. */
static const char *path_of(const struct json *scene, const char *key, const char *scene_path)
{
    const struct json *name = sky_json_get(scene, key);
    if (!name || name->kind != JSON_TEXT) stop("the scene lacks '%s'", key);
    const char *slash = name->text[0] == '/' ? NULL : strrchr(scene_path, '/');
    const int folder = slash ? (int)(slash - scene_path + 1) : 0;
    char *path = allocate(PATH_SIZE, 1);
    if (snprintf(path, PATH_SIZE, "%.*s%s", folder, scene_path, name->text) >= PATH_SIZE) stop("the path of '%s' is too long", key);
    return path;
}

/* The texts of a list, with NULL behind the last one. */
static const char **texts_of(const struct json *list)
{
    size_t count = 0;
    for (const struct json *each = list ? list->children : NULL; each; each = each->next) ++count;
    const char **texts = allocate(count + 1, sizeof *texts);
    count = 0;
    for (const struct json *each = list ? list->children : NULL; each; each = each->next)
        if (each->kind == JSON_TEXT) texts[count++] = each->text;
    return texts;
}

int main(int count, char **arguments)
{
    if (count != 2) stop("usage: runtime SCENE.json");
    skyshine_error error;
    struct scene scene = {.root = sky_json_parse(read_whole(arguments[1]), allocate)};
    if (!scene.root) stop("%s: is not JSON", arguments[1]);
    const struct json *pixels = sky_json_get(scene.root, "pixels");
    const struct json *frame = sky_json_get(scene.root, "frame");
    if (!frame && (!pixels || pixels->kind != JSON_LIST)) stop("the scene lacks the list 'pixels'");
    skyshine_open_files(path_of(scene.root, "surface", arguments[1]), path_of(scene.root, "band", arguments[1]),
                        path_of(scene.root, "atmosphere", arguments[1]), texts_of(sky_json_get(scene.root, "clamp")), &scene.tables, &error);
    check(&error);
    if (sky_json_get(scene.root, "texture")) {
        skyshine_texture_open(path_of(scene.root, "texture", arguments[1]), &scene.texture, &error);
        check(&error);
    }
    if (frame) {
        show_frame(&scene, frame);
        skyshine_texture_close(scene.texture);
        skyshine_close(scene.tables);
        return 0;
    }
    size_t total = 0, done = 0;
    for (const struct json *each = pixels->children; each; each = each->next) ++total;
    struct result *computed = allocate(total, sizeof *computed); /* nothing is printed where one pixel fails */
    for (const struct json *each = pixels->children; each; each = each->next) computed[done++] = compute(&scene, each);
    printf("{\"pixels\": [");
    for (size_t i = 0; i < total; ++i) {
        if (i) printf(", ");
        print(&computed[i]);
    }
    printf("]}\n");
    free(computed);
    skyshine_texture_close(scene.texture);
    skyshine_close(scene.tables);
    return 0;
}
