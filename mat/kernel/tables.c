/* Tables of a surface, a band and an atmosphere, arranged for lines of sight, and reading single arrays. */
#include "export.h"
#include "pixel_tables.h"

enum { PARTS_OF_CELL = 4 };
static const double SAME_WAVELENGTH = 1e-6; /* relative */

/* Equal parts of an axis: for each the last node up to the beginning of the part before it, for the division that finds
 * the part of a value rounds. */
static void search_cells(Axis *axis, Arena *arena) {
    int32_t parts = axis->count > 1 ? (int32_t)(PARTS_OF_CELL * axis->count) : 1;
    int32_t *cells = take(arena, (size_t)parts + 3, sizeof *cells);
    axis->parts = parts;
    axis->cells = cells;
    axis->first = axis->nodes[0];
    axis->last = axis->rule == SKY_PERIODIC ? axis->first + axis->period : axis->nodes[axis->count - 1];
    axis->parts_per_length = axis->last > axis->first ? parts / (axis->last - axis->first) : 0;
    if (!cells) return;
    double length = (axis->last - axis->first) / parts;
    for (int32_t part = 0, at = 0; part <= parts + 2; part++) {
        while ((size_t)at + 1 < axis->count && axis->nodes[at + 1] <= axis->first + (part - 1) * length) at++;
        cells[part] = at;
    }
}

static void take_database(SkyDatabase *to, const SkyDatabase *from, Arena *arena) {
    *to = (SkyDatabase){.kind = -1};
    if (!from) return;
    *to = *from;
    for (int32_t i = 0; i < SKY_ARRAYS; i++)
        for (int32_t k = 0; k < to->arrays[i].rank; k++) search_cells(&to->arrays[i].axes[k], arena);
}

/* Rows of numbers in double precision, padded with zeros; of an array of two axes, or with them exchanged. */
static const double *padded_rows(const Array *array, size_t rows, size_t count, int exchanged, Arena *arena) {
    size_t row = row_of(count);
    double *to = take(arena, rows * row, sizeof *to);
    for (size_t i = 0; to && i < rows; i++)
        for (size_t j = 0; j < row; j++)
            to[i * row + j] = j < count ? array->values[exchanged ? j * rows + i : i * count + j] : 0;
    return to;
}

/* An array (parts, nodes, codes) as (nodes, parts, codes). */
static Light take_light(const SkyTables *tables, int32_t array, int codes, Arena *arena) {
    const Array *values = &tables->air.arrays[array], *factor = &tables->air.arrays[array + 1];
    Light light = {.parts = values->axes[0].count, .codes = codes ? values->axes[values->rank - 1].count : 1};
    size_t nodes = 1;
    for (int32_t k = 1; k < values->rank - codes; k++) nodes *= values->axes[k].count;
    float *to = take(arena, nodes * light.parts * light.codes, sizeof *to);
    for (size_t q = 0; to && q < light.parts; q++)
        for (size_t n = 0; n < nodes; n++)
            for (size_t h = 0; h < light.codes; h++)
                to[(n * light.parts + q) * light.codes + h] = values->values[(q * nodes + n) * light.codes + h];
    light.values = to;
    light.factor = padded_rows(factor, light.parts, tables->channels, 1, arena);
    return light;
}

/* Numbers of each place of a line together. */
static void take_fields(SkyTables *tables, Arena *arena) {
    const Array *arrays = tables->air.arrays, *extinction = &arrays[LOG_EXTINCTION];
    size_t places = extinction->axes[1].count * extinction->axes[2].count * extinction->axes[3].count, row = tables->field_row;
    float *to = take(arena, places * row, sizeof *to);
    tables->field = to;
    if (!to) return;
    const int32_t order[] = {LOG_EXTINCTION, SCATTERED_RATIO, THERMAL_RATIO, END_RISE};
    for (size_t k = 0; k < places * row; k++) to[k] = 0;
    size_t column = 0;
    for (int k = 0; k < 4; k++) {
        const Array *array = &arrays[order[k]];
        if (!array->values) continue;
        size_t parts = array->rank == 4 ? array->axes[0].count : 1;
        for (size_t q = 0; q < parts; q++, column++)
            for (size_t n = 0; n < places; n++) to[n * row + column] = array->values[q * places + n];
    }
}

