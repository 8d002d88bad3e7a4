/* Quantities of the air at places, in the band or by wavelength. */
#include "air.h"
#include "export.h"

typedef struct {
    const SkyTables *tables;
    Path path;
    double *thermal, *source, *part, *wavelengths; /* light in the channels; parts; by wavelength, three rows */
    double line[3]; /* of `path`: range, altitude, elevation */
} Work;

static size_t scratch_rows(const SkyTables *tables) {
    return path_size(tables) + 2 * tables->channel_row + most_parts(tables) + 3 * tables->wavelength_row;
}

/* Bytes of the scratch of `quantity`. */
size_t SKYSHINE_NAME(skyshine_quantity_scratch)(const SkyTables *tables);
SKYSHINE_EXPORT size_t SKYSHINE_NAME(skyshine_quantity_scratch)(const SkyTables *tables) { return scratch_rows(tables) * sizeof(double); }

static int32_t column_of(const Axis *codes, double code, size_t row, double *weights, SkyFailure *failure) {
    Place place;
    int32_t status = find(codes, code, SKY_AIR, row, &place, failure);
    if (status) return status == SKY_CODE ? refuse(failure, SKY_OUTSIDE, SKY_AIR, row, codes->name, code, codes->first, codes->last) : status;
    clear(weights, HARMONICS);
    weights[place.lower] = 1;
    return SKY_OK;
}

/* Light at the end of the path, in `thermal` and `source`. */
static int32_t light_of(Work *work, int32_t quantity, double source, double last, size_t row, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    static const double level[HARMONICS] = {1};
    double codes[HARMONICS];
    SkyPlace place;
    Place height;
    clear(work->thermal, 2 * tables->channel_row);
    if (quantity == SKY_DIRECT) return add_direct(tables, &work->path, source, row, work->part, work->source, failure);
    if (quantity == SKY_GROUND_HARMONIC) {
        const Axis *axes = &tables->air.arrays[GROUND_HARMONICS].axes[1];
        double *spectrum = work->source;
        int32_t status = find(&axes[0], work->path.end_height, SKY_AIR, row, &height, failure);
        if (!status) status = column_of(&axes[1], last, row, codes, failure);
        if (!status) status = ground_spectrum(tables, source, row, spectrum, failure);
        if (status) return status;
        size_t corner[] = {height.lower, height.upper};
        double weight[] = {1 - height.weight, height.weight};
        light_parts(&tables->ground_harmonics, corner, weight, 2, codes, work->part);
        add_channels(tables, &tables->ground_harmonics, work->part, 1, spectrum, work->thermal);
        clear(work->source, tables->channel_row);
        return SKY_OK;
    }
    int32_t status = place_sky(tables, &work->path, source, row, &place, failure);
    if (!status && quantity == SKY_HARMONIC) status = column_of(&tables->air.arrays[SCATTERED_HARMONICS].axes[3], last, row, codes, failure);
    if (status) return status;
    int tilted = quantity == SKY_HARMONIC;
    add_sky(tables, tilted ? &tables->thermal_harmonics : &tables->thermal_sky, tilted ? &tables->scattered_harmonics : &tables->scattered_sky,
            &place, tilted ? codes : level, work->part, work->thermal, work->source);
    return SKY_OK;
}

static int32_t light_at(Work *work, int32_t quantity, int32_t by_wavelength, double source, double last, size_t row, double *to,
                        SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    int32_t status = light_of(work, quantity, source, last, row, failure);
    if (status) return status;
    weigh(tables, &work->path, work->thermal);
    weigh(tables, &work->path, work->source);
    if (!by_wavelength) {
        double sum = 0;
        for (size_t j = 0; j < tables->channels; j++) sum += work->thermal[j] + work->source[j];
        *to = sum;
    } else {
        clear(work->wavelengths, tables->wavelength_row);
        add_wavelengths(tables, work->thermal, tables->thermal_share, work->wavelengths);
        add_wavelengths(tables, work->source, tables->source_share, work->wavelengths);
        for (size_t b = 0; b < tables->wavelengths; b++) to[b] = work->wavelengths[b];
    }
    if (quantity == SKY_AMBIENT || quantity == SKY_DIRECT) bound_at_zero(to, by_wavelength ? tables->wavelengths : 1);
    return SKY_OK;
}

