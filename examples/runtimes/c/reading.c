/* Arrays and attributes of a file, each checked before it is believed. */
#include "reading.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const double SKY_HARMONIC_CODES[HARMONICS] = {0, 10, 11, 20, 21, 22, 40, 41, 42, 43, 44};
static const double ZONAL_CODES[] = {0, 10, 20, 40};
/* How the format reads an axis; the last line holds for all that have none of their own. */
static const struct {
    const char *name, *rule, *or_rule;
    double period;
} RULES[] = {
    {"material", "exact", "exact", 0},
    {"harmonic", "exact", "exact", 0},
    {"zonal_harmonic", "exact", "exact", 0},
    {"channel", "exact", "exact", 0},
    {"absorber", "exact", "exact", 0},
    {"source_part", "exact", "exact", 0},
    {"direct_light_part", "exact", "exact", 0},
    {"thermal_sky_part", "exact", "exact", 0},
    {"scattered_sky_part", "exact", "exact", 0},
    {"thermal_harmonics_part", "exact", "exact", 0},
    {"scattered_harmonics_part", "exact", "exact", 0},
    {"ground_harmonics_part", "exact", "exact", 0},
    {"azimuth", "linear_periodic", "linear_periodic", 360},
    {"time", "linear_periodic", "linear", 24},
    {"response_hour", "linear_periodic", "linear_periodic", 24},
    {"forcing_time", "linear_periodic", "linear_periodic", 24},
    {NULL, "linear", "linear", 0},
};
/* Read at the nearest node outside, whatever the file says. */
static const char *const CLAMPED[] = {"share", "height_root", "direction", "surface_height", "target_height", "elevation_above_rise", "planck_temperature", NULL};
enum { LAST_CODE = 65535 };

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
    if (count < 1) sky_fail("%s: '%s' holds nothing", from->path, name);
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

/* Where the rule of an axis stands in `RULES`. */
static size_t rule_of(const char *axis)
{
    size_t rule = 0;
    while (RULES[rule].name && strcmp(RULES[rule].name, axis)) ++rule;
    return rule;
}

/* Whether values beyond an axis are read at its ends, by the format or by the caller. */
static int is_clamped(const char *axis, const char *const *clamped)
{
    for (size_t i = 0; CLAMPED[i]; ++i)
        if (!strcmp(CLAMPED[i], axis)) return 1;
    return sky_is_listed(clamped, strcmp(axis, "sky_source_elevation") ? axis : "source_elevation");
}

/* The rule of an axis must be that of the format, and its nodes must suit it. */
static void read_rule(const struct source *from, hid_t array, struct axis *axis, const char *const *clamped)
{
    char policy[NAME];
    const size_t rule = rule_of(axis->name);
    if (!sky_read_text(array, "interpolation", axis->rule) || (strcmp(axis->rule, RULES[rule].rule) && strcmp(axis->rule, RULES[rule].or_rule)))
        sky_fail("%s: the axis '%s' has interpolation '%s'; allowed: %s", from->path, axis->name, axis->rule, RULES[rule].rule);
    if (H5Aexists(array, "out_of_range") > 0 && (!sky_read_text(array, "out_of_range", policy) || (strcmp(policy, "error") && strcmp(policy, "clamp"))))
        sky_fail("%s: the axis '%s' has out_of_range '%s'; allowed: error, clamp", from->path, axis->name, policy);
    axis->clamps = is_clamped(axis->name, clamped) || (H5Aexists(array, "out_of_range") > 0 && !strcmp(policy, "clamp"));
    if (H5Aexists(array, "period") > 0 && !sky_read_number(array, "period", &axis->period)) axis->period = NAN;
    axis->dark_below = NAN;
    if (!strcmp(axis->name, "source_elevation") && H5Aexists(array, "dark_below") > 0 &&
        (!sky_read_number(array, "dark_below", &axis->dark_below) || !(axis->dark_below >= -90 && axis->dark_below <= 0)))
        sky_fail("%s: the axis '%s' has dark_below %g; allowed: -90 to 0", from->path, axis->name, axis->dark_below);
    if (axis->period != RULES[rule].period)
        sky_fail("%s: the axis '%s' has period %g; allowed: %g", from->path, axis->name, axis->period, RULES[rule].period);
    const double first = axis->nodes[0], last = axis->nodes[axis->count - 1];
    const int periodic = !strcmp(axis->rule, "linear_periodic");
    for (size_t i = 0; i < axis->count; ++i)
        if (!isfinite(axis->nodes[i]) || (i && axis->nodes[i] <= axis->nodes[i - 1]))
            sky_fail("%s: the axis '%s' is not a list of ascending numbers", from->path, axis->name);
    if ((periodic && last >= first + axis->period) || (axis->period > 0 && last > first + axis->period))
        sky_fail("%s: the axis '%s' has nodes beyond its period", from->path, axis->name);
    const int zonal = !strcmp(axis->name, "zonal_harmonic");
    if (zonal || !strcmp(axis->name, "harmonic")) {
        int known = zonal ? axis->count == 3 || axis->count == 4 : axis->count == 6 || axis->count == HARMONICS;
        for (size_t i = 0; known && i < axis->count; ++i) known = axis->nodes[i] == (zonal ? ZONAL_CODES : SKY_HARMONIC_CODES)[i];
        if (!known) sky_fail("%s: the axis '%s' has codes that are not those of the format", from->path, axis->name);
    } else if (!strcmp(axis->rule, "exact") && (first < 1 || last > LAST_CODE))
        sky_fail("%s: the axis '%s' has codes beyond 1 to %d", from->path, axis->name, LAST_CODE);
}

