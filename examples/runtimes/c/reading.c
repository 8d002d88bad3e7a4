/* Arrays and attributes of a file, each checked before it is believed. */
#include "reading.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A text attribute into NAME bytes; 0 where there is none, or it is not one text that fits. */
int sky_read_text(hid_t item, const char *name, char *to)
{
    memset(to, 0, NAME);
    if (H5Aexists(item, name) <= 0) return 0;
    hid_t attribute = sky_id(H5Aopen(item, name, H5P_DEFAULT)), type = sky_id(H5Aget_type(attribute)), space = sky_id(H5Aget_space(attribute));
    int fits = H5Tget_class(type) == H5T_STRING && H5Sget_simple_extent_npoints(space) == 1;
    if (fits && H5Tis_variable_str(type) > 0) {
        char *text = NULL;
        fits = H5Aread(attribute, type, &text) >= 0 && text && strlen(text) < NAME;
        if (fits) strcpy(to, text);
        if (text) H5free_memory(text);
    } else if (fits) {
        fits = H5Tget_size(type) < NAME && H5Aread(attribute, type, to) >= 0;
    }
    return fits;
}

void sky_read_filetype(hid_t file, const char *path, char *to)
{
    char version[NAME] = "";
    const size_t major = strcspn(SKYSHINE_FORMAT, ".") + 1;
    if (!sky_read_text(file, "filetype", to) || !sky_read_text(file, "format_version", version) || strncmp(version, SKYSHINE_FORMAT, major))
        sky_fail("%s: has '%s' %s; allowed: formats %.*sx", path, to, version, (int)major, SKYSHINE_FORMAT);
}

/* A number attribute; 0 where it is not one number. */
int sky_read_number(hid_t item, const char *name, double *to)
{
    hid_t attribute = sky_id(H5Aopen(item, name, H5P_DEFAULT)), type = sky_id(H5Aget_type(attribute)), space = sky_id(H5Aget_space(attribute));
    H5T_class_t kind = H5Tget_class(type);
    int fits = (kind == H5T_INTEGER || kind == H5T_FLOAT) && H5Sget_simple_extent_npoints(space) == 1 &&
               H5Aread(attribute, H5T_NATIVE_DOUBLE, to) >= 0;
    return fits;
}

/* So many number attributes in one dimension, or one without; 0 where it is not that. */
int sky_read_numbers(hid_t item, const char *name, size_t count, double *to)
{
    if (H5Aexists(item, name) <= 0) return 0;
    hid_t attribute = sky_id(H5Aopen(item, name, H5P_DEFAULT)), type = sky_id(H5Aget_type(attribute)), space = sky_id(H5Aget_space(attribute));
    H5T_class_t kind = H5Tget_class(type);
    const int flat = H5Sget_simple_extent_type(space) == (count > 1 ? H5S_SIMPLE : H5S_SCALAR) && H5Sget_simple_extent_ndims(space) == (count > 1);
    int fits = (kind == H5T_INTEGER || kind == H5T_FLOAT) && flat && H5Sget_simple_extent_npoints(space) == (hssize_t)count &&
               H5Aread(attribute, H5T_NATIVE_DOUBLE, to) >= 0;
    return fits;
}

