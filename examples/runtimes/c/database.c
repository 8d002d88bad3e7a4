/* Files come from anywhere: nothing in one is believed before it is checked. */
#include "database.h"
#include "layouts.h"

#include <hdf5.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

const double HARMONIC_CODES[HARMONICS] = {0, 10, 11, 20, 21, 22, 40, 41, 42, 43, 44};
static const double ZONAL_CODES[] = {0, 10, 20, 40};
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
/* Degree: a table whose lowest source elevation is above says nothing of twilight. */
static const double CIVIL_TWILIGHT = -6.0;
/* How the format reads an axis; the last line holds for all that have none of their own. */
static const struct {
    const char *name, *rule, *or_rule;
    double period;
} RULES[] = {
    {"material", "exact", "exact", 0},
    {"harmonic", "exact", "exact", 0},
    {"zonal_harmonic", "exact", "exact", 0},
    {"azimuth", "linear_periodic", "linear_periodic", 360},
    {"source_azimuth", "linear_folded", "linear_folded", 360},
    {"time", "linear_periodic", "linear", 24},
    {"response_hour", "linear_periodic", "linear_periodic", 24},
    {"forcing_time", "linear_periodic", "linear_periodic", 24},
    {NULL, "linear", "linear", 0},
};
enum { LAST_CODE = 65535 };

/* An open file. */
struct source {
    hid_t file;
    const char *path;
    double bytes; /* most that an array of it can take */
};

void fail(const char *format, ...)
{
    char line[300];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    for (char *at = line; *at; ++at)
        if ((unsigned char)*at < ' ') *at = '?';
    fprintf(stderr, "%s\n", line);
    exit(1);
}

void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) fail("no memory is left");
    return memory;
}

/* A text attribute into NAME bytes; 0 where there is none, or it is not one text that fits. */
int read_text(hid_t item, const char *name, char *to)
{
    memset(to, 0, NAME);
    if (H5Aexists(item, name) <= 0) return 0;
    hid_t attribute = H5Aopen(item, name, H5P_DEFAULT), type = H5Aget_type(attribute), space = H5Aget_space(attribute);
    int fits = H5Tget_class(type) == H5T_STRING && H5Sget_simple_extent_npoints(space) == 1;
    if (fits && H5Tis_variable_str(type) > 0) {
        char *text = NULL;
        fits = H5Aread(attribute, type, &text) >= 0 && text && strlen(text) < NAME;
        if (fits) strcpy(to, text);
        if (text) H5free_memory(text);
    } else if (fits) {
        fits = H5Tget_size(type) < NAME && H5Aread(attribute, type, to) >= 0;
    }
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
    return fits;
}

/* A number attribute; 0 where it is not one number. */
int read_number(hid_t item, const char *name, double *to)
{
    hid_t attribute = H5Aopen(item, name, H5P_DEFAULT), type = H5Aget_type(attribute), space = H5Aget_space(attribute);
    H5T_class_t kind = H5Tget_class(type);
    int fits = (kind == H5T_INTEGER || kind == H5T_FLOAT) && H5Sget_simple_extent_npoints(space) == 1 &&
               H5Aread(attribute, H5T_NATIVE_DOUBLE, to) >= 0;
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
    return fits;
}

