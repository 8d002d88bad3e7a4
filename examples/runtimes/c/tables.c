/* The tables of a state, a band and a source: opened, and read at one place by the kernel. */
#include "tables.h"
#include "failure.h"
#include "json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };
static const double DAY = 24.0;

/* Memory of the call at a multiple of 64 bytes. */
static void *aligned(size_t size)
{
    char *memory = sky_allocate(size + ALIGNMENT, 1);
    return memory + (ALIGNMENT - (uintptr_t)memory % ALIGNMENT) % ALIGNMENT;
}

static void *scratch_of(const skyshine_tables *tables)
{
    return aligned(skyshine_scratch_size(tables->kernel));
}

static void open_files(skyshine_tables *tables, const char *surface, const char *band, const char *air, const char *const *clamp)
{
    SkyFailure failure;
    sky_open_database(&tables->surface, surface, SKY_SURFACE, clamp);
    sky_open_database(&tables->band, band, SKY_BAND, clamp);
    sky_open_database(&tables->air, air, SKY_AIR, clamp);
    SkyDatabase *of[] = {tables->surface.arrays, tables->band.arrays, tables->air.arrays};
    if (*tables->air.ground_material) skyshine_set_number(of[2], SKY_GROUND_CODE, sky_code_of(&tables->surface, tables->air.ground_material));
    tables->kernel = aligned(skyshine_tables_size(of[0], of[1], of[2]));
    sky_check(skyshine_tables_make(tables->kernel, of[0], of[1], of[2], &failure), &failure, band, -1);
    tables->memory = sky_keep();
}

skyshine_status skyshine_open_files(const char *surface, const char *band, const char *atmosphere, const char *const *clamp,
                                    skyshine_tables **tables, skyshine_error *error)
{
    struct call call;
    skyshine_tables *opened = calloc(1, sizeof *opened);
    sky_begin(&call, SKYSHINE_FILE_ERROR);
    if (!setjmp(call.failed)) {
        if (!opened) sky_fail("no memory is left");
        open_files(opened, surface, band, atmosphere, clamp);
        *tables = opened;
    } else {
        free(opened);
    }
    return sky_end(&call, error);
}

void skyshine_close(skyshine_tables *tables)
{
    if (!tables) return;
    sky_release_all(tables->memory);
    free(tables);
}

static const struct json *read_catalog(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) sky_fail("%s: cannot be read", path);
    const long size = fseek(file, 0, SEEK_END) ? -1 : ftell(file);
    char *text = size > 0 && size < 1 << 28 ? calloc((size_t)size + 1, 1) : NULL;
    const int read = text && !fseek(file, 0, SEEK_SET) && fread(text, 1, (size_t)size, file) == (size_t)size;
    fclose(file);
    char *kept = sky_allocate(read ? (size_t)size + 1 : 1, 1);
    if (read) memcpy(kept, text, (size_t)size);
    free(text);
    const struct json *files = sky_json_get(sky_json_parse(kept, sky_allocate), "files");
    if (!files || files->kind != JSON_LIST) sky_fail("%s: is not a catalogue of databases", path);
    return files;
}

/* Whether an entry has a number, or needs none. */
static int is_of(const struct json *entry, const char *key, int wanted)
{
    const struct json *number = sky_json_get(entry, key);
    return !wanted || (number && number->kind == JSON_NUMBER && number->number == wanted);
}

/* Path of the file of a type that a catalogue lists for a state and a band; 0 where it needs none of them. */
static const char *listed(const struct json *files, const char *folder, const char *filetype, int state, int band)
{
    for (const struct json *entry = files->children; entry; entry = entry->next) {
        const struct json *type = sky_json_get(entry, "filetype"), *name = sky_json_get(entry, "file");
        if (!type || type->kind != JSON_TEXT || strcmp(type->text, filetype) || !is_of(entry, "state", state) || !is_of(entry, "band", band)) continue;
        if (!name || name->kind != JSON_TEXT || strpbrk(name->text, "/\\")) sky_fail("%s: its catalogue names a file elsewhere", folder);
        const size_t size = strlen(folder) + strlen(name->text) + 2;
        char *path = sky_allocate(size, 1);
        snprintf(path, size, "%s/%s", folder, name->text);
        return path;
    }
    sky_fail("%s: its catalogue lists no '%s' of state %d and band %d", folder, filetype, state, band);
}

