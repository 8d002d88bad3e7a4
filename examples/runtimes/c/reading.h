/* Arrays and attributes of a file, each checked before it is believed. */
#ifndef READING_H
#define READING_H

#include "database.h"

/* An open file. */
struct source {
    hid_t file;
    const char *path;
    double bytes;  /* most that an array of it can take */
};

/* So many number attributes in one dimension, or one without; 0 where it is not that. */
int sky_read_numbers(hid_t item, const char *name, size_t count, double *to);

/* An array of this very file; its values may not come from another one. */
hid_t sky_open_array(const struct source *from, const char *name);

/* Lengths of the axes of an array of `rank`, whose values must be of a class and size; returns the number of values. */
size_t sky_read_shape(const struct source *from, hid_t array, const char *name, size_t rank, H5T_class_t kind, size_t size, hsize_t *lengths);

void *sky_read_values(const struct source *from, hid_t array, const char *name, hid_t type, size_t count, size_t size);

/* An array of the kernel's list, with its axes, handed over to a database. */
void sky_read_array(const struct source *from, SkyDatabase *database, int32_t kind, int32_t array, const char *const *clamped);

/* Whether a list of texts, which ends in NULL, has one. */
int sky_is_listed(const char *const *list, const char *name);

#endif