static void take_source_factor(SkyTables *tables, Arena *arena) {
    const Array *array = &tables->air.arrays[SOURCE_FACTOR];
    size_t nodes = array->axes[1].count * array->axes[2].count, parts = tables->source_parts;
    float *to = take(arena, nodes * parts, sizeof *to);
    tables->source_factor = to;
    for (size_t n = 0; to && n < nodes; n++)
        for (size_t q = 0; q < parts; q++) to[n * parts + q] = array->values[q * nodes + n];
}

/* Share of each wavelength in all emitted light, by channel; where nothing is emitted there is none. */
static void take_shares(SkyTables *tables, Arena *arena) {
    const Array *arrays = tables->air.arrays;
    const float *emitted = arrays[THERMAL_REFERENCE].values, *share = arrays[THERMAL_SHARE].values;
    size_t row = tables->wavelength_row, count = tables->wavelengths;
    double *to = take(arena, tables->channels * row, sizeof *to), *dark = take(arena, row, sizeof *dark);
    tables->thermal_share = padded_rows(&arrays[THERMAL_SHARE], tables->channels, count, 0, arena);
    tables->source_share = padded_rows(&arrays[SOURCE_SHARE], tables->channels, count, 0, arena);
    tables->emitted_share = to;
    tables->dark = dark;
    if (!to) return;
    for (size_t b = 0; b < row; b++) {
        double all = 0;
        for (size_t j = 0; b < count && j < tables->channels; j++) all += (double)emitted[j] * share[j * count + b];
        dark[b] = b < count && !(all > 0);
        for (size_t j = 0; j < tables->channels; j++)
            to[j * row + b] = all > 0 ? (double)emitted[j] * share[j * count + b] / all : 0;
    }
}

static void take_air(SkyTables *tables, Arena *arena) {
    const Array *arrays = tables->air.arrays;
    tables->channels = arrays[ABSORBER_FACTOR].axes[0].count;
    tables->channel_row = row_of(tables->channels);
    tables->wavelengths = arrays[THERMAL_SHARE].axes[1].count;
    tables->wavelength_row = row_of(tables->wavelengths);
    tables->absorbers = arrays[ABSORBER_FACTOR].axes[1].count;
    tables->source_parts = arrays[SCATTERED_RATIO].axes[0].count;
    tables->fields = tables->absorbers + tables->source_parts + 1 + (arrays[END_RISE].values != 0);
    tables->field_row = row_of(tables->fields);
    tables->tilted = arrays[SCATTERED_HARMONICS].values != 0;
    take_fields(tables, arena);
    take_source_factor(tables, arena);
    tables->absorber_factor = padded_rows(&arrays[ABSORBER_FACTOR], tables->absorbers, tables->channels, 1, arena);
    tables->weight = padded_rows(&arrays[CHANNEL_WEIGHT], 1, tables->channels, 0, arena);
    tables->thermal_reference = padded_rows(&arrays[THERMAL_REFERENCE], 1, tables->channels, 0, arena);
    tables->source_reference = padded_rows(&arrays[SOURCE_REFERENCE], 1, tables->channels, 0, arena);
    take_shares(tables, arena);
    tables->direct = take_light(tables, DIRECT_LIGHT, 0, arena);
    tables->thermal_sky = take_light(tables, THERMAL_SKY, 0, arena);
    tables->scattered_sky = take_light(tables, SCATTERED_SKY, 0, arena);
    if (!tables->tilted) return;
    tables->thermal_harmonics = take_light(tables, THERMAL_HARMONICS, 1, arena);
    tables->scattered_harmonics = take_light(tables, SCATTERED_HARMONICS, 1, arena);
    tables->ground_harmonics = take_light(tables, GROUND_HARMONICS, 1, arena);
    tables->harmonics = tables->scattered_harmonics.codes;
    tables->zonal = tables->ground_harmonics.codes;
    tables->ground_emission =
        padded_rows(&arrays[GROUND_EMISSION], arrays[GROUND_EMISSION].axes[0].count, tables->channels, 0, arena);
}