static hobj_ref_t read_axis(const struct source *from, struct axis *axis, const char *const *clamped)
{
    hsize_t length;
    hobj_ref_t reference;
    const int codes = !strcmp(RULES[rule_of(axis->name)].rule, "exact");
    hid_t array = sky_open_array(from, axis->name);
    axis->count = sky_read_shape(from, array, axis->name, 1, codes ? H5T_INTEGER : H5T_FLOAT, codes ? 4 : 8, &length);
    axis->nodes = sky_read_values(from, array, axis->name, H5T_NATIVE_DOUBLE, axis->count, sizeof(double));
    read_rule(from, array, axis, clamped);
    if (H5Rcreate(&reference, from->file, axis->name, H5R_OBJECT, -1) < 0) sky_fail("%s: '%s' cannot be read", from->path, axis->name);
    return reference;
}

/* Whether the dimension scales of an array, a list of references for each axis, begin with these. */
static int has_scales(hid_t array, const hobj_ref_t *axes, size_t rank)
{
    if (H5Aexists(array, "DIMENSION_LIST") <= 0) return 0;
    hid_t attribute = sky_id(H5Aopen(array, "DIMENSION_LIST", H5P_DEFAULT)), type = sky_id(H5Aget_type(attribute)), space = sky_id(H5Aget_space(attribute));
    hid_t of = H5Tget_class(type) == H5T_VLEN ? sky_id(H5Tget_super(type)) : H5I_INVALID_HID;
    int fits = of >= 0 && H5Tequal(of, H5T_STD_REF_OBJ) > 0 && H5Sget_simple_extent_npoints(space) == (hssize_t)rank;
    hvl_t lists[AXES] = {{0, NULL}};
    if (fits && H5Aread(attribute, type, lists) >= 0) {
        for (size_t k = 0; k < rank; ++k) fits = fits && lists[k].len > 0 && *(hobj_ref_t *)lists[k].p == axes[k];
        H5Dvlen_reclaim(type, space, H5P_DEFAULT, lists);
    } else {
        fits = 0;
    }
    return fits;
}

void sky_read_array(const struct source *from, const struct layout *layout, struct array *array, const char *const *clamped)
{
    hobj_ref_t references[AXES];
    hsize_t lengths[AXES];
    array->name = layout->name;
    while (array->rank < AXES && layout->axes[array->rank]) ++array->rank;
    hid_t stored = sky_open_array(from, layout->name);
    size_t count = sky_read_shape(from, stored, layout->name, array->rank, H5T_FLOAT, sizeof(float), lengths);
    for (size_t k = 0; k < array->rank; ++k) {
        struct axis *axis = &array->axes[k];
        axis->name = layout->axes[k];
        references[k] = read_axis(from, axis, clamped);
        if (lengths[k] != axis->count)
            sky_fail("%s: '%s' has %llu values along '%s', which has %zu nodes", from->path, layout->name, (unsigned long long)lengths[k], axis->name, axis->count);
    }
    if (!has_scales(stored, references, array->rank)) sky_fail("%s: '%s' has other dimension scales than its axes", from->path, layout->name);
    array->values = sky_read_values(from, stored, layout->name, H5T_NATIVE_FLOAT, count, sizeof(float));
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(array->values[i]) || array->values[i] < layout->least || array->values[i] > layout->most)
            sky_fail("%s: '%s' holds %g; allowed: %g to %g", from->path, layout->name, array->values[i], layout->least, layout->most);
}
