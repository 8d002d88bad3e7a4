/* Levels are read and checked whole when the first pixel asks for them. */
#include "texture.h"
#include "database.h"

#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { TOTAL = 65535, CODES = 65536 };

/* An array of 16-bit integers of this very file: its lengths and values. */
static uint16_t *read_plane(hid_t file, const char *path, double most, const char *name, int rank, hsize_t *lengths)
{
    char part[2 * NAME];
    H5L_info_t link;
    for (const char *end = name; end; ) {
        end = strchr(end + 1, '/');
        snprintf(part, sizeof part, "%.*s", end ? (int)(end - name) : (int)strlen(name), name);
        if (H5Lexists(file, part, H5P_DEFAULT) <= 0) fail("%s: lacks '%s'", path, name);
        if (H5Lget_info(file, part, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
            fail("%s: '%s' is a link to somewhere else", path, name);
    }
    hid_t array = H5Dopen2(file, name, H5P_DEFAULT);
    if (array < 0) fail("%s: '%s' is not an array", path, name);
    hid_t how = H5Dget_create_plist(array), type = H5Dget_type(array), space = H5Dget_space(array);
    if (H5Pget_layout(how) == H5D_VIRTUAL || H5Pget_external_count(how) != 0) fail("%s: '%s' is kept in another file", path, name);
    if (H5Tget_class(type) != H5T_INTEGER || H5Tget_size(type) != 2 || H5Tget_sign(type) != H5T_SGN_NONE)
        fail("%s: '%s' has values of another type", path, name);
    if (H5Sget_simple_extent_type(space) != H5S_SIMPLE || H5Sget_simple_extent_ndims(space) != rank)
        fail("%s: '%s' does not have %d axes", path, name, rank);
    H5Sget_simple_extent_dims(space, lengths, NULL);
    double count = 1;
    for (int k = 0; k < rank; ++k) count *= (double)lengths[k];
    if (count < 1) fail("%s: '%s' holds nothing", path, name);
    if (count * 2 > most) fail("%s: '%s' claims more bytes than the file can hold", path, name);
    uint16_t *values = allocate((size_t)count, sizeof *values);
    if (H5Dread(array, H5T_NATIVE_UINT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) fail("%s: '%s' cannot be read", path, name);
    H5Sclose(space);
    H5Tclose(type);
    H5Pclose(how);
    H5Dclose(array);
    return values;
}

/* Which codes are those of the file's materials, or 0. */
static char *known_codes(hid_t file, const char *path, double most)
{
    hsize_t count;
    uint16_t *codes = read_plane(file, path, most, "materials/material", 1, &count);
    char *known = allocate(CODES, 1);
    known[0] = 1;
    for (hsize_t i = 0; i < count; ++i) {
        if (codes[i] < 1 || (i && codes[i] <= codes[i - 1])) fail("%s: the codes of its materials do not ascend from 1", path);
        known[codes[i]] = 1;
    }
    free(codes);
    return known;
}

static void read_level(struct texture *texture, unsigned number)
{
    char name[NAME], found[NAME] = "", version[NAME] = "";
    const char *path = texture->path;
    struct stat on_disk;
    hid_t file = H5I_INVALID_HID;
    if (stat(path, &on_disk) == 0 && S_ISREG(on_disk.st_mode)) file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0) fail("%s: is not a readable HDF5 file", path);
    const double most = (double)PACKING * (double)on_disk.st_size + SMALL;
    if (!read_text(file, "filetype", found) || strcmp(found, "tmm") || !read_text(file, "format_version", version) || strncmp(version, "1.", 2))
        fail("%s: holds '%s' %s; allowed: tmm 1.x", path, found, version);
    char *known = known_codes(file, path, most);
    hsize_t plane[2], mixed[3], weighted[3];
    struct level *level = &texture->levels[number];
    snprintf(name, sizeof name, "levels/%u/code", number);
    uint16_t *first = read_plane(file, path, most, name, 2, plane);
    snprintf(name, sizeof name, "levels/%u/mix_code", number);
    level->codes = read_plane(file, path, most, name, 3, mixed);
    snprintf(name, sizeof name, "levels/%u/mix_weight", number);
    level->weights = read_plane(file, path, most, name, 3, weighted);
    for (int k = 0; k < 3; ++k)
        if (mixed[k] != (k < 2 ? plane[k] : COMPONENTS) || weighted[k] != mixed[k]) fail("%s: the arrays of level %u do not fit each other", path, number);
    double total = 0;
    hid_t weights = H5Dopen2(file, name, H5P_DEFAULT);
    if (H5Aexists(weights, "total") <= 0 || !read_number(weights, "total", &total) || total != TOTAL)
        fail("%s: the weights of level %u do not state their total, %d", path, number, TOTAL);
    H5Dclose(weights);
    for (size_t texel = 0; texel < plane[0] * plane[1]; ++texel) {
        const uint16_t *codes = &level->codes[COMPONENTS * texel], *shares = &level->weights[COMPONENTS * texel];
        long sum = 0;
        for (int k = 0; k < COMPONENTS; ++k) {
            sum += shares[k];
            if (!known[codes[k]] || codes[0] != first[texel]) fail("%s: level %u has codes that are not those of its materials", path, number);
            if (first[texel] && !codes[k] && shares[k]) fail("%s: level %u gives weight to no material", path, number);
        }
        if (sum != TOTAL) fail("%s: the weights of level %u do not sum to %d", path, number, TOTAL);
    }
    level->height = plane[0];
    level->width = plane[1];
    free(first);
    free(known);
    H5Fclose(file);
}

void open_texture(struct texture *texture, const char *path)
{
    texture->path = path;
    read_level(texture, 0);
}

static size_t place(double at, size_t whole, size_t count)
{
    const size_t cell = (size_t)(at * (double)count / (double)whole);
    return cell < count ? cell : count - 1;
}

size_t mixture_at(struct texture *texture, double across, double down, double number, double *codes, double *shares)
{
    const struct level *finest = &texture->levels[0];
    if (!(across >= 0 && across <= (double)finest->width && down >= 0 && down <= (double)finest->height))
        fail("texel: found [%g, %g]; allowed: 0 to %zu, 0 to %zu", across, down, finest->width, finest->height);
    if (!(number >= 0 && number < LEVELS) || number != floor(number)) fail("level: found %g; allowed: a level of the texture", number);
    struct level *level = &texture->levels[(unsigned)number];
    if (!level->codes) read_level(texture, (unsigned)number);
    const size_t row = place(down, finest->height, level->height), column = place(across, finest->width, level->width);
    const size_t first = COMPONENTS * (row * level->width + column);
    if (!level->codes[first]) fail("texel: [%g, %g] has no material", across, down);
    size_t count = 0;
    for (size_t k = first; k < first + COMPONENTS; ++k) {
        if (!level->weights[k]) continue;
        codes[count] = level->codes[k];
        shares[count++] = level->weights[k] / (double)TOTAL;
    }
    return count;
}
