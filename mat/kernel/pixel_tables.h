/* Databases and tables in memory, and reading at a place of them. */
#ifndef SKYSHINE_PIXEL_TABLES_H
#define SKYSHINE_PIXEL_TABLES_H

#include "pixels.h"
#include "scalar.h"

/* An axis; the cell of a value is searched among those that reach into one of equal parts of the axis. */
typedef struct {
    const char *name;
    const double *nodes;
    size_t count;
    double first, last, period, dark_below; /* `last` of a periodic axis: where it closes */
    double parts_per_length;
    const int32_t *cells; /* (parts + 3): the last node up to the beginning of the part before each */
    int32_t parts, rule, clamps;
} Axis;

typedef struct {
    const float *values; /* NULL: the file lacks it */
    Axis axes[SKY_AXES];
    int32_t rank;
} Array;

struct SkyDatabase {
    int32_t kind;
    Array arrays[SKY_ARRAYS];
    double numbers[SKY_NUMBERS];
};

/* Places of arrays in the lists of `layouts.c`. */
enum { TEMPERATURE, KERNEL, REFERENCE, LOSS_SLOPE, LOSS_EXCESS, ABSORPTANCE, EMISSIVITY, MELT, HIGHEST, DIRECT_NORMAL, DIFFUSE,
       LONGWAVE, AIR_TEMPERATURE, SOLAR_ELEVATION, SOLAR_AZIMUTH, AUREOLE, FILM_LOSS, FILM_EVAPORATION, FILM_SUNLIGHT,
       DRY_SUNLIGHT, FILM_CAPACITY, RAIN, FILM_BEFORE, TRACKS };
enum { BLACKBODY, REFLECTANCE, SPECULAR_FRACTION, SHININESS, NORMALISATION, REFLECTANCE_SPECTRUM, EMISSION_SHARE };
enum { EFFECTIVE_RADIUS, LOG_EXTINCTION, ABSORBER_FACTOR, CHANNEL_WEIGHT, THERMAL_REFERENCE, THERMAL_RATIO, SOURCE_REFERENCE,
       SCATTERED_RATIO, SOURCE_FACTOR, SOURCE_RISE, DIRECT_LIGHT, DIRECT_FACTOR, THERMAL_SKY, THERMAL_SKY_FACTOR,
       SCATTERED_SKY, SCATTERED_SKY_FACTOR, THERMAL_SHARE, SOURCE_SHARE, THERMAL_HARMONICS, THERMAL_HARMONICS_FACTOR,
       SCATTERED_HARMONICS, SCATTERED_HARMONICS_FACTOR, GROUND_HARMONICS, GROUND_HARMONICS_FACTOR, GROUND_EMISSION, END_RISE };

enum { HARMONICS = 11, ZONAL = 4 };

/* Light at the ends of lines, in parts: tables (nodes, parts, codes) with the parts and codes of a place together, and the
 * factor of each part in the channels (parts, padded P). Without harmonics there is one code. */
typedef struct {
    const float *values;
    const double *factor;
    size_t parts, codes;
} Light;

/* The atmosphere's arrays as lines of sight read them: numbers of one place together, rows of channels and of wavelengths
 * padded to a multiple of eight with zeros. */
struct SkyTables {
    SkyDatabase surface, band, air; /* `kind` is -1 of one that is not there */
    size_t channels, channel_row, wavelengths, wavelength_row;
    size_t absorbers, source_parts, fields, field_row, harmonics, zonal;
    size_t materials, planck; /* of the band; nodes of emission_share */
    int32_t tilted;           /* the light around faces is there */
    const float *field;       /* (share, height_root, direction, field_row): absorbers, source parts, thermal_ratio, end_rise */
    const double *absorber_factor; /* (absorbers, channel_row) */
    const double *weight, *thermal_reference, *source_reference; /* (channel_row) */
    const double *emitted_share, *thermal_share, *source_share;  /* (channels, wavelength_row); the first of all emitted light */
    const double *dark;            /* (wavelength_row): 1 where nothing is emitted: the band's transmittance counts there */
    const double *ground_emission; /* (ground_temperature, channel_row) */
    Light direct, thermal_sky, scattered_sky, thermal_harmonics, scattered_harmonics, ground_harmonics;
    const float *source_factor; /* (source_elevation, scattering_angle, source_parts) */
    const double *reflectance, *emission; /* (materials, wavelength_row), (planck, wavelength_row) */
    /* Sums over wavelengths of what materials emit and reflect of light in the channels, each row (channel_row). */
    const double *emits;         /* (materials, planck) */
    const double *glows;         /* (planck): of black bodies */
    const double *emits_dark, *glows_dark; /* (materials, planck), (planck): of the wavelengths of `dark` */
    const double *reflects_thermal, *reflects_source; /* (materials) */
};

/* Cell of a value and weight of its upper node. */
typedef struct {
    size_t lower, upper;
    double weight;
} Place;

