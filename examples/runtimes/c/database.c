/* Files come from anywhere: nothing in one is believed before it is checked. */
#include "database.h"
#include "layouts.h"
#include "reading.h"

#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *const GROUND[] = {"ground_emissivity", "ground_temperature", "ground_radiance"};
static const char *const LINE[] = {"range", "altitude", "elevation"};

/* Arrays of a list behind those that are there. */
static void read_more(const struct source *from, struct database *database, const struct layout *layout, const char *const *clamped)
{
    size_t next = 0;
    while (database->arrays[next].name) ++next;
    for (; layout->name; ++layout, ++next) {
        if (next == ARRAYS) sky_fail("%s: holds more arrays than this program has room for", from->path);
        sky_read_array(from, layout, &database->arrays[next], clamped);
    }
}

int sky_holds(const struct database *database, const char *name)
{
    for (size_t i = 0; i < ARRAYS && database->arrays[i].name; ++i)
        if (!strcmp(database->arrays[i].name, name)) return 1;
    return 0;
}

/* Whether the file has an array of a list. */
static int has_any(const struct source *from, const struct layout *layout)
{
    for (; layout->name; ++layout)
        if (H5Lexists(from->file, layout->name, H5P_DEFAULT) > 0) return 1;
    return 0;
}

/* The rows of an array are shares, which sum to 1. */
static void check_shares(const struct source *from, const struct database *database, const char *name)
{
    const struct array *array = sky_array_of(database, name);
    const size_t count = array->axes[1].count;
    for (size_t i = 0; i < array->axes[0].count; ++i) {
        double sum = 0.0;
        for (size_t b = 0; b < count; ++b) sum += array->values[i * count + b];
        if (!(fabs(sum - 1.0) <= 1e-5)) sky_fail("%s: a row of '%s' sums to %g; allowed: 1", from->path, name, sum);
    }
}

/* What the file states of the ground. */
static void read_ground(const struct source *from, struct database *database)
{
    sky_read_text(from->file, "ground_material", database->ground_material);
    for (int k = 0; k < 3; ++k)
        if (H5Aexists(from->file, GROUND[k]) <= 0 || !sky_read_number(from->file, GROUND[k], &database->ground[k]) ||
            !isfinite(database->ground[k]) || database->ground[k] < 0)
            database->ground[k] = NAN;
}

/* Harmonics of the light around faces; the file then states the ground. */
static void read_tilted(const struct source *from, struct database *database, const char *const *clamped)
{
    read_more(from, database, CHANNEL_HARMONICS, clamped);
    if ((sky_codes_of(database, "scattered_harmonics")->count == 6) != (sky_codes_of(database, "ground_harmonics")->count == 3))
        sky_fail("%s: 'scattered_harmonics' and 'ground_harmonics' are of different harmonics", from->path);
    for (int k = 0; k < 3; ++k)
        if (isnan(database->ground[k])) sky_fail("%s: does not state '%s'", from->path, GROUND[k]);
    database->tilted = 1;
}

/* The numbers that an atmosphere states: ascending, in a range. */
static void read_stated(const struct source *from, const char *name, size_t count, double least, double most, double *to)
{
    int fits = sky_read_numbers(from->file, name, count, to);
    for (size_t i = 0; i < count; ++i) fits = fits && to[i] >= least && to[i] <= most && (!i || to[i] >= to[i - 1]);
    if (!fits) sky_fail("%s: does not state '%s', in %g to %g and ascending", from->path, name, least, most);
}

static void read_atmosphere(const struct source *from, struct database *database, const char *const *clamped)
{
    struct channels *channels = &database->channels;
    read_ground(from, database);
    read_stated(from, "ground_altitude_km", 1, -1.0, 10.0, &channels->ground_km);
    read_stated(from, "scale_height_km", 1, 1e-12, 1000.0, &channels->scale_km);
    read_stated(from, "range_km", 2, 0.0, 1e9, channels->ends[0]);
    read_stated(from, "altitude_km", 2, -1.0, 1e9, channels->ends[1]);
    if (channels->ends[1][1] >= SKY_TOP_KM) channels->ends[1][1] = SKY_FARTHEST_KM; /* it serves observers in space */
    channels->ends[2][0] = -90.0, channels->ends[2][1] = 90.0;
    for (size_t k = 0; k < 3; ++k) channels->clamps[k] = sky_is_listed(clamped, LINE[k]);
    read_more(from, database, CHANNELS, clamped);
    const struct array *weight = sky_array_of(database, "channel_weight");
    double sum = 0.0;
    for (size_t i = 0; i < weight->axes[0].count; ++i) sum += weight->values[i];
    if (!(fabs(sum - 1.0) <= 1e-5)) sky_fail("%s: 'channel_weight' sums to %g; allowed: 1", from->path, sum);
    if (isnan(sky_array_of(database, "source_factor")->axes[1].dark_below))
        sky_fail("%s: the source elevations of 'source_factor' do not state dark_below", from->path);
    check_shares(from, database, "thermal_wavelength_share");
    check_shares(from, database, "source_wavelength_share");
    if (has_any(from, CHANNEL_HARMONICS)) read_tilted(from, database, clamped);
    if (has_any(from, CHANNEL_BENDING)) read_more(from, database, CHANNEL_BENDING, clamped);
}

