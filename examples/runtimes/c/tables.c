/* The tables of a state, a band and a source: opened, and read at one place. */
#include "tables.h"
#include "channels.h"
#include "json.h"
#include "shade.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double RADIAN = 0.017453292519943295;

static void open_files(skyshine_tables *tables, const char *surface, const char *band, const char *air, const char *const *clamp)
{
    sky_open_database(&tables->surface, surface, "htt", clamp);
    sky_open_database(&tables->band, band, "band", clamp);
    sky_open_database(&tables->air, air, "atmq", clamp);
    sky_compare_wavelengths(&tables->air, &tables->band);
    const struct axis *materials = &sky_array_of(&tables->band, "reflectance")->axes[0];
    tables->codes = sky_allocate(materials->count, sizeof *tables->codes);
    for (size_t i = 0; i < materials->count; ++i) tables->codes[i] = (int32_t)materials->nodes[i];
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
    if (codes) *codes = tables->codes;
    if (names) *names = tables->band.material_names;
    return sky_array_of(&tables->band, "reflectance")->axes[0].count;
}

skyshine_status skyshine_temperature(const skyshine_tables *tables, const skyshine_face *face, double *temperature, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed))
        *temperature = sky_value_at(&tables->surface, "temperature", (double[]){face->material, face->altitude, face->azimuth, face->slope, face->time});
    return sky_end(&call, error);
}

skyshine_status skyshine_shaded_temperature(const skyshine_tables *tables, const skyshine_face *face, const skyshine_surroundings *surroundings,
                                            double *temperature, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed))
        *temperature = sky_temperature_beside(&tables->surface, (double[]){face->material, face->altitude, face->azimuth, face->slope, face->time}, surroundings);
    return sky_end(&call, error);
}

skyshine_status skyshine_heated_temperature(const skyshine_tables *tables, const skyshine_face *face, const double *absorbed, size_t count,
                                            double *temperature, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed))
        *temperature = sky_temperature_under(&tables->surface, (double[]){face->material, face->altitude, face->azimuth, face->slope, face->time}, absorbed, count);
    return sky_end(&call, error);
}

skyshine_status skyshine_transmittance(const skyshine_tables *tables, const skyshine_line *line, double *transmittance, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed))
        *transmittance = exp(-5.5 * line->range / sky_quantity_at(&tables->air, "beta_star", (double[]){line->range, line->altitude, line->elevation}));
    return sky_end(&call, error);
}

skyshine_status skyshine_path_radiance(const skyshine_tables *tables, const skyshine_line *line, double *radiance, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        const double place[] = {line->range, line->altitude, line->elevation, line->source_elevation, line->source_azimuth};
        const double ratio = sky_path_ratio_at(&tables->air, place);
        *radiance = ratio * -expm1(-5.5 * line->range / sky_quantity_at(&tables->air, "beta_star", place));
    }
    return sky_end(&call, error);
}

skyshine_status skyshine_ambient_radiance(const skyshine_tables *tables, const skyshine_line *line, double slope, double azimuth,
                                          double *radiance, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        const struct database *air = &tables->air;
        const double place[] = {line->range, line->altitude, line->elevation, line->source_elevation, line->source_azimuth};
        if (!isfinite(slope) || !isfinite(azimuth) || (!air->tilted && slope != 0.0))
            sky_fail("slope: found %g; allowed: %s", slope, air->tilted ? "finite numbers" : "0, as the file holds no harmonics");
        double bases[BASES] = {1.0}, weights[BASES], light = 0.0;
        const size_t count = sky_ambient_weights(air, place, air->tilted, &air->ground[1], 1, weights);
        const double tilt = RADIAN * slope, turn = RADIAN * azimuth;
        if (air->tilted) sky_bases(air, (double[]){sin(tilt) * cos(turn), sin(tilt) * sin(turn), cos(tilt)}, bases);
        for (size_t k = 0; k < count; ++k) light += bases[k] * weights[k];
        *radiance = fmax(light, 0.0);
    }
    return sky_end(&call, error);
}

skyshine_status skyshine_direct_radiance(const skyshine_tables *tables, const skyshine_line *line, double *radiance, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed))
        *radiance = sky_quantity_at(&tables->air, "direct_radiance", (double[]){line->range, line->altitude, line->elevation, line->source_elevation});
    return sky_end(&call, error);
}

skyshine_status skyshine_source_position(const skyshine_tables *tables, double time, double *elevation, double *heading, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        if (!tables->surface.tracked) sky_fail("the surface file holds no tracks of Sun and Moon");
        const double up = sky_value_at(&tables->surface, tables->air.lunar ? "moon_elevation" : "sun_elevation", &time);
        *heading = sky_value_at(&tables->surface, tables->air.lunar ? "moon_azimuth" : "sun_azimuth", &time);
        *elevation = up;
    }
    return sky_end(&call, error);
}

static double temperature_of(const struct database *band, double radiance)
{
    const struct array *array = sky_array_of(band, "blackbody_radiance");
    const struct axis *axis = &array->axes[0];
    const double first = array->values[0], last = array->values[axis->count - 1];
    if (!(radiance >= first && radiance <= last)) sky_fail("radiance: found %g; allowed: %g to %g", radiance, first, last);
    size_t lower = 0, above = axis->count;
    while (above - lower > 1) {
        const size_t middle = (lower + above) / 2;
        if (array->values[middle] <= radiance) lower = middle;
        else above = middle;
    }
    if (above == axis->count) return axis->nodes[lower];
    const double rise = (double)array->values[above] - array->values[lower];
    return axis->nodes[lower] + (rise > 0 ? (radiance - array->values[lower]) / rise : 0.0) * (axis->nodes[above] - axis->nodes[lower]);
}

skyshine_status skyshine_apparent_temperature(const skyshine_tables *tables, double radiance, double *temperature, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) *temperature = temperature_of(&tables->band, radiance);
    return sky_end(&call, error);
}