skyshine_status skyshine_open(const char *folder, int state, int band, skyshine_source source, const char *const *clamp,
                              skyshine_tables **tables, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_FILE_ERROR);
    if (!setjmp(call.failed)) {
        if (state < 1 || band < 1) sky_fail("found state %d, band %d; allowed: numbers from 1", state, band);
        const size_t size = strlen(folder) + sizeof "/catalog.json";
        char *path = sky_allocate(size, 1);
        snprintf(path, size, "%s/catalog.json", folder);
        const struct json *files = read_catalog(path);
        const char *surface = listed(files, folder, "htt", state, 0), *spectral = listed(files, folder, "band", 0, band);
        const char *air = listed(files, folder, source == SKYSHINE_MOON ? "lunar_atmq" : "atmq", state, band);
        if (skyshine_open_files(surface, spectral, air, clamp, tables, error)) {
            call.status = SKYSHINE_FILE_ERROR;
            if (error) {
                call.status = error->status;
                memcpy(call.message, error->message, sizeof call.message);
            }
        }
    }
    return sky_end(&call, error);
}

size_t skyshine_materials(const skyshine_tables *tables, const int32_t **codes, const char *const **names)
{
    if (codes) *codes = tables->band.codes;
    if (names) *names = tables->band.names;
    return tables->band.materials;
}

/* The kernel is asked in here; a refusal leaves the call. */
#define CALL(asked) \
    struct call call; \
    sky_begin(&call, SKYSHINE_VALUE_ERROR); \
    if (!setjmp(call.failed)) { \
        SkyFailure failure; \
        sky_check(asked, &failure, NULL, -1); \
    } \
    return sky_end(&call, error)

#define FACE {&face->material, &face->altitude, &face->azimuth, &face->slope}
#define PLACE(last) {&line->range, &line->altitude, &line->elevation, &line->source_elevation, last}

skyshine_status skyshine_temperature(const skyshine_tables *tables, const skyshine_face *face, double *temperature, skyshine_error *error)
{
    const SkyFaces faces = FACE;
    CALL(skyshine_temperatures(tables->kernel, 1, &faces, &face->time, temperature, &failure));
}

/* Share of a step of the day in the shade, of intervals that do not overlap. */
static double shaded_share(const skyshine_surroundings *around, double hour)
{
    const double step = DAY / SKY_STEPS, first = hour - step / 2, last = hour + step / 2;
    double covered = 0;
    for (size_t i = 0; i < around->shade_count; ++i) {
        const double begin = around->shade[i][0], given = around->shade[i][1], end = given < begin ? given + DAY : given;
        if (!isfinite(begin) || !isfinite(given)) sky_fail("surroundings must be finite numbers");
        for (int turn = -1; turn <= 1; ++turn) covered += fmax(fmin(last, end + turn * DAY) - fmax(first, begin + turn * DAY), 0.0);
    }
    return fmin(covered / step, 1.0);
}

skyshine_status skyshine_shaded_temperature(const skyshine_tables *tables, const skyshine_face *face, const skyshine_surroundings *surroundings,
                                            double *temperature, skyshine_error *error)
{
    struct call call;
    const SkyFaces faces = FACE;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        SkyFailure failure;
        double shaded[SKY_STEPS], absorbed[SKY_STEPS], facing = surroundings->facing < 0 ? NAN : surroundings->facing;
        for (size_t k = 0; k < SKY_STEPS; ++k) shaded[k] = shaded_share(surroundings, (double)k * DAY / SKY_STEPS);
        const SkySurroundings around = {shaded, &surroundings->sky_view, &facing, &surroundings->facing_emissivity};
        void *scratch = scratch_of(tables);
        sky_check(skyshine_absorbed(tables->kernel, 1, &faces, &around, 0, absorbed, scratch, &failure), &failure, NULL, -1);
        sky_check(skyshine_heated(tables->kernel, 1, &faces, absorbed, SKY_STEPS, &face->time, 1, temperature, scratch, &failure), &failure, NULL, -1);
    }
    return sky_end(&call, error);
}

skyshine_status skyshine_heated_temperature(const skyshine_tables *tables, const skyshine_face *face, const double *absorbed, size_t count,
                                            double *temperature, skyshine_error *error)
{
    struct call call;
    const SkyFaces faces = FACE;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        SkyFailure failure;
        if (!count) sky_fail("absorbed_change must be a list of finite numbers");
        sky_check(skyshine_heated(tables->kernel, 1, &faces, absorbed, count, &face->time, 1, temperature, scratch_of(tables), &failure), &failure, NULL, -1);
    }
    return sky_end(&call, error);
}

static double quantity_of(const skyshine_tables *tables, int32_t quantity, const skyshine_line *line)
{
    SkyFailure failure;
    double value;
    const SkyPlaces place = PLACE(&line->source_azimuth);
    sky_check(skyshine_quantity(tables->kernel, quantity, 0, 1, &place, &value, scratch_of(tables), &failure), &failure, NULL, -1);
    return value;
}