/* An array of this very file; its values may not come from another one. */
hid_t sky_open_array(const struct source *from, const char *name)
{
    H5L_info_t link;
    if (H5Lexists(from->file, name, H5P_DEFAULT) <= 0) sky_fail("%s: lacks '%s'", from->path, name);
    if (H5Lget_info(from->file, name, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
        sky_fail("%s: '%s' is a link to somewhere else", from->path, name);
    hid_t array = sky_id(H5Dopen2(from->file, name, H5P_DEFAULT));
    if (array < 0) sky_fail("%s: '%s' is not an array", from->path, name);
    hid_t how = sky_id(H5Dget_create_plist(array));
    const int elsewhere = H5Pget_layout(how) == H5D_VIRTUAL || H5Pget_external_count(how) != 0;
    if (elsewhere) sky_fail("%s: '%s' is kept in another file", from->path, name);
    return array;
}

/* Lengths of the axes of an array of `rank`, whose values must be of a class and size; returns the number of values. */
size_t sky_read_shape(const struct source *from, hid_t array, const char *name, size_t rank, H5T_class_t kind, size_t size, hsize_t *lengths)
{
    hid_t space = sky_id(H5Dget_space(array)), type = sky_id(H5Dget_type(array));
    if (H5Tget_class(type) != kind || H5Tget_size(type) != size) sky_fail("%s: '%s' has values of another type", from->path, name);
    if (H5Sget_simple_extent_type(space) != H5S_SIMPLE || H5Sget_simple_extent_ndims(space) != (int)rank)
        sky_fail("%s: '%s' does not have %zu axes", from->path, name, rank);
    H5Sget_simple_extent_dims(space, lengths, NULL);
    double count = 1;
    for (size_t k = 0; k < rank; ++k) count *= (double)lengths[k];
    if (count < 1) sky_fail("%s: '%s' has nothing", from->path, name);
    if (count * (double)size > from->bytes) sky_fail("%s: '%s' claims more bytes than the file can hold", from->path, name);
    return (size_t)count;
}

void *sky_read_values(const struct source *from, hid_t array, const char *name, hid_t type, size_t count, size_t size)
{
    void *values = sky_allocate(count, size);
    if (H5Dread(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) sky_fail("%s: '%s' cannot be read", from->path, name);
    return values;
}

int sky_is_listed(const char *const *list, const char *name)
{
    for (size_t i = 0; list && list[i]; ++i)
        if (!strcmp(list[i], name)) return 1;
    return 0;
}

/* Number of a rule by its name, or failure. */
static int32_t rule_of(const struct source *from, hid_t array, const char *axis)
{
    static const char *const NAMES[] = {"linear", "linear_periodic", "exact"};
    char rule[NAME];
    sky_read_text(array, "interpolation", rule);
    for (int32_t k = 0; k < 3; ++k)
        if (!strcmp(rule, NAMES[k])) return k;
    sky_fail("%s: the axis '%s' has interpolation '%s'; allowed: linear, linear_periodic, exact", from->path, axis, rule);
}

/* An axis of an array, handed over; its length and its reference. */
static size_t read_axis(const struct source *from, SkyDatabase *database, int32_t number, int32_t place, const char *name,
                        const char *const *clamped, hobj_ref_t *reference)
{
    char policy[NAME] = "";
    double period = 0.0, dark = NAN;
    hsize_t length;
    hid_t array = sky_open_array(from, name);
    const int32_t rule = rule_of(from, array, name);
    const int codes = rule == SKY_EXACT, stated = H5Aexists(array, "out_of_range") > 0;
    const size_t count = sky_read_shape(from, array, name, 1, codes ? H5T_INTEGER : H5T_FLOAT, codes ? 4 : 8, &length);
    const double *nodes = sky_read_values(from, array, name, H5T_NATIVE_DOUBLE, count, sizeof(double));
    if (stated && (!sky_read_text(array, "out_of_range", policy) || (strcmp(policy, "error") && strcmp(policy, "clamp"))))
        sky_fail("%s: the axis '%s' has out_of_range '%s'; allowed: error, clamp", from->path, name, policy);
    if (H5Aexists(array, "period") > 0 && !sky_read_number(array, "period", &period)) period = NAN;
    if (H5Aexists(array, "dark_below") > 0 && !sky_read_number(array, "dark_below", &dark)) dark = NAN;
    if (H5Rcreate(reference, from->file, name, H5R_OBJECT, -1) < 0) sky_fail("%s: '%s' cannot be read", from->path, name);
    const int clamps = sky_is_listed(clamped, strcmp(name, "sky_source_elevation") ? name : "source_elevation");
    skyshine_set_axis(database, number, place, nodes, count, rule, period, dark, clamps || !strcmp(policy, "clamp"));
    return count;
}

/* Whether the dimension scales of an array, a list of references for each axis, begin with these. */
static int has_scales(hid_t array, const hobj_ref_t *axes, size_t rank)
{
    if (H5Aexists(array, "DIMENSION_LIST") <= 0) return 0;
    hid_t attribute = sky_id(H5Aopen(array, "DIMENSION_LIST", H5P_DEFAULT)), type = sky_id(H5Aget_type(attribute)), space = sky_id(H5Aget_space(attribute));
    hid_t of = H5Tget_class(type) == H5T_VLEN ? sky_id(H5Tget_super(type)) : H5I_INVALID_HID;
    int fits = of >= 0 && H5Tequal(of, H5T_STD_REF_OBJ) > 0 && H5Sget_simple_extent_npoints(space) == (hssize_t)rank;
    hvl_t lists[SKY_AXES] = {{0, NULL}};
    if (fits && H5Aread(attribute, type, lists) >= 0) {
        for (size_t k = 0; k < rank; ++k) fits = fits && lists[k].len > 0 && *(hobj_ref_t *)lists[k].p == axes[k];
        H5Dvlen_reclaim(type, space, H5P_DEFAULT, lists);
    } else {
        fits = 0;
    }
    return fits;
}

/* Whether one of the words of a text is a name. */
static int has_word(const char *text, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = text; (at = strstr(at, name)); ++at)
        if ((at == text || at[-1] == ' ') && (!at[length] || at[length] == ' ')) return 1;
    return 0;
}

/* The values of an array of which the file has differences along an axis, `stride` values apart. */
static void add_up(float *values, size_t count, size_t length, size_t stride)
{
    for (size_t start = 0; start < count; start += length * stride)
        for (size_t i = start + stride; i < start + length * stride; ++i) values[i] += values[i - stride];
}

void sky_read_array(const struct source *from, SkyDatabase *database, int32_t kind, int32_t array, const char *const *clamped)
{
    hobj_ref_t references[SKY_AXES];
    hsize_t lengths[SKY_AXES];
    const char *name = skyshine_array_name(kind, array);
    int32_t rank = 0;
    while (skyshine_axis_name(kind, array, rank)) ++rank;
    hid_t stored = sky_open_array(from, name);
    const size_t count = sky_read_shape(from, stored, name, (size_t)rank, H5T_FLOAT, sizeof(float), lengths);
    float *values = sky_read_values(from, stored, name, H5T_NATIVE_FLOAT, count, sizeof(float));
    char differences[NAME];
    sky_read_text(stored, "differences", differences);
    size_t stride = 1;
    for (int32_t k = rank - 1; k >= 0; stride *= (size_t)lengths[k--])
        if (has_word(differences, skyshine_axis_name(kind, array, k))) add_up(values, count, (size_t)lengths[k], stride);
    skyshine_set_array(database, array, values);
    for (int32_t k = 0; k < rank; ++k) {
        const char *axis = skyshine_axis_name(kind, array, k);
        const size_t nodes = read_axis(from, database, array, k, axis, clamped, &references[k]);
        if (lengths[k] != nodes)
            sky_fail("%s: '%s' has %llu values along '%s', which has %zu nodes", from->path, name, (unsigned long long)lengths[k], axis, nodes);
    }
    if (!has_scales(stored, references, (size_t)rank)) sky_fail("%s: '%s' has other dimension scales than its axes", from->path, name);
}
