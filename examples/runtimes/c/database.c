/* Files come from anywhere: nothing in one is believed before it is checked. */
#include "database.h"
#include "channels.h"
#include "layouts.h"
#include "reading.h"

#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *const GROUND[] = {"ground_emissivity", "ground_temperature", "ground_radiance"};
/* What each quantity that depends on the source equals without it; direct light nothing. */
static const struct {
    const char *quantity, *emitted;
} WITHOUT_SOURCE[] = {
    {"path_radiance_ratio", "thermal_path_radiance_ratio"},
    {"ambient_radiance", "thermal_ambient_radiance"},
    {"direct_radiance", NULL},
    {LIGHT, "thermal_radiance_harmonics"},
    {NULL, NULL},
};
const double SKY_CIVIL_TWILIGHT = -6.0;
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
static void read_tilted(const struct source *from, struct database *database, const struct layout *layout, const char *const *clamped)
{
    read_more(from, database, layout, clamped);
    if ((sky_codes_of(database, LIGHT)->count == 6) != (sky_codes_of(database, GLOW)->count == 3)) sky_fail("%s: '%s' and '%s' are of different harmonics", from->path, LIGHT, GLOW);
    for (int k = 0; k < 3; ++k)
        if (isnan(database->ground[k])) sky_fail("%s: does not state '%s'", from->path, GROUND[k]);
    database->tilted = 1;
}

/* Quantities without the source; the axes of source elevation then say where it is dark. */
static void read_night(const struct source *from, struct database *database, const char *const *clamped)
{
    struct layout wanted[sizeof NIGHT / sizeof *NIGHT];
    memcpy(wanted, NIGHT, sizeof NIGHT);
    if (!database->tilted) wanted[2].name = NULL;
    read_more(from, database, wanted, clamped);
    for (size_t i = 0; WITHOUT_SOURCE[i].quantity; ++i)
        if (sky_holds(database, WITHOUT_SOURCE[i].quantity) && isnan(sky_array_of(database, WITHOUT_SOURCE[i].quantity)->axes[3].dark_below))
            sky_fail("%s: the source elevations of '%s' do not state dark_below", from->path, WITHOUT_SOURCE[i].quantity);
    database->night = 1;
}

/* The numbers that a file in channels states: ascending, in a range. */
static void read_stated(const struct source *from, const char *name, size_t count, double least, double most, double *to)
{
    int fits = sky_read_numbers(from->file, name, count, to);
    for (size_t i = 0; i < count; ++i) fits = fits && to[i] >= least && to[i] <= most && (!i || to[i] >= to[i - 1]);
    if (!fits) sky_fail("%s: does not state '%s', in %g to %g and ascending", from->path, name, least, most);
}

/* An atmosphere of format 3. */
static void read_channels(const struct source *from, struct database *database, const char *const *clamped)
{
    char layout[NAME];
    struct channels *channels = &database->channels;
    if (!sky_read_text(from->file, "layout", layout) || strcmp(layout, "channels")) sky_fail("%s: has the layout '%s'; allowed: channels", from->path, layout);
    read_stated(from, "ground_altitude_km", 1, -1.0, 10.0, &channels->ground_km);
    read_stated(from, "scale_height_km", 1, 1e-12, 1000.0, &channels->scale_km);
    read_stated(from, "range_km", 2, 0.0, 1e9, channels->ends[0]);
    read_stated(from, "altitude_km", 2, -1.0, 1e9, channels->ends[1]);
    channels->ends[2][0] = -90.0, channels->ends[2][1] = 90.0;
    for (size_t k = 0; k < 3; ++k) channels->clamps[k] = sky_is_listed(clamped, LINE[k]);
    channels->present = 1;
    read_more(from, database, CHANNELS, clamped);
    const struct array *weight = sky_array_of(database, "channel_weight");
    double sum = 0.0;
    for (size_t i = 0; i < weight->axes[0].count; ++i) sum += weight->values[i];
    if (!(fabs(sum - 1.0) <= 1e-5)) sky_fail("%s: 'channel_weight' sums to %g; allowed: 1", from->path, sum);
    if (isnan(sky_array_of(database, "source_factor")->axes[1].dark_below))
        sky_fail("%s: the source elevations of 'source_factor' do not state dark_below", from->path);
    if (has_any(from, CHANNEL_HARMONICS)) read_tilted(from, database, CHANNEL_HARMONICS, clamped);
    if (has_any(from, CHANNEL_BENDING)) read_more(from, database, CHANNEL_BENDING, clamped);
    if (has_any(from, CHANNEL_SHARES)) {
        read_more(from, database, CHANNEL_SHARES, clamped);
        for (size_t i = 0; CHANNEL_SHARES[i].name; ++i) check_shares(from, database, CHANNEL_SHARES[i].name);
    }
}