skyshine_status skyshine_transmittance(const skyshine_tables *tables, const skyshine_line *line, double *transmittance, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) *transmittance = exp(-5.5 * line->range / quantity_of(tables, SKY_BETA_STAR, line));
    return sky_end(&call, error);
}

skyshine_status skyshine_path_radiance(const skyshine_tables *tables, const skyshine_line *line, double *radiance, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        const double ratio = quantity_of(tables, SKY_PATH_RATIO, line);
        *radiance = ratio * -expm1(-5.5 * line->range / quantity_of(tables, SKY_BETA_STAR, line));
    }
    return sky_end(&call, error);
}

skyshine_status skyshine_ambient_radiance(const skyshine_tables *tables, const skyshine_line *line, double slope, double azimuth,
                                          double *radiance, skyshine_error *error)
{
    const SkyPlaces place = PLACE(NULL);
    CALL(skyshine_ambient(tables->kernel, 0, 1, &place, &slope, &azimuth, NULL, radiance, scratch_of(tables), &failure));
}

skyshine_status skyshine_direct_radiance(const skyshine_tables *tables, const skyshine_line *line, double *radiance, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) *radiance = quantity_of(tables, SKY_DIRECT, line);
    return sky_end(&call, error);
}

/* A track of Sun or Moon at a time. */
static double track_of(const skyshine_tables *tables, const char *name, double time)
{
    SkyFailure failure;
    double value;
    int32_t number = 0;
    while (strcmp(skyshine_array_name(SKY_SURFACE, number), name)) ++number;
    sky_check(skyshine_read(tables->kernel, SKY_SURFACE, number, 1, &time, &value, &failure), &failure, NULL, -1);
    return value;
}

skyshine_status skyshine_source_position(const skyshine_tables *tables, double time, double *elevation, double *heading, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        if (!skyshine_has(tables->surface.arrays, "sun_elevation")) sky_fail("the surface file has no tracks of Sun and Moon");
        const double up = track_of(tables, tables->air.lunar ? "moon_elevation" : "sun_elevation", time);
        *heading = track_of(tables, tables->air.lunar ? "moon_azimuth" : "sun_azimuth", time);
        *elevation = up;
    }
    return sky_end(&call, error);
}

skyshine_status skyshine_apparent_temperature(const skyshine_tables *tables, double radiance, double *temperature, skyshine_error *error)
{
    CALL(skyshine_apparent_temperatures(tables->kernel, 1, &radiance, temperature, &failure));
}

/* ---- Pixels ---- */

static void check_pixel(const skyshine_tables *tables, int32_t status, const SkyFailure *failure, long long first)
{
    const char *ground = tables->air.ground_material;
    if (status == SKY_NO_GROUND && *ground) sky_fail("%s: names the ground '%s', a material that the surface file lacks", tables->air.path, ground);
    if (status == SKY_NO_GROUND) sky_fail("%s: does not state the temperature of the ground", tables->air.path);
    sky_check(status, failure, NULL, first);
}

static int32_t pixel_of(const skyshine_tables *tables, const skyshine_pixel *pixel, skyshine_terms *terms, void *scratch, SkyFailure *failure)
{
    const double sky_view = 1.0 - pixel->hidden_sky;
    const SkyPixels pixels = {
        .material = pixel->material, .share = pixel->share, .temperature = pixel->temperature,
        .surface_altitude = &pixel->surface_altitude, .surface_azimuth = &pixel->surface_azimuth, .surface_slope = &pixel->surface_slope,
        .time = &pixel->time, .range = &pixel->range, .line_range = &pixel->centre_range, .altitude = &pixel->altitude,
        .elevation = &pixel->centre_elevation, .source_elevation = &pixel->source_elevation, .source_azimuth = &pixel->source_azimuth,
        .source_heading = isnan(pixel->source_heading) ? NULL : &pixel->source_heading, .normal = pixel->normal,
        .to_source = pixel->to_source, .to_observer = pixel->to_observer, .sky_view = &sky_view, .shade = &pixel->shade,
        .shaded_sky = &pixel->shaded_sky, .shaded_temperature = pixel->shaded_temperature, .ground_material = &pixel->ground_material,
    };
    const SkyTerms to = {&terms->temperature, &terms->blackbody_radiance, &terms->beta_star, &terms->transmittance, &terms->thermal,
                         &terms->path, &terms->skyshine, &terms->diffuse, &terms->specular, &terms->radiance};
    return skyshine_pixel_terms(tables->kernel, 1, pixel->materials, 1, &pixels, &to, scratch, failure);
}

