/* A database, read and checked whole before the first pixel. */
#ifndef DATABASE_H
#define DATABASE_H

#include "call.h"
#include "pixels.h"

#include <hdf5.h>
#include <stddef.h>

/* Deflate packs at most 1032 bytes into one: a file that claims more does not hold it. */
enum { PACKING = 1100, SMALL = 1 << 20 };
enum { NAME = 64 };

struct database {
    const char *path;
    SkyDatabase *arrays;        /* of the kernel */
    int32_t *codes;             /* of the materials, ascending; of a .band or .htt */
    const char **names;         /* of the materials */
    size_t materials;
    char ground_material[NAME]; /* empty where the file names none */
    int lunar;                  /* its source is the Moon */
};

/* Read a file of a kind, SKY_SURFACE, SKY_BAND or SKY_AIR, or fail; `clamped` names axes whose ends hold outside. */
void sky_open_database(struct database *database, const char *path, int32_t kind, const char *const *clamped);

/* Code of a material by its name; 0 where the database has none of it. */
int32_t sky_code_of(const struct database *database, const char *name);

/* An attribute of an HDF5 object, for other readers: a text of less than NAME bytes, or one number; 0 where it is not. */
int sky_read_text(hid_t item, const char *name, char *to);
/* The file type, into NAME bytes, of a file of our major version; others fail. */
void sky_read_filetype(hid_t file, const char *path, char *to);
int sky_read_number(hid_t item, const char *name, double *to);

#endif
