/* Files come from anywhere: nothing in one is believed before it is checked. */
#include "database.h"
#include "failure.h"
#include "reading.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

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

static const char **read_names(const struct source *from, size_t *count)
{
    hsize_t length;
    hid_t array = sky_open_array(from, "material_name"), type = sky_id(H5Dget_type(array));
    if (H5Tis_variable_str(type) <= 0) sky_fail("%s: 'material_name' is not text of variable length", from->path);
    *count = sky_read_shape(from, array, "material_name", 1, H5T_STRING, H5Tget_size(type), &length);
    char **stored = sky_read_values(from, array, "material_name", type, *count, sizeof(char *));
    const char **names = sky_allocate(*count, sizeof *names);
    int readable = 1;
    for (size_t i = 0; i < *count; ++i) {
        readable = readable && stored[i] && is_utf8(stored[i]);
        names[i] = stored[i] ? copy_of(stored[i]) : NULL;
    }
    H5Dvlen_reclaim(type, sky_id(H5Dget_space(array)), H5P_DEFAULT, stored);
    if (!readable) sky_fail("%s: 'material_name' holds what is not UTF-8 text", from->path);
    return names;
}

/* Names and codes of the materials. */
static void read_materials(const struct source *from, struct database *database)
{
    hsize_t length;
    database->names = read_names(from, &database->materials);
    hid_t array = sky_open_array(from, "material");
    const size_t count = sky_read_shape(from, array, "material", 1, H5T_INTEGER, 4, &length);
    if (count != database->materials) sky_fail("%s: 'material_name' has %zu names for %zu codes", from->path, database->materials, count);
    database->codes = sky_read_values(from, array, "material", H5T_NATIVE_INT32, count, sizeof(int32_t));
}

int32_t sky_code_of(const struct database *database, const char *name)
{
    for (size_t i = 0; i < database->materials; ++i)
        if (!strcmp(database->names[i], name)) return database->codes[i];
    return 0;
}

/* The numbers of the root's attributes; what is not a number stays NaN. */
static void read_numbers(const struct source *from, SkyDatabase *arrays)
{
    static const struct {
        const char *name;
        int32_t number;
        size_t count;
    } NUMBERS[] = {
        {"ground_emissivity", SKY_GROUND_EMISSIVITY, 1}, {"ground_temperature", SKY_GROUND_TEMPERATURE, 1},
        {"ground_radiance", SKY_GROUND_RADIANCE, 1},     {"ground_albedo", SKY_GROUND_ALBEDO, 1},
        {"ground_altitude_km", SKY_GROUND_ALTITUDE, 1},  {"scale_height_km", SKY_SCALE_HEIGHT, 1},
        {"range_km", SKY_RANGE_FIRST, 2},                {"altitude_km", SKY_ALTITUDE_FIRST, 2},
    };
    for (size_t k = 0; k < sizeof NUMBERS / sizeof *NUMBERS; ++k) {
        double values[2] = {NAN, NAN};
        if (!sky_read_numbers(from->file, NUMBERS[k].name, NUMBERS[k].count, values)) values[0] = values[1] = NAN;
        for (size_t i = 0; i < NUMBERS[k].count; ++i)
            skyshine_set_number(arrays, NUMBERS[k].number + (int32_t)i, values[i] >= 0 || NUMBERS[k].number > SKY_GROUND_CODE ? values[i] : NAN);
    }
}

/* The file must be of a kind, in a version that this library knows. */
static void check_type(const struct source *from, struct database *database, int32_t kind)
{
    static const char *const TYPES[] = {"htt", "band", "atmq"};
    char found[NAME];
    const char *wanted = TYPES[kind];
    sky_read_filetype(from->file, from->path, found);
    database->lunar = kind == SKY_AIR && !strcmp(found, "lunar_atmq");
    if (strcmp(found, wanted) && !database->lunar) sky_fail("%s: has '%s'; allowed: %s", from->path, found, wanted);
}

/* Before tilted faces lies the ground that the file names, if it has level faces of it. */
static void read_ground(const struct source *from, struct database *database, int32_t kind)
{
    sky_read_text(from->file, "ground_material", database->ground_material);
    if (kind == SKY_SURFACE && *database->ground_material)
        skyshine_set_number(database->arrays, SKY_GROUND_CODE, sky_code_of(database, database->ground_material));
}

void sky_open_database(struct database *database, const char *path, int32_t kind, const char *const *clamped)
{
    static const char *const LINE[] = {"range", "altitude", "elevation"};
    struct stat on_disk;
    struct source from = {H5I_INVALID_HID, path, 0};
    SkyFailure failure;
    if (stat(path, &on_disk) == 0 && S_ISREG(on_disk.st_mode)) from.file = sky_id(H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT));
    if (from.file < 0) sky_fail("%s: is not a readable HDF5 file", path);
    from.bytes = (double)PACKING * (double)on_disk.st_size + SMALL;
    check_type(&from, database, kind);
    database->path = copy_of(path);
    database->arrays = sky_allocate(1, skyshine_database_size());
    skyshine_database_begin(database->arrays, kind);
    for (int32_t i = 0; skyshine_array_name(kind, i); ++i)
        if (!skyshine_array_group(kind, i) || H5Lexists(from.file, skyshine_array_name(kind, i), H5P_DEFAULT) > 0)
            sky_read_array(&from, database->arrays, kind, i, clamped);
    if (kind != SKY_AIR) read_materials(&from, database);
    read_numbers(&from, database->arrays);
    for (int32_t k = 0; k < 3; ++k) skyshine_set_number(database->arrays, SKY_CLAMP_RANGE + k, sky_is_listed(clamped, LINE[k]));
    read_ground(&from, database, kind);
    sky_check(skyshine_database_check(database->arrays, &failure), &failure, path, -1);
}