static inline int32_t refuse(SkyFailure *failure, int32_t status, int32_t kind, size_t row, const char *name, double found,
                             double least, double most) {
    *failure = (SkyFailure){status, kind, row, name, found, least, most};
    return status;
}

/* Where a value lies on an axis; 0, or a status. */
static inline int32_t locate(const Axis *axis, double value, Place *place) {
    size_t count = axis->count;
    if (!is_finite(value)) return SKY_OUTSIDE;
    if (axis->rule != SKY_EXACT && axis->period > 0) value -= axis->period * floor_of((value - axis->first) / axis->period);
    if (!(value >= axis->first)) {
        if (!axis->clamps && axis->rule == SKY_LINEAR) return SKY_OUTSIDE;
        if (axis->rule == SKY_EXACT) return SKY_CODE;
        value = axis->first;
    }
    if (!(value <= axis->last)) {
        if (!axis->clamps && axis->rule == SKY_LINEAR) return SKY_OUTSIDE;
        if (axis->rule == SKY_EXACT) return SKY_CODE;
        value = axis->last;
    }
    size_t part = (size_t)((value - axis->first) * axis->parts_per_length);
    if (part >= (size_t)axis->parts) part = (size_t)axis->parts - 1;
    size_t low = (size_t)axis->cells[part], high = (size_t)axis->cells[part + 3] + 1;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (axis->nodes[middle] <= value)
            low = middle;
        else
            high = middle;
    }
    if (axis->rule == SKY_EXACT) {
        *place = (Place){low, low, 0};
        return axis->nodes[low] == value ? SKY_OK : SKY_CODE;
    }
    if (axis->rule == SKY_PERIODIC) {
        size_t upper = low + 1 < count ? low + 1 : 0;
        double end = upper ? axis->nodes[upper] : axis->last;
        *place = (Place){low, upper, (value - axis->nodes[low]) / (end - axis->nodes[low])};
        return SKY_OK;
    }
    if (count == 1) {
        *place = (Place){0, 0, 0};
        return SKY_OK;
    }
    if (low > count - 2) low = count - 2;
    *place = (Place){low, low + 1, (value - axis->nodes[low]) / (axis->nodes[low + 1] - axis->nodes[low])};
    return SKY_OK;
}

/* `locate` that says why. */
static inline int32_t find(const Axis *axis, double value, int32_t kind, size_t row, Place *place, SkyFailure *failure) {
    int32_t status = locate(axis, value, place);
    if (!status) return SKY_OK;
    return refuse(failure, status, kind, row, axis->name, value, axis->first, axis->last);
}

/* Linear interpolation in every axis: sum over the corners of a cell, of which those without weight are not read. */
static inline double corner_sum(const Array *array, const Place *places) {
    size_t index[1 << SKY_AXES];
    double weight[1 << SKY_AXES], total = 0;
    int corners = 1;
    index[0] = 0; /* all others are written before they are read: to clear them would cost more than the sum */
    weight[0] = 1;
    for (int32_t k = 0; k < array->rank; k++) {
        size_t count = array->axes[k].count, lower = places[k].lower, upper = places[k].upper;
        double high = places[k].weight;
        if (high != 0)
            for (int c = 0; c < corners; c++) {
                index[corners + c] = index[c] * count + upper;
                weight[corners + c] = weight[c] * high;
            }
        for (int c = 0; c < corners; c++) {
            index[c] = index[c] * count + lower;
            weight[c] *= 1 - high;
        }
        corners <<= high != 0;
    }
    for (int c = 0; c < corners; c++) total += weight[c] * array->values[index[c]];
    return total;
}

/* The value of an array at a place: one value for each axis. */
static inline int32_t read_array(const SkyDatabase *database, int32_t array, const double *where, size_t row, double *value,
                                 SkyFailure *failure) {
    Place places[SKY_AXES];
    const Array *of = &database->arrays[array];
    for (int32_t k = 0; k < of->rank; k++) {
        int32_t status = find(&of->axes[k], where[k], database->kind, row, &places[k], failure);
        if (status) return status;
    }
    *value = corner_sum(of, places);
    return SKY_OK;
}

/* A value inside an axis, as its ends bound it. */
static inline double bounded(const Axis *axis, double value) {
    return clipped(value, axis->nodes[0], axis->nodes[axis->count - 1]);
}

/* Refuse a database that has a part of a group of arrays; `layouts.c`. */
int32_t skyshine_groups_check(const SkyDatabase *database, SkyFailure *failure);

static inline size_t row_of(size_t count) { return (count + 7) / 8 * 8; }

/* Memory that is handed out piece by piece; without a beginning it only counts. */
typedef struct {
    char *begin;
    size_t used;
} Arena;

static inline void *take(Arena *arena, size_t count, size_t size) {
    size_t at = arena->used;
    arena->used = at + (count * size + 63) / 64 * 64;
    return arena->begin ? arena->begin + at : 0;
}

#endif
