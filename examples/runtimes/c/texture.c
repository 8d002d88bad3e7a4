/* Levels are read and checked whole when the first pixel asks for them. */
#include "database.h"

#include <hdf5.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { TOTAL = 65535, SHADE_TOTAL = 255, CODES = 65536 };

enum { COMPONENTS = SKYSHINE_COMPONENTS, LEVELS = 32 };

/* One mip level: three codes and three weights a texel, and its share in the shade where the file has that. */
struct level {
    size_t height, width;
    uint16_t *codes, *weights;
    uint8_t *shade;
    struct block *memory;
};

struct skyshine_texture {
    struct level levels[LEVELS];
    char path[];
};

/* An array of unsigned integers of a size, one or two bytes, of this very file: its lengths and values. */
static void *read_plane(hid_t file, const char *path, double most, const char *name, size_t size, int rank, hsize_t *lengths)
{
    char part[2 * NAME];
    H5L_info_t link;
    for (const char *end = name; end; ) {
        end = strchr(end + 1, '/');
        snprintf(part, sizeof part, "%.*s", end ? (int)(end - name) : (int)strlen(name), name);
        if (H5Lexists(file, part, H5P_DEFAULT) <= 0) sky_fail("%s: lacks '%s'", path, name);
        if (H5Lget_info(file, part, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
            sky_fail("%s: '%s' is a link to somewhere else", path, name);
    }
    hid_t array = sky_id(H5Dopen2(file, name, H5P_DEFAULT));
    if (array < 0) sky_fail("%s: '%s' is not an array", path, name);
    hid_t how = sky_id(H5Dget_create_plist(array)), type = sky_id(H5Dget_type(array)), space = sky_id(H5Dget_space(array));
    if (H5Pget_layout(how) == H5D_VIRTUAL || H5Pget_external_count(how) != 0) sky_fail("%s: '%s' is kept in another file", path, name);
    if (H5Tget_class(type) != H5T_INTEGER || H5Tget_size(type) != size || H5Tget_sign(type) != H5T_SGN_NONE)
        sky_fail("%s: '%s' has values of another type", path, name);
    if (H5Sget_simple_extent_type(space) != H5S_SIMPLE || H5Sget_simple_extent_ndims(space) != rank)
        sky_fail("%s: '%s' does not have %d axes", path, name, rank);
    H5Sget_simple_extent_dims(space, lengths, NULL);
    double count = 1;
    for (int k = 0; k < rank; ++k) count *= (double)lengths[k];
    if (count < 1) sky_fail("%s: '%s' has nothing", path, name);
    if (count * (double)size > most) sky_fail("%s: '%s' claims more bytes than the file can hold", path, name);
    void *values = sky_allocate((size_t)count, size);
    if (H5Dread(array, size == 1 ? H5T_NATIVE_UINT8 : H5T_NATIVE_UINT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) sky_fail("%s: '%s' cannot be read", path, name);
    return values;
}

/* Which codes are those of the file's materials, or 0. */
static char *known_codes(hid_t file, const char *path, double most)
{
    hsize_t count;
    uint16_t *codes = read_plane(file, path, most, "materials/material", 2, 1, &count);
    char *known = sky_allocate(CODES, 1);
    known[0] = 1;
    for (hsize_t i = 0; i < count; ++i) {
        if (codes[i] < 1 || (i && codes[i] <= codes[i - 1])) sky_fail("%s: the codes of its materials do not ascend from 1", path);
        known[codes[i]] = 1;
    }
    sky_release(codes);
    return known;
}

/* Refuse an array that does not state what its values sum to, or are parts of. */
static void need_total(hid_t file, const char *path, const char *name, unsigned level, int wanted)
{
    double total = 0;
    hid_t array = sky_id(H5Dopen2(file, name, H5P_DEFAULT));
    if (H5Aexists(array, "total") <= 0 || !sky_read_number(array, "total", &total) || total != wanted)
        sky_fail("%s: '%s' of level %u does not state its total, %d", path, strrchr(name, '/') + 1, level, wanted);
}

/* The layer of shade, which a file has on all levels or on none. */
static uint8_t *read_shade(hid_t file, const char *path, double most, unsigned number, const hsize_t *plane)
{
    char name[NAME];
    hsize_t lengths[2];
    if (H5Lexists(file, "levels/0/shade", H5P_DEFAULT) <= 0) return NULL;
    snprintf(name, sizeof name, "levels/%u/shade", number);
    uint8_t *shade = read_plane(file, path, most, name, 1, 2, lengths);
    if (lengths[0] != plane[0] || lengths[1] != plane[1]) sky_fail("%s: the arrays of level %u do not fit each other", path, number);
    need_total(file, path, name, number, SHADE_TOTAL);
    return shade;
}

static void read_level(struct skyshine_texture *texture, unsigned number)
{
    char name[NAME], found[NAME];
    const char *path = texture->path;
    struct stat on_disk;
    hid_t file = H5I_INVALID_HID;
    if (stat(path, &on_disk) == 0 && S_ISREG(on_disk.st_mode)) file = sky_id(H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT));
    if (file < 0) sky_fail("%s: is not a readable HDF5 file", path);
    const double most = (double)PACKING * (double)on_disk.st_size + SMALL;
    sky_read_filetype(file, path, found);
    if (strcmp(found, "tmm")) sky_fail("%s: has '%s'; allowed: tmm", path, found);
    char *known = known_codes(file, path, most);
    hsize_t plane[2], mixed[3], weighted[3];
    struct level read = {0}, *level = &read;
    snprintf(name, sizeof name, "levels/%u/code", number);
    uint16_t *first = read_plane(file, path, most, name, 2, 2, plane);
    snprintf(name, sizeof name, "levels/%u/mix_code", number);
    level->codes = read_plane(file, path, most, name, 2, 3, mixed);
    snprintf(name, sizeof name, "levels/%u/mix_weight", number);
    level->weights = read_plane(file, path, most, name, 2, 3, weighted);
    for (int k = 0; k < 3; ++k)
        if (mixed[k] != (k < 2 ? plane[k] : COMPONENTS) || weighted[k] != mixed[k]) sky_fail("%s: the arrays of level %u do not fit each other", path, number);
    need_total(file, path, name, number, TOTAL);
    for (size_t texel = 0; texel < plane[0] * plane[1]; ++texel) {
        const uint16_t *codes = &level->codes[COMPONENTS * texel], *shares = &level->weights[COMPONENTS * texel];
        long sum = 0;
        for (int k = 0; k < COMPONENTS; ++k) {
            sum += shares[k];
            if (!known[codes[k]] || codes[0] != first[texel]) sky_fail("%s: level %u has codes that are not those of its materials", path, number);
            if (first[texel] && !codes[k] && shares[k]) sky_fail("%s: level %u gives weight to no material", path, number);
        }
        if (sum != TOTAL) sky_fail("%s: the weights of level %u do not sum to %d", path, number, TOTAL);
    }
    level->shade = read_shade(file, path, most, number, plane);
    level->height = plane[0];
    level->width = plane[1];
    sky_release(first);
    sky_release(known);
    level->memory = sky_keep();
    texture->levels[number] = read;
}

static size_t place(double at, size_t whole, size_t count)
{
    const size_t cell = (size_t)(at * (double)count / (double)whole);
    return cell < count ? cell : count - 1;
}

/* The level of a number, and the number of the texel at a point in it. */
static const struct level *level_at(struct skyshine_texture *texture, double across, double down, unsigned number, size_t *texel)
{
    const struct level *finest = &texture->levels[0];
    if (!(across >= 0 && across <= (double)finest->width && down >= 0 && down <= (double)finest->height))
        sky_fail("texel: found [%g, %g]; allowed: 0 to %zu, 0 to %zu", across, down, finest->width, finest->height);
    if (number >= LEVELS) sky_fail("level: found %u; allowed: a level of the texture", number);
    const struct level *level = &texture->levels[number];
    if (!level->codes) read_level(texture, number);
    const size_t row = place(down, finest->height, level->height), column = place(across, finest->width, level->width);
    *texel = row * level->width + column;
    return level;
}

static size_t mixture_at(struct skyshine_texture *texture, double across, double down, unsigned number, int32_t *codes, double *shares)
{
    size_t texel;
    const struct level *level = level_at(texture, across, down, number, &texel);
    const size_t first = COMPONENTS * texel;
    if (!level->codes[first]) sky_fail("texel: [%g, %g] has no material", across, down);
    size_t count = 0;
    for (size_t k = first; k < first + COMPONENTS; ++k) {
        if (!level->weights[k]) continue;
        codes[count] = level->codes[k];
        shares[count++] = level->weights[k] / (double)TOTAL;
    }
    return count;
}

skyshine_status skyshine_texture_open(const char *path, skyshine_texture **texture, skyshine_error *error)
{
    struct call call;
    sky_begin(&call, SKYSHINE_FILE_ERROR);
    struct skyshine_texture *volatile opened = calloc(1, sizeof *opened + strlen(path) + 1);
    if (!setjmp(call.failed)) {
        if (!opened) sky_fail("no memory is left");
        strcpy(opened->path, path);
        read_level(opened, 0);
        *texture = opened;
    } else {
        skyshine_texture_close(opened);
    }
    return sky_end(&call, error);
}

skyshine_status skyshine_texture_mixture(skyshine_texture *texture, double across, double down, unsigned level, size_t *count,
                                         int32_t codes[SKYSHINE_COMPONENTS], double shares[SKYSHINE_COMPONENTS], skyshine_error *error)
{
    struct call call;
    const int read = level < LEVELS && texture->levels[level].codes;
    sky_begin(&call, read ? SKYSHINE_VALUE_ERROR : SKYSHINE_FILE_ERROR);
    if (!setjmp(call.failed)) *count = mixture_at(texture, across, down, level, codes, shares);
    return sky_end(&call, error);
}

skyshine_status skyshine_texture_shade(skyshine_texture *texture, double across, double down, unsigned level, double *shade, skyshine_error *error)
{
    struct call call;
    const int read = level < LEVELS && texture->levels[level].codes;
    sky_begin(&call, read ? SKYSHINE_VALUE_ERROR : SKYSHINE_FILE_ERROR);
    if (!setjmp(call.failed)) {
        size_t texel;
        const struct level *at = level_at(texture, across, down, level, &texel);
        *shade = at->shade ? at->shade[texel] / (double)SHADE_TOTAL : 0.0;
    }
    return sky_end(&call, error);
}

void skyshine_texture_close(skyshine_texture *texture)
{
    if (!texture) return;
    for (size_t k = 0; k < LEVELS; ++k) sky_release_all(texture->levels[k].memory);
    free(texture);
}