static int32_t value_at(Work *work, const Lines *lines, int32_t quantity, int32_t by_wavelength, const SkyPlaces *places, size_t from,
                        size_t i, double *to, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    size_t row = from + i;
    double source = places->source_elevation ? places->source_elevation[row] : 0, last = places->last ? places->last[row] : 0;
    if (quantity == SKY_IN_AIR) {
        *to = lines->range[i] <= lines->distance[i];
        return SKY_OK;
    }
    const double line[] = {places->range[row], places->altitude[row], places->elevation[row]};
    int known = 1;
    for (int k = 0; k < 3; k++) known &= work->line[k] == line[k];
    if (!known) {
        double whole = clipped(line[0], tables->air.numbers[SKY_RANGE_FIRST], tables->air.numbers[SKY_RANGE_LAST]);
        int32_t status = take_path(tables, lines, i, whole, row, &work->path, failure);
        if (status) return status;
        for (int k = 0; k < 3; k++) work->line[k] = line[k];
    }
    if (quantity == SKY_BETA_STAR) {
        *to = work->path.beta_star;
        return SKY_OK;
    }
    if (quantity == SKY_OPTICAL_DEPTH) {
        optical_depths(tables, &work->path, work->wavelengths, work->wavelengths + 2 * tables->wavelength_row);
        for (size_t b = 0; b < tables->wavelengths; b++) to[b] = work->wavelengths[2 * tables->wavelength_row + b];
        return SKY_OK;
    }
    if (quantity == SKY_PATH_RATIO_ANGLE) return path_ratio(tables, &work->path, source, last, row, to, failure);
    if (quantity != SKY_PATH_RATIO) return light_at(work, quantity, by_wavelength, source, last, row, to, failure);
    if (!is_finite(last)) return refuse(failure, SKY_OUTSIDE, SKY_AIR, row, "source_azimuth", last, 0, 180);
    return path_ratio(tables, &work->path, source_at_entry(lines->turn[i], source, last), lines->angle[i], row, to, failure);
}

int32_t SKYSHINE_NAME(skyshine_quantity)(const SkyTables *tables, int32_t quantity, int32_t by_wavelength, size_t count,
                                         const SkyPlaces *places, double *values, void *scratch, SkyFailure *failure);
SKYSHINE_EXPORT int32_t SKYSHINE_NAME(skyshine_quantity)(const SkyTables *tables, int32_t quantity, int32_t by_wavelength, size_t count,
                                         const SkyPlaces *places, double *values, void *scratch, SkyFailure *failure) {
    double *rows = scratch;
    Work work = {.tables = tables, .thermal = rows + path_size(tables), .line = {NOT_A_NUMBER}};
    Lines lines;
    set_path(tables, &work.path, rows);
    work.source = work.thermal + tables->channel_row;
    work.part = work.source + tables->channel_row;
    work.wavelengths = work.part + most_parts(tables);
    size_t width = by_wavelength || quantity == SKY_OPTICAL_DEPTH ? tables->wavelengths : 1;
    for (size_t from = 0; from < count; from += BLOCK) {
        size_t number = count - from < BLOCK ? count - from : BLOCK;
        int32_t status = take_lines(tables, number, places->range + from, places->altitude + from, places->elevation + from, from, &lines, failure);
        if (status) return status;
        if (quantity == SKY_PATH_RATIO) {
            double source[BLOCK], azimuth[BLOCK];
            spread(places->source_elevation, 0, from, number, source);
            spread(places->last, 0, from, number, azimuth);
            scattering_angles(lines.looked, source, azimuth, lines.angle);
        }
        for (size_t i = 0; i < number; i++) {
            status = value_at(&work, &lines, quantity, by_wavelength, places, from, i, values + (from + i) * width, failure);
            if (status) return status;
        }
    }
    return SKY_OK;
}