/* Sum over wavelengths of a spectrum times the share of each in the light of the channels: (channel_row). */
static void in_channels(const SkyTables *tables, const double *spectrum, const double *share, double *to) {
    size_t row = tables->wavelength_row;
    for (size_t j = 0; j < tables->channel_row; j++) {
        double sum = 0;
        for (size_t b = 0; j < tables->channels && b < tables->wavelengths; b++) sum += spectrum[b] * share[j * row + b];
        to[j] = sum;
    }
}

static void take_band(SkyTables *tables, Arena *arena) {
    const Array *spectrum = &tables->band.arrays[REFLECTANCE_SPECTRUM], *share = &tables->band.arrays[EMISSION_SHARE];
    size_t materials = tables->materials = spectrum->axes[0].count, planck = tables->planck = share->axes[0].count;
    size_t wavelengths = spectrum->axes[1].count, row = row_of(wavelengths), channels = tables->channel_row;
    tables->wavelengths = wavelengths;
    tables->wavelength_row = row;
    tables->reflectance = padded_rows(spectrum, materials, wavelengths, 0, arena);
    tables->emission = padded_rows(share, planck, wavelengths, 0, arena);
    if (tables->air.kind < 0) return;
    double *emits = take(arena, materials * planck * channels, sizeof *emits), *glows = take(arena, planck * channels, sizeof *glows);
    double *emits_dark = take(arena, materials * planck, sizeof *emits), *glows_dark = take(arena, planck, sizeof *glows);
    double *thermal = take(arena, materials * channels, sizeof *thermal), *source = take(arena, materials * channels, sizeof *source);
    double *product = take(arena, row, sizeof *product);
    tables->emits = emits, tables->glows = glows, tables->emits_dark = emits_dark, tables->glows_dark = glows_dark;
    tables->reflects_thermal = thermal, tables->reflects_source = source;
    if (!emits) return;
    for (size_t m = 0; m < materials; m++) {
        const double *rho = tables->reflectance + m * row;
        in_channels(tables, rho, tables->thermal_share, thermal + m * channels);
        in_channels(tables, rho, tables->source_share, source + m * channels);
        for (size_t n = 0; n < planck; n++) {
            emits_dark[m * planck + n] = glows_dark[n] = 0;
            for (size_t b = 0; b < row; b++) {
                product[b] = (1 - rho[b]) * tables->emission[n * row + b];
                emits_dark[m * planck + n] += product[b] * tables->dark[b];
                glows_dark[n] += tables->emission[n * row + b] * tables->dark[b];
            }
            in_channels(tables, product, tables->emitted_share, emits + (m * planck + n) * channels);
            if (m == 0) in_channels(tables, tables->emission + n * row, tables->emitted_share, glows + n * channels);
        }
    }
}

static int32_t compare_wavelengths(const SkyDatabase *band, const SkyDatabase *air, SkyFailure *failure) {
    const Axis *ours = &air->arrays[THERMAL_SHARE].axes[1], *theirs = &band->arrays[EMISSION_SHARE].axes[1];
    int equal = ours->count == theirs->count && band->arrays[REFLECTANCE_SPECTRUM].axes[1].count == theirs->count;
    for (size_t b = 0; equal && b < ours->count; b++) {
        double apart = ours->nodes[b] - theirs->nodes[b], most = SAME_WAVELENGTH * theirs->nodes[b];
        equal = apart <= most && -apart <= most;
    }
    if (equal) return SKY_OK;
    return refuse(failure, SKY_BANDS, SKY_BAND, 0, "band_wavelength", (double)theirs->count, theirs->nodes[0], theirs->nodes[theirs->count - 1]);
}

static void arrange(SkyTables *tables, const SkyDatabase *surface, const SkyDatabase *band, const SkyDatabase *air, Arena *arena) {
    *tables = (SkyTables){.wavelengths = 1, .wavelength_row = 8};
    take_database(&tables->surface, surface, arena);
    take_database(&tables->band, band, arena);
    take_database(&tables->air, air, arena);
    if (air) take_air(tables, arena);
    if (band) take_band(tables, arena);
}