/* An array of this very file; its values may not come from another one. */
static hid_t open_array(const struct source *from, const char *name)
{
    H5L_info_t link;
    if (H5Lexists(from->file, name, H5P_DEFAULT) <= 0) fail("%s: lacks '%s'", from->path, name);
    if (H5Lget_info(from->file, name, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
        fail("%s: '%s' is a link to somewhere else", from->path, name);
    hid_t array = H5Dopen2(from->file, name, H5P_DEFAULT);
    if (array < 0) fail("%s: '%s' is not an array", from->path, name);
    hid_t how = H5Dget_create_plist(array);
    const int elsewhere = H5Pget_layout(how) == H5D_VIRTUAL || H5Pget_external_count(how) != 0;
    H5Pclose(how);
    if (elsewhere) fail("%s: '%s' is kept in another file", from->path, name);
    return array;
}

/* Lengths of the axes of an array of `rank`, whose values must be of a class and size; returns the number of values. */
static size_t read_shape(const struct source *from, hid_t array, const char *name, size_t rank, H5T_class_t kind, size_t size, hsize_t *lengths)
{
    hid_t space = H5Dget_space(array), type = H5Dget_type(array);
    if (H5Tget_class(type) != kind || H5Tget_size(type) != size) fail("%s: '%s' has values of another type", from->path, name);
    if (H5Sget_simple_extent_type(space) != H5S_SIMPLE || H5Sget_simple_extent_ndims(space) != (int)rank)
        fail("%s: '%s' does not have %zu axes", from->path, name, rank);
    H5Sget_simple_extent_dims(space, lengths, NULL);
    double count = 1;
    for (size_t k = 0; k < rank; ++k) count *= (double)lengths[k];
    if (count < 1) fail("%s: '%s' holds nothing", from->path, name);
    if (count * (double)size > from->bytes) fail("%s: '%s' claims more bytes than the file can hold", from->path, name);
    H5Tclose(type);
    H5Sclose(space);
    return (size_t)count;
}

static void *read_values(const struct source *from, hid_t array, const char *name, hid_t type, size_t count, size_t size)
{
    void *values = allocate(count, size);
    if (H5Dread(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) fail("%s: '%s' cannot be read", from->path, name);
    return values;
}

static int is_listed(const struct json *list, const char *name)
{
    for (const struct json *each = list ? list->children : NULL; each; each = each->next)
        if (each->kind == JSON_TEXT && !strcmp(each->text, name)) return 1;
    return 0;
}

/* The rule of an axis must be that of the format, and its nodes must suit it. */
static void read_rule(const struct source *from, hid_t array, const char *stored, struct axis *axis, const struct json *clamped)
{
    char policy[NAME];
    size_t rule = 0;
    while (RULES[rule].name && strcmp(RULES[rule].name, axis->name)) ++rule;
    if (!read_text(array, "interpolation", axis->rule) || (strcmp(axis->rule, RULES[rule].rule) && strcmp(axis->rule, RULES[rule].or_rule)))
        fail("%s: the axis '%s' has interpolation '%s'; allowed: %s", from->path, stored, axis->rule, RULES[rule].rule);
    if (H5Aexists(array, "out_of_range") > 0 && (!read_text(array, "out_of_range", policy) || (strcmp(policy, "error") && strcmp(policy, "clamp"))))
        fail("%s: the axis '%s' has out_of_range '%s'; allowed: error, clamp", from->path, stored, policy);
    axis->clamps = is_listed(clamped, axis->name) || (H5Aexists(array, "out_of_range") > 0 && !strcmp(policy, "clamp"));
    if (H5Aexists(array, "period") > 0 && !read_number(array, "period", &axis->period)) axis->period = NAN;
    axis->dark_below = NAN;
    if (!strcmp(axis->name, "source_elevation") && H5Aexists(array, "dark_below") > 0 &&
        (!read_number(array, "dark_below", &axis->dark_below) || !(axis->dark_below >= -90 && axis->dark_below <= 0)))
        fail("%s: the axis '%s' has dark_below %g; allowed: -90 to 0", from->path, stored, axis->dark_below);
    if (axis->period != RULES[rule].period)
        fail("%s: the axis '%s' has period %g; allowed: %g", from->path, stored, axis->period, RULES[rule].period);
    const double first = axis->nodes[0], last = axis->nodes[axis->count - 1];
    const int periodic = !strcmp(axis->rule, "linear_periodic"), folded = !strcmp(axis->rule, "linear_folded");
    for (size_t i = 0; i < axis->count; ++i)
        if (!isfinite(axis->nodes[i]) || (i && axis->nodes[i] <= axis->nodes[i - 1]))
            fail("%s: the axis '%s' is not a list of ascending numbers", from->path, stored);
    if ((periodic && last >= first + axis->period) || (folded && (first < 0 || last > axis->period / 2)) || (axis->period > 0 && last > first + axis->period))
        fail("%s: the axis '%s' has nodes beyond its period", from->path, stored);
    const int zonal = !strcmp(axis->name, "zonal_harmonic");
    if (zonal || !strcmp(axis->name, "harmonic")) {
        int known = zonal ? axis->count == 3 || axis->count == 4 : axis->count == 6 || axis->count == HARMONICS;
        for (size_t i = 0; known && i < axis->count; ++i) known = axis->nodes[i] == (zonal ? ZONAL_CODES : HARMONIC_CODES)[i];
        if (!known) fail("%s: the axis '%s' has codes that are not those of the format", from->path, stored);
    } else if (!strcmp(axis->rule, "exact") && (first < 1 || last > LAST_CODE))
        fail("%s: the axis '%s' has codes beyond 1 to %d", from->path, stored, LAST_CODE);
}

/* The axis that array `quantity` has to itself where the file has one, else the one that quantities share. */
static hobj_ref_t read_axis(const struct source *from, const char *quantity, struct axis *axis, const struct json *clamped)
{
    char own[2 * NAME];
    hsize_t length;
    hobj_ref_t reference;
    snprintf(own, sizeof own, "%s_%s", quantity, axis->name);
    const char *stored = H5Lexists(from->file, own, H5P_DEFAULT) > 0 ? own : axis->name;
    const int codes = !strcmp(axis->name, "material") || !strcmp(axis->name, "harmonic") || !strcmp(axis->name, "zonal_harmonic");
    hid_t array = open_array(from, stored);
    axis->count = read_shape(from, array, stored, 1, codes ? H5T_INTEGER : H5T_FLOAT, codes ? 4 : 8, &length);
    axis->nodes = read_values(from, array, stored, H5T_NATIVE_DOUBLE, axis->count, sizeof(double));
    read_rule(from, array, stored, axis, clamped);
    if (H5Rcreate(&reference, from->file, stored, H5R_OBJECT, -1) < 0) fail("%s: '%s' cannot be read", from->path, stored);
    H5Dclose(array);
    return reference;
}

/* Whether the dimension scales of an array, a list of references for each axis, begin with these. */
static int has_scales(hid_t array, const hobj_ref_t *axes, size_t rank)
{
    if (H5Aexists(array, "DIMENSION_LIST") <= 0) return 0;
    hid_t attribute = H5Aopen(array, "DIMENSION_LIST", H5P_DEFAULT), type = H5Aget_type(attribute), space = H5Aget_space(attribute);
    hid_t of = H5Tget_class(type) == H5T_VLEN ? H5Tget_super(type) : H5I_INVALID_HID;
    int fits = of >= 0 && H5Tequal(of, H5T_STD_REF_OBJ) > 0 && H5Sget_simple_extent_npoints(space) == (hssize_t)rank;
    hvl_t lists[AXES] = {{0, NULL}};
    if (fits && H5Aread(attribute, type, lists) >= 0) {
        for (size_t k = 0; k < rank; ++k) fits = fits && lists[k].len > 0 && *(hobj_ref_t *)lists[k].p == axes[k];
        H5Dvlen_reclaim(type, space, H5P_DEFAULT, lists);
    } else {
        fits = 0;
    }
    if (of >= 0) H5Tclose(of);
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
    return fits;
}

static void read_array(const struct source *from, const struct layout *layout, struct array *array, const struct json *clamped)
{
    hobj_ref_t references[AXES];
    hsize_t lengths[AXES];
    array->name = layout->name;
    while (array->rank < AXES && layout->axes[array->rank]) ++array->rank;
    hid_t stored = open_array(from, layout->name);
    size_t count = read_shape(from, stored, layout->name, array->rank, H5T_FLOAT, sizeof(float), lengths);
    for (size_t k = 0; k < array->rank; ++k) {
        struct axis *axis = &array->axes[k];
        axis->name = layout->axes[k];
        if (!strcmp(axis->name, "source_azimuth") && H5Lexists(from->file, "scattering_angle", H5P_DEFAULT) > 0) axis->name = "scattering_angle";
        references[k] = read_axis(from, layout->name, axis, clamped);
        if (lengths[k] != axis->count)
            fail("%s: '%s' has %llu values along '%s', which has %zu nodes", from->path, layout->name, (unsigned long long)lengths[k], axis->name, axis->count);
    }
    if (!has_scales(stored, references, array->rank)) fail("%s: '%s' has other dimension scales than its axes", from->path, layout->name);
    array->values = read_values(from, stored, layout->name, H5T_NATIVE_FLOAT, count, sizeof(float));
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(array->values[i]) || array->values[i] < layout->least || array->values[i] > layout->most)
            fail("%s: '%s' holds %g; allowed: %g to %g", from->path, layout->name, array->values[i], layout->least, layout->most);
    H5Dclose(stored);
}

/* Arrays of a list behind those that are there. */
static void read_more(const struct source *from, struct database *database, const struct layout *layout, const struct json *clamped)
{
    size_t next = 0;
    while (database->arrays[next].name) ++next;
    for (; layout->name; ++layout, ++next) {
        if (next == ARRAYS) fail("%s: holds more arrays than this program has room for", from->path);
        read_array(from, layout, &database->arrays[next], clamped);
    }
}

static int holds(const struct database *database, const char *name)
{
    for (size_t i = 0; i < ARRAYS && database->arrays[i].name; ++i)
        if (!strcmp(database->arrays[i].name, name)) return 1;
    return 0;
}

/* Harmonics of the light around faces, and what the file states of the ground. */
static void read_tilted(const struct source *from, struct database *database, const struct json *clamped)
{
    read_more(from, database, TILTED, clamped);
    const struct array *light = array_of(database, LIGHT), *glow = array_of(database, GLOW);
    if ((light->axes[4].count == 6) != (glow->axes[4].count == 3)) fail("%s: '%s' and '%s' are of different harmonics", from->path, LIGHT, GLOW);
    for (int k = 0; k < 3; ++k)
        if (H5Aexists(from->file, GROUND[k]) <= 0 || !read_number(from->file, GROUND[k], &database->ground[k]) ||
            !isfinite(database->ground[k]) || database->ground[k] < 0)
            fail("%s: does not state '%s'", from->path, GROUND[k]);
    database->tilted = 1;
}

/* Quantities without the source; the axes of source elevation then say where it is dark. */
static void read_night(const struct source *from, struct database *database, const struct json *clamped)
{
    struct layout wanted[sizeof NIGHT / sizeof *NIGHT];
    memcpy(wanted, NIGHT, sizeof NIGHT);
    if (!database->tilted) wanted[2].name = NULL;
    read_more(from, database, wanted, clamped);
    for (size_t i = 0; WITHOUT_SOURCE[i].quantity; ++i)
        if (holds(database, WITHOUT_SOURCE[i].quantity) && isnan(array_of(database, WITHOUT_SOURCE[i].quantity)->axes[3].dark_below))
            fail("%s: the source elevations of '%s' do not state dark_below", from->path, WITHOUT_SOURCE[i].quantity);
    database->night = 1;
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

static char **read_names(const struct source *from, size_t count)
{
    hsize_t length;
    hid_t array = open_array(from, "material_name"), type = H5Dget_type(array);
    if (H5Tis_variable_str(type) <= 0) fail("%s: 'material_name' is not text of variable length", from->path);
    if (read_shape(from, array, "material_name", 1, H5T_STRING, H5Tget_size(type), &length) != count)
        fail("%s: 'material_name' has %llu names for %zu codes", from->path, (unsigned long long)length, count);
    char **names = read_values(from, array, "material_name", type, count, sizeof(char *));
    for (size_t i = 0; i < count; ++i)
        if (!names[i] || !is_utf8(names[i])) fail("%s: 'material_name' holds what is not UTF-8 text", from->path);
    H5Tclose(type);
    H5Dclose(array);
    return names;
}

void open_database(struct database *database, const char *path, const char *filetype, const struct json *clamped)
{
    char found[NAME] = "", version[NAME] = "";
    struct stat on_disk;
    struct source from = {H5I_INVALID_HID, path, 0};
    if (stat(path, &on_disk) == 0 && S_ISREG(on_disk.st_mode)) from.file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (from.file < 0) fail("%s: is not a readable HDF5 file", path);
    from.bytes = (double)PACKING * (double)on_disk.st_size + SMALL;
    const int air = !strcmp(filetype, "atmq"), known = read_text(from.file, "filetype", found);
    const int versioned = known && read_text(from.file, "format_version", version);
    const char *major = air ? "2." : "1.";
    if (!known || (strcmp(found, filetype) && !(air && !strcmp(found, "lunar_atmq"))) || !versioned || strncmp(version, major, 2))
        fail("%s: holds '%s' %s; allowed: %s %sx", path, found, version, filetype, major);
    database->path = path;
    const struct layout *layout = air ? ATMOSPHERE : !strcmp(filetype, "band") ? BAND : SURFACE;
    for (size_t i = 0; layout[i].name; ++i) read_array(&from, &layout[i], &database->arrays[i], clamped);
    if (layout == SURFACE && H5Lexists(from.file, SHADE[0].name, H5P_DEFAULT) > 0) read_more(&from, database, SHADE, clamped);
    if (layout == SURFACE && H5Lexists(from.file, TRACKS[0].name, H5P_DEFAULT) > 0) {
        read_more(&from, database, TRACKS, clamped);
        database->tracked = 1;
    }
    database->lunar = !strcmp(found, "lunar_atmq");
    if (air && H5Lexists(from.file, LIGHT, H5P_DEFAULT) > 0) read_tilted(&from, database, clamped);
    if (air && H5Lexists(from.file, NIGHT[0].name, H5P_DEFAULT) > 0) read_night(&from, database, clamped);
    if (layout == BAND) database->material_names = read_names(&from, array_of(database, "reflectance")->axes[0].count);
    H5Fclose(from.file);
}

const struct array *array_of(const struct database *database, const char *name)
{
    for (size_t i = 0; i < ARRAYS && database->arrays[i].name; ++i)
        if (!strcmp(database->arrays[i].name, name)) return &database->arrays[i];
    fail("%s: '%s' was not read", database->path, name);
    return NULL;
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
    if (!isfinite(value)) fail("%s: found a value that is not finite; allowed: finite numbers", axis->name);
    size_t count = axis->count;
    if (!strcmp(axis->rule, "exact")) {
        for (size_t i = 0; i < count; ++i)
            if (axis->nodes[i] == value) return (struct place){i, i, 0.0};
        fail("%s: found %g; allowed: a code of the file", axis->name, value);
    }
    const double first = axis->nodes[0];
    int periodic = !strcmp(axis->rule, "linear_periodic");
    if (periodic) value = first + modulo(value - first, axis->period);
    if (!strcmp(axis->rule, "linear") && axis->period > 0) value -= axis->period * floor((value - first) / axis->period);
    if (!strcmp(axis->rule, "linear_folded"))
        value = fabs(modulo(value + axis->period / 2, axis->period) - axis->period / 2);
    const double last = periodic ? first + axis->period : axis->nodes[count - 1];
    if (!axis->clamps && !(value >= first && value <= last)) fail("%s: found %g; allowed: %g to %g", axis->name, value, first, last);
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

static double interpolated(const struct database *database, const char *name, const double *where)
{
    const struct array *array = array_of(database, name);
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

double value_at(const struct database *database, const char *name, const double *where)
{
    size_t entry = 0;
    while (database->night && WITHOUT_SOURCE[entry].quantity && strcmp(WITHOUT_SOURCE[entry].quantity, name)) ++entry;
    if (!database->night || !WITHOUT_SOURCE[entry].quantity) return interpolated(database, name, where);
    const struct array *array = array_of(database, name);
    const double lowest = array->axes[3].nodes[0], dark = array->axes[3].dark_below, height = where[3];
    if (!isfinite(height) || height >= lowest || (height > dark && lowest > CIVIL_TWILIGHT)) return interpolated(database, name, where);
    double place[AXES] = {0};
    for (size_t k = 0; k < array->rank; ++k) place[k] = where[k];
    place[3] = lowest;
    const double share = height > dark ? (height - dark) / (lowest - dark) : 0.0;
    const double light = share * interpolated(database, name, place);
    if (!WITHOUT_SOURCE[entry].emitted) return light;
    if (!strcmp(name, LIGHT)) place[3] = where[4]; /* the harmonic follows the line of sight there */
    return light + (1.0 - share) * interpolated(database, WITHOUT_SOURCE[entry].emitted, place);
}