skyshine_status skyshine_pixel_radiance(const skyshine_tables *tables, const skyshine_pixel *pixel, skyshine_terms *terms, skyshine_error *error)
{
    struct call call;
    skyshine_terms computed;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        SkyFailure failure;
        if (pixel->materials < 1 || pixel->materials > SKYSHINE_COMPONENTS)
            sky_fail("materials: found %zu; allowed: 1 to %d", pixel->materials, SKYSHINE_COMPONENTS);
        if (!(pixel->hidden_sky >= 0.0 && pixel->hidden_sky <= 1.0)) sky_fail("hidden_sky: found %g; allowed: 0 to 1", pixel->hidden_sky);
        check_pixel(tables, pixel_of(tables, pixel, &computed, scratch_of(tables), &failure), &failure, -1);
        *terms = computed;
    }
    return sky_end(&call, error);
}

long skyshine_pixel_value(double radiance, int bits, double gain, double buffer_gain, double offset)
{
    return (long)skyshine_value_of_pixel(radiance, bits, gain, buffer_gain, offset);
}

/* ---- Frames ---- */

enum { BLOCK = 4096 }; /* pixels for which times and ground are written down together */

struct skyshine_frame {
    const skyshine_tables *tables;
    skyshine_view view;
    double azimuth, ground; /* of the source from the centre's line; temperature of the ground, NaN: that of the file */
};

static void make_frame(skyshine_frame *frame, const skyshine_tables *tables, const skyshine_view *view)
{
    SkyFailure failure;
    const double level = 0.0;
    const SkyFaces ground = {&view->ground_material, &view->ground_altitude, &level, &level};
    *frame = (skyshine_frame){tables, *view, view->source_heading - view->centre_heading, NAN};
    if (!isfinite(frame->azimuth)) sky_fail("heading: found %g, %g; allowed: finite numbers", view->centre_heading, view->source_heading);
    if (view->ground_material)
        sky_check(skyshine_temperatures(tables->kernel, 1, &ground, &view->time, &frame->ground, &failure), &failure, NULL, -1);
    const skyshine_line line = {view->centre_range, view->altitude, view->centre_elevation, view->source_elevation, frame->azimuth};
    quantity_of(tables, SKY_PATH_RATIO, &line);
}

skyshine_status skyshine_frame_open(const skyshine_tables *tables, const skyshine_view *view, skyshine_frame **frame, skyshine_error *error)
{
    struct call call;
    skyshine_frame *opened = calloc(1, sizeof *opened);
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        if (!opened) sky_fail("no memory is left");
        make_frame(opened, tables, view);
        *frame = opened;
    } else {
        free(opened);
    }
    return sky_end(&call, error);
}

void skyshine_frame_close(skyshine_frame *frame)
{
    free(frame);
}

/* A list from a place on, NULL where there is none. */
static const double *from(const double *list, size_t place)
{
    return list ? list + place : NULL;
}

static int32_t block_of(const skyshine_frame *frame, const skyshine_pixels *given, size_t first, size_t count, const double *time,
                        const double *ground, double *radiance, void *scratch, SkyFailure *failure)
{
    const skyshine_view *view = &frame->view;
    const SkyPixels pixels = {
        .material = given->material + first, .temperature = from(given->temperature, first),
        .surface_altitude = given->surface_altitude ? given->surface_altitude + first : ground, /* only where temperatures are given */
        .surface_azimuth = given->surface_azimuth + first, .surface_slope = given->surface_slope + first, .time = time,
        .range = given->range + first, .line_range = &view->centre_range, .altitude = &view->altitude,
        .elevation = &view->centre_elevation, .source_elevation = &view->source_elevation, .source_azimuth = &frame->azimuth,
        .source_heading = &view->source_heading, .sight_elevation = from(given->elevation, first), .sight_heading = from(given->heading, first),
        .ground_temperature = view->ground_material ? ground : NULL,
    };
    const SkyTerms terms = {.radiance = radiance + first};
    return skyshine_pixel_terms(frame->tables->kernel, count, 1, 1, &pixels, &terms, scratch, failure);
}

skyshine_status skyshine_frame_radiance(const skyshine_frame *frame, const skyshine_pixels *pixels, size_t count, double *radiance,
                                        skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        SkyFailure failure;
        void *scratch = scratch_of(frame->tables);
        double *time = sky_allocate(2 * BLOCK, sizeof *time), *ground = time + BLOCK;
        for (size_t k = 0; k < BLOCK; ++k) time[k] = frame->view.time, ground[k] = frame->ground;
        for (size_t first = 0; first < count; first += BLOCK) {
            const size_t number = count - first < BLOCK ? count - first : BLOCK;
            check_pixel(frame->tables, block_of(frame, pixels, first, number, time, ground, radiance, scratch, &failure), &failure, (long long)first);
        }
    }
    return sky_end(&call, error);
}
