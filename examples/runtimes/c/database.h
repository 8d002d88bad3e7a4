/* A database, read and checked whole before the first pixel. */
#ifndef DATABASE_H
#define DATABASE_H

#include "call.h"

#include <hdf5.h>
#include <stddef.h>

/* Deflate packs at most 1032 bytes into one: a file that claims more does not hold it. */
enum { PACKING = 1100, SMALL = 1 << 20 };
enum { AXES = 5, ARRAYS = 40, NAME = 64 };

/* Codes 10 l + m of the harmonics. */
enum { HARMONICS = 11 };
extern const double SKY_HARMONIC_CODES[HARMONICS];

struct axis {
    const char *name;
    char rule[NAME];
    double *nodes, period; /* period 0 where it does not repeat */
    size_t count;
    int clamps;
    double dark_below; /* of source elevations: no light of the source is left there; NaN where the file does not say */
};

struct array {
    const char *name;
    size_t rank;
    struct axis axes[AXES];
    float *values;
};

/* What a file must hold: the names of the axes of an array, and the range of its values. */
struct layout {
    const char *name;
    const char *axes[AXES];
    double least, most;
};

#define SKY_TOP_KM 100.0        /* altitude above which there is no air */
#define SKY_FARTHEST_KM 100000.0 /* altitude of observers in space, at most */

/* What an atmosphere states; lengths in km. */
struct channels {
    double ground_km, scale_km;
    double ends[3][2]; /* of range, altitude and elevation */
    int clamps[3];     /* values beyond them are read at the ends */
};

struct database {
    const char *path;
    struct array arrays[ARRAYS];
    int tilted;            /* it has harmonics of the light around faces */
    double ground[3];      /* emissivity, temperature and emitted radiance of the ground; NaN where it does not state them */
    char ground_material[NAME]; /* of the ground; empty where it names none */
    double ground_code, ground_albedo; /* of an .htt that holds the ground before tilted faces; 0 where it does not */
    int tracked;           /* it has the tracks of Sun and Moon */
    int lunar;             /* its source is the Moon */
    struct channels channels;
    const char **material_names; /* as many as the axis 'material' has nodes; of a .band only */
};

/* Read a file of a type ("htt", "band" or "atmq"), or fail; `clamped` names axes whose ends hold outside. */
void sky_open_database(struct database *database, const char *path, const char *filetype, const char *const *clamped);

/* An attribute of an HDF5 object, for other readers: a text of less than NAME bytes, or one number; 0 where it is not. */
int sky_read_text(hid_t item, const char *name, char *to);
int sky_read_number(hid_t item, const char *name, double *to);

const struct array *sky_array_of(const struct database *database, const char *name);

int sky_holds(const struct database *database, const char *name);

/* The last axis of an array: the codes of harmonics. */
const struct axis *sky_codes_of(const struct database *database, const char *name);

/* Linear interpolation in every axis of an array, at one value for each. */
double sky_value_at(const struct database *database, const char *name, const double *where);

/* Fail where an atmosphere and a band are not of the same wavelengths. */
void sky_compare_wavelengths(const struct database *air, const struct database *band);

/* How many wavelengths the light of an atmosphere is given at. */
size_t sky_wavelengths_of(const struct database *air);

#endif