SKYSHINE_EXPORT size_t skyshine_tables_size(const SkyDatabase *surface, const SkyDatabase *band, const SkyDatabase *air) {
    SkyTables tables;
    Arena arena = {0};
    take(&arena, 1, sizeof tables);
    arrange(&tables, surface, band, air, &arena);
    return arena.used;
}

SKYSHINE_EXPORT int32_t skyshine_tables_make(SkyTables *tables, const SkyDatabase *surface, const SkyDatabase *band,
                                             const SkyDatabase *air, SkyFailure *failure) {
    Arena arena = {.begin = (char *)tables};
    const SkyDatabase *given[] = {surface, band, air};
    for (int k = 0; k < 3; k++) {
        int32_t status = given[k] ? skyshine_groups_check(given[k], failure) : SKY_OK;
        if (status) return status;
    }
    if (band && air && compare_wavelengths(band, air, failure)) return SKY_BANDS;
    take(&arena, 1, sizeof *tables);
    arrange(tables, surface, band, air, &arena);
    return SKY_OK;
}

SKYSHINE_EXPORT size_t skyshine_wavelengths(const SkyTables *tables) { return tables->wavelengths; }

SKYSHINE_EXPORT int32_t skyshine_read(const SkyTables *tables, int32_t kind, int32_t array, size_t count, const double *where,
                                      double *values, SkyFailure *failure) {
    const SkyDatabase *database = kind == SKY_SURFACE ? &tables->surface : kind == SKY_BAND ? &tables->band : &tables->air;
    double place[SKY_AXES];
    if (!database->arrays[array].values)
        return refuse(failure, SKY_LACKS, kind, 0, skyshine_array_name(kind, array), 0, 0, 0);
    for (size_t i = 0; i < count; i++) {
        for (int32_t k = 0; k < database->arrays[array].rank; k++) place[k] = where[(size_t)k * count + i];
        int32_t status = read_array(database, array, place, i, values + i, failure);
        if (status) return status;
    }
    return SKY_OK;
}

SKYSHINE_EXPORT int32_t skyshine_temperatures(const SkyTables *tables, size_t count, const SkyFaces *faces, const double *time,
                                              double *temperature, SkyFailure *failure) {
    for (size_t i = 0; i < count; i++) {
        double place[] = {faces->material[i], faces->altitude[i], faces->azimuth[i], faces->slope[i], time[i]};
        int32_t status = read_array(&tables->surface, TEMPERATURE, place, i, temperature + i, failure);
        if (status) return status;
    }
    return SKY_OK;
}

SKYSHINE_EXPORT int32_t skyshine_apparent_temperatures(const SkyTables *tables, size_t count, const double *radiance,
                                                       double *temperature, SkyFailure *failure) {
    const Array *array = &tables->band.arrays[BLACKBODY];
    const Axis *axis = &array->axes[0];
    double first = array->values[0], last = array->values[axis->count - 1];
    for (size_t i = 0; i < count; i++) {
        if (!(radiance[i] >= first && radiance[i] <= last))
            return refuse(failure, SKY_OUTSIDE, SKY_BAND, i, "radiance", radiance[i], first, last);
        size_t low = 0, high = axis->count;
        while (high - low > 1) {
            size_t middle = (low + high) / 2;
            if (array->values[middle] <= radiance[i])
                low = middle;
            else
                high = middle;
        }
        temperature[i] = axis->nodes[low];
        if (high == axis->count) continue;
        double rise = (double)array->values[high] - array->values[low], above = radiance[i] - array->values[low];
        if (rise > 0) temperature[i] += above / rise * (axis->nodes[high] - axis->nodes[low]);
    }
    return SKY_OK;
}

SKYSHINE_EXPORT int64_t skyshine_value_of_pixel(double radiance, int32_t bits, double gain, double buffer_gain, double offset) {
    double size = (double)(INT64_C(1) << bits), share = clipped(radiance / gain, 0, 1);
    if (!(share >= 0)) return -1; /* not a number */
    /* The nearest integer to x - 1/2, halves upwards, is the floor of x. */
    return (int64_t)clipped(floor_of(size * buffer_gain * (share - offset)), 0, size - 1);
}