/* What a file of format 1 or 2 holds beside the arrays that it must hold. */
static void read_optional(const struct source *from, struct database *database, const struct layout *layout, const char *const *clamped)
{
    if (layout == SURFACE && H5Lexists(from->file, SHADE[0].name, H5P_DEFAULT) > 0) read_more(from, database, SHADE, clamped);
    if (layout == SURFACE && H5Lexists(from->file, FILM[0].name, H5P_DEFAULT) > 0) read_more(from, database, FILM, clamped);
    if (layout == SURFACE && H5Lexists(from->file, FILM_BEFORE[0].name, H5P_DEFAULT) > 0) read_more(from, database, FILM_BEFORE, clamped);
    if (layout == SURFACE && H5Lexists(from->file, TRACKS[0].name, H5P_DEFAULT) > 0) {
        read_more(from, database, TRACKS, clamped);
        database->tracked = 1;
    }
    if (layout == BAND && has_any(from, SPECTRA)) {
        read_more(from, database, SPECTRA, clamped);
        check_shares(from, database, "emission_share");
    }
    if (layout == ATMOSPHERE && H5Lexists(from->file, LIGHT, H5P_DEFAULT) > 0) read_tilted(from, database, TILTED, clamped);
    if (layout == ATMOSPHERE && H5Lexists(from->file, NIGHT[0].name, H5P_DEFAULT) > 0) read_night(from, database, clamped);
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

void sky_open_database(struct database *database, const char *path, const char *filetype, const char *const *clamped)
{
    char found[NAME] = "", version[NAME] = "";
    struct stat on_disk;
    struct source from = {H5I_INVALID_HID, path, 0, 1};
    if (stat(path, &on_disk) == 0 && S_ISREG(on_disk.st_mode)) from.file = sky_id(H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT));
    if (from.file < 0) sky_fail("%s: is not a readable HDF5 file", path);
    from.bytes = (double)PACKING * (double)on_disk.st_size + SMALL;
    const int air = !strcmp(filetype, "atmq"), known = sky_read_text(from.file, "filetype", found);
    const int versioned = known && sky_read_text(from.file, "format_version", version);
    const char *majors = air ? "2.x or 3." : "1.";
    const int in_channels = air && versioned && !strncmp(version, "3.", 2);
    if (!known || (strcmp(found, filetype) && !(air && !strcmp(found, "lunar_atmq"))) || !versioned ||
        (!in_channels && strncmp(version, air ? "2." : "1.", 2)))
        sky_fail("%s: holds '%s' %s; allowed: %s %sx", path, found, version, filetype, majors);
    database->path = copy_of(path);
    database->lunar = !strcmp(found, "lunar_atmq");
    if (air) read_ground(&from, database);
    const struct layout *layout = air ? ATMOSPHERE : !strcmp(filetype, "band") ? BAND : SURFACE;
    if (in_channels) {
        from.own_axes = 0;
        read_channels(&from, database, clamped);
    } else {
        read_more(&from, database, layout, clamped);
        read_optional(&from, database, layout, clamped);
    }
    if (layout == BAND) database->material_names = read_names(&from, sky_array_of(database, "reflectance")->axes[0].count);
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
    const int light = !strcmp(name, LIGHT);
    const struct array *array = sky_array_of(database, !database->channels.present ? name : light ? "scattered_harmonics" : "ground_harmonics");
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
    if (!strcmp(axis->rule, "linear_folded"))
        value = fabs(modulo(value + axis->period / 2, axis->period) - axis->period / 2);
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

double sky_interpolated(const struct database *database, const char *name, const double *where)
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

double sky_value_at(const struct database *database, const char *name, const double *where)
{
    if (database->channels.present) return sky_value_in_channels(database, name, where);
    size_t entry = 0;
    while (database->night && WITHOUT_SOURCE[entry].quantity && strcmp(WITHOUT_SOURCE[entry].quantity, name)) ++entry;
    if (!database->night || !WITHOUT_SOURCE[entry].quantity) return sky_interpolated(database, name, where);
    const struct array *array = sky_array_of(database, name);
    const double lowest = array->axes[3].nodes[0], dark = array->axes[3].dark_below, height = where[3];
    if (!isfinite(height) || height >= lowest || (height > dark && lowest > SKY_CIVIL_TWILIGHT)) return sky_interpolated(database, name, where);
    double place[AXES] = {0};
    for (size_t k = 0; k < array->rank; ++k) place[k] = where[k];
    place[3] = lowest;
    const double share = height > dark ? (height - dark) / (lowest - dark) : 0.0;
    const double light = share * sky_interpolated(database, name, place);
    if (!WITHOUT_SOURCE[entry].emitted) return light;
    if (!strcmp(name, LIGHT)) place[3] = where[4]; /* the harmonic follows the line of sight there */
    return light + (1.0 - share) * sky_interpolated(database, WITHOUT_SOURCE[entry].emitted, place);
}

void sky_part_light(struct database *air, const struct database *band)
{
    if (!air->channels.present || !sky_holds(air, "thermal_wavelength_share") || !sky_holds(band, "emission_share")) return;
    const struct axis *ours = &sky_array_of(air, "thermal_wavelength_share")->axes[1], *theirs = &sky_array_of(band, "emission_share")->axes[1];
    int same = ours->count == theirs->count;
    for (size_t b = 0; same && b < ours->count; ++b) same = fabs(ours->nodes[b] - theirs->nodes[b]) <= 1e-6 * fabs(theirs->nodes[b]);
    if (!same)
        sky_fail("%s: has %zu wavelengths from %g to %g um; allowed: those of the air, %zu from %g to %g um", band->path, theirs->count,
             theirs->nodes[0], theirs->nodes[theirs->count - 1], ours->count, ours->nodes[0], ours->nodes[ours->count - 1]);
    air->parted = ours->count;
}

size_t sky_parts_of(const struct database *air)
{
    return air->parted ? air->parted : 1;
}

void sky_light_at(const struct database *air, const char *name, const double *where, double *to)
{
    if (air->parted) sky_light_in_channels(air, name, where, to);
    else *to = sky_value_at(air, name, where);
}

void sky_extinction_at(const struct database *air, const double *where, double *to)
{
    if (air->parted) sky_extinction_in_channels(air, where, to);
    else *to = 5.5 / sky_value_at(air, "beta_star", where);
}