static int is_utf8(const char *text)
{
    for (const unsigned char *at = (const unsigned char *)text; *at;) {
        int more = *at < 0x80 ? 0 : *at >> 5 == 6 ? 1 : *at >> 4 == 14 ? 2 : *at >> 3 == 30 ? 3 : -1;
        if (more < 0) return 0;
        for (++at; more; --more, ++at)
            if (*at >> 6 != 2) return 0;
    }
    return 1;
}

static char *copy_of(const char *text)
{
    return memcpy(sky_allocate(strlen(text) + 1, 1), text, strlen(text) + 1);
}

static const char **read_names(const struct source *from, size_t count)
{
    hsize_t length;
    hid_t array = sky_open_array(from, "material_name"), type = sky_id(H5Dget_type(array));
    if (H5Tis_variable_str(type) <= 0) sky_fail("%s: 'material_name' is not text of variable length", from->path);
    if (sky_read_shape(from, array, "material_name", 1, H5T_STRING, H5Tget_size(type), &length) != count)
        sky_fail("%s: 'material_name' has %llu names for %zu codes", from->path, (unsigned long long)length, count);
    char **stored = sky_read_values(from, array, "material_name", type, count, sizeof(char *));
    const char **names = sky_allocate(count, sizeof *names);
    int readable = 1;
    for (size_t i = 0; i < count; ++i) {
        readable = readable && stored[i] && is_utf8(stored[i]);
        names[i] = stored[i] ? copy_of(stored[i]) : NULL;
    }
    H5Dvlen_reclaim(type, sky_id(H5Dget_space(array)), H5P_DEFAULT, stored);
    if (!readable) sky_fail("%s: 'material_name' holds what is not UTF-8 text", from->path);
    return names;
}

/* The ground before tilted faces, which has their shade. */
static void read_shaded_ground(const struct source *from, struct database *database)
{
    const struct axis *axes = sky_array_of(database, "temperature")->axes;
    if (!sky_read_text(from->file, "ground_material", database->ground_material) || axes[3].nodes[0] > 0) return;
    const char **names = read_names(from, axes[0].count);
    for (size_t i = 0; i < axes[0].count; ++i)
        if (!strcmp(names[i], database->ground_material)) database->ground_code = axes[0].nodes[i];
    if (database->ground_code == 0.0) return;
    read_stated(from, "ground_emissivity", 1, 0.0, 1.0, &database->ground[0]);
    read_stated(from, "ground_albedo", 1, 0.0, 1.0, &database->ground_albedo);
}

static void read_surface(const struct source *from, struct database *database, const char *const *clamped)
{
    const struct layout *const OPTIONAL[] = {SHADE, FILM, FILM_BEFORE, TRACKS};
    read_more(from, database, SURFACE, clamped);
    for (size_t k = 0; k < sizeof OPTIONAL / sizeof *OPTIONAL; ++k)
        if (H5Lexists(from->file, OPTIONAL[k]->name, H5P_DEFAULT) > 0) read_more(from, database, OPTIONAL[k], clamped);
    if (sky_holds(database, SHADE->name)) read_shaded_ground(from, database);
    database->tracked = sky_holds(database, TRACKS->name);
}

static void read_band(const struct source *from, struct database *database, const char *const *clamped)
{
    read_more(from, database, BAND, clamped);
    check_shares(from, database, "emission_share");
    database->material_names = read_names(from, sky_array_of(database, "reflectance")->axes[0].count);
}

void sky_open_database(struct database *database, const char *path, const char *filetype, const char *const *clamped)
{
    char found[NAME] = "", version[NAME] = "";
    struct stat on_disk;
    struct source from = {H5I_INVALID_HID, path, 0};
    if (stat(path, &on_disk) == 0 && S_ISREG(on_disk.st_mode)) from.file = sky_id(H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT));
    if (from.file < 0) sky_fail("%s: is not a readable HDF5 file", path);
    from.bytes = (double)PACKING * (double)on_disk.st_size + SMALL;
    const int air = !strcmp(filetype, "atmq"), known = sky_read_text(from.file, "filetype", found);
    const int versioned = known && sky_read_text(from.file, "format_version", version);
    const char *major = air ? "4." : "1.";
    database->lunar = air && !strcmp(found, "lunar_atmq");
    if ((strcmp(found, filetype) && !database->lunar) || !versioned || strncmp(version, major, 2))
        sky_fail("%s: holds '%s' %s; allowed: %s %sx", path, found, version, filetype, major);
    database->path = copy_of(path);
    if (air) read_atmosphere(&from, database, clamped);
    else if (!strcmp(filetype, "band")) read_band(&from, database, clamped);
    else read_surface(&from, database, clamped);
}

const struct array *sky_array_of(const struct database *database, const char *name)
{
    for (size_t i = 0; i < ARRAYS && database->arrays[i].name; ++i)
        if (!strcmp(database->arrays[i].name, name)) return &database->arrays[i];
    sky_fail("%s: '%s' was not read", database->path, name);
    return NULL;
}

const struct axis *sky_codes_of(const struct database *database, const char *name)
{
    const struct array *array = sky_array_of(database, name);
    return &array->axes[array->rank - 1];
}

/* Neighbouring nodes of a value and the weight of the upper one. */
struct place {
    size_t lower, upper;
    double weight;
};

static double modulo(double value, double period)
{
    return value - period * floor(value / period);
}

static struct place locate(const struct axis *axis, double value)
{
    if (!isfinite(value)) sky_fail("%s: found a value that is not finite; allowed: finite numbers", axis->name);
    size_t count = axis->count;
    if (!strcmp(axis->rule, "exact")) {
        for (size_t i = 0; i < count; ++i)
            if (axis->nodes[i] == value) return (struct place){i, i, 0.0};
        sky_fail("%s: found %g; allowed: a code of the file", axis->name, value);
    }
    const double first = axis->nodes[0];
    int periodic = !strcmp(axis->rule, "linear_periodic");
    if (periodic) value = first + modulo(value - first, axis->period);
    if (!strcmp(axis->rule, "linear") && axis->period > 0) value -= axis->period * floor((value - first) / axis->period);
    const double last = periodic ? first + axis->period : axis->nodes[count - 1];
    if (!axis->clamps && !(value >= first && value <= last)) sky_fail("%s: found %g; allowed: %g to %g", axis->name, value, first, last);
    value = fmin(fmax(value, first), last);
    size_t lower = 0, above = count;
    while (above - lower > 1) {
        size_t middle = (lower + above) / 2;
        if (axis->nodes[middle] <= value) lower = middle;
        else above = middle;
    }
    if (!periodic && lower == count - 1 && count > 1) --lower;
    if (!periodic && count == 1) return (struct place){0, 0, 0.0};
    size_t upper = (lower + 1) % count;
    double end = upper ? axis->nodes[upper] : last;
    return (struct place){lower, upper, (value - axis->nodes[lower]) / (end - axis->nodes[lower])};
}

double sky_value_at(const struct database *database, const char *name, const double *where)
{
    const struct array *array = sky_array_of(database, name);
    struct place places[AXES];
    for (size_t k = 0; k < array->rank; ++k) places[k] = locate(&array->axes[k], where[k]);
    double total = 0.0;
    for (unsigned corner = 0; corner < 1u << array->rank; ++corner) {
        double share = 1.0;
        size_t index = 0;
        for (size_t k = 0; k < array->rank; ++k) {
            int up = corner >> k & 1;
            share *= up ? places[k].weight : 1.0 - places[k].weight;
            index = index * array->axes[k].count + (up ? places[k].upper : places[k].lower);
        }
        if (share != 0.0) total += share * array->values[index];
    }
    return total;
}

void sky_compare_wavelengths(const struct database *air, const struct database *band)
{
    const struct axis *ours = &sky_array_of(air, "thermal_wavelength_share")->axes[1], *theirs = &sky_array_of(band, "emission_share")->axes[1];
    int same = ours->count == theirs->count;
    for (size_t b = 0; same && b < ours->count; ++b) same = fabs(ours->nodes[b] - theirs->nodes[b]) <= 1e-6 * fabs(theirs->nodes[b]);
    if (!same)
        sky_fail("%s: has %zu wavelengths from %g to %g um; allowed: those of the air, %zu from %g to %g um", band->path, theirs->count,
                 theirs->nodes[0], theirs->nodes[theirs->count - 1], ours->count, ours->nodes[0], ours->nodes[ours->count - 1]);
}

size_t sky_wavelengths_of(const struct database *air)
{
    return sky_array_of(air, "thermal_wavelength_share")->axes[1].count;
}
