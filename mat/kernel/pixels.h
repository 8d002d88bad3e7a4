/* Radiance of pixels from the tables of a state, a band and a source: the interface of the library for runtimes.
 *
 * A caller reads files with what it has (h5py, libhdf5, h5wasm, a Rust crate), hands their arrays over, and gets
 * temperatures, quantities of the air and equation (1) of DSTO-TN-0193 for many places a call. Nothing is allocated,
 * written to a stream or kept between calls: memory is the caller's, failures are a status with a `SkyFailure`, which the
 * caller turns into a line of text. The results have the same bytes on every processor.
 *
 * Lengths are in km, angles in degree, times in hours of the local clock, temperatures in K, radiances in
 * W m^-2 sr^-1. Arrays of a call have one value for each of its `count` places, row by row; NULL where an argument may be
 * left out. Sizes are bytes. Functions without a number at their end call that for the vectors of this processor.
 *
 * Order of calls:
 *
 *     SkyDatabase *surface, *band, *air;       memory of skyshine_database_size() bytes each
 *     skyshine_database_begin(air, SKY_AIR);
 *     for each i from 0 while skyshine_array_name(SKY_AIR, i):  if the file has the array
 *         skyshine_set_array(air, i, values);  for each axis k: skyshine_set_axis(air, i, k, ...)
 *     skyshine_set_number(air, SKY_GROUND_ALTITUDE, ...) ...
 *     skyshine_database_check(air, &failure)   of the values themselves, which a hostile file may have wrong
 *     size = skyshine_tables_size(surface, band, air);  tables = memory of that size, aligned to 64 bytes
 *     skyshine_tables_make(tables, surface, band, air, &failure)
 *     scratch = memory of skyshine_scratch_size(tables), aligned to 64 bytes, one for each thread
 *     skyshine_pixel_terms(tables, count, materials, lines, &pixels, &terms, scratch, &failure)
 *
 * What was set is read until the tables are no longer used. Tables are constant once made: any number of threads may
 * read them, each with a scratch of its own.
 */
#ifndef SKYSHINE_PIXELS_H
#define SKYSHINE_PIXELS_H

#include <stddef.h>
#include <stdint.h>

typedef struct SkyDatabase SkyDatabase;
typedef struct SkyTables SkyTables;

/* ---- Failures ---- */

enum {
    SKY_OK = 0,
    SKY_OUTSIDE,   /* a value beyond an axis: `name` of the axis, `found`, `least`, `most`; not finite: NaN */
    SKY_CODE,      /* a material that the table lacks: `name` "material", `found` its code */
    SKY_TWILIGHT,  /* a source elevation in a twilight that the file does not have: allowed `least` and above, `most` and below */
    SKY_DIRECTION, /* a direction without length: `name` "normal", "to_source" or "to_observer" */
    SKY_SHARE,     /* a share beyond 0 to 1: `name` */
    SKY_LENGTH,    /* a range below 0 or not finite: `name` "range", `found` */
    SKY_NO_MATERIAL, /* a pixel all of whose shares are 0, or a share of code 0 */
    SKY_NO_RESPONSE, /* the surface file has no response to shade */
    SKY_NO_GROUND, /* the atmosphere names a ground that the surface file lacks, or states none */
    SKY_NOT_FINITE, /* `name`: heat or surroundings that are not finite numbers */
    SKY_LACKS,     /* a database: it lacks the array `name` */
    SKY_NODES,     /* a database: the nodes, the rule or the period of the axis `name` are not those of the format */
    SKY_VALUES,    /* a database: the array `name` has `found`; allowed `least` to `most` */
    SKY_SUM,       /* a database: a row of shares of the array `name` sums to `found`, not 1 */
    SKY_NUMBER,    /* a database: the number `name` is missing or is `found`; allowed `least` to `most` */
    SKY_BANDS      /* atmosphere and band have other wavelengths: of the band `found`, from `least` to `most` um */
};

typedef struct {
    int32_t status;           /* one of the above */
    int32_t kind;             /* SKY_SURFACE, SKY_BAND or SKY_AIR: the table that refuses */
    size_t row;               /* of the call: the first place that is refused */
    const char *name;         /* a constant text of the library */
    double found, least, most;
} SkyFailure;

/* ---- Databases ---- */

enum { SKY_SURFACE, SKY_BAND, SKY_AIR }; /* .htt, .band, .atmq or .lunar_atmq */
enum { SKY_AXES = 5, SKY_ARRAYS = 40 };
enum { SKY_LINEAR, SKY_PERIODIC, SKY_EXACT }; /* `interpolation` of an axis: linear, linear_periodic, exact */

/* Numbers of a database: the attributes of the file's root of that name, NaN until they are set. */
enum {
    SKY_GROUND_EMISSIVITY,  /* ground_emissivity; of SKY_SURFACE of the ground before tilted faces */
    SKY_GROUND_TEMPERATURE, /* ground_temperature, of SKY_AIR */
    SKY_GROUND_RADIANCE,    /* ground_radiance, of SKY_AIR */
    SKY_GROUND_ALBEDO,      /* ground_albedo, of SKY_SURFACE */
    SKY_GROUND_CODE,        /* code of the material that `ground_material` names: of SKY_SURFACE in that file, of SKY_AIR
                               in the surface file; leave it NaN where the file names none; 0 where the name is unknown */
    SKY_GROUND_ALTITUDE,    /* ground_altitude_km */
    SKY_SCALE_HEIGHT,       /* scale_height_km */
    SKY_RANGE_FIRST, SKY_RANGE_LAST,       /* range_km */
    SKY_ALTITUDE_FIRST, SKY_ALTITUDE_LAST, /* altitude_km */
    SKY_CLAMP_RANGE, SKY_CLAMP_ALTITUDE, SKY_CLAMP_ELEVATION, /* 1: values beyond these axes, which no array has, are
                                                                 read at their ends */
    SKY_NUMBERS
};

size_t skyshine_database_size(void);
void skyshine_database_begin(SkyDatabase *database, int32_t kind);

/* Name of the array of a kind at a place of the list of the format, and those of its axes; NULL behind the last one. */
const char *skyshine_array_name(int32_t kind, int32_t array);
const char *skyshine_axis_name(int32_t kind, int32_t array, int32_t axis);

/* Group of an array: 0 for those that every file has; of another group a file has all or none. */
int32_t skyshine_array_group(int32_t kind, int32_t array);

/* Values of an array in C's order, in single precision as stored. */
void skyshine_set_array(SkyDatabase *database, int32_t array, const float *values);

/* An axis of an array. `period` and `dark_below` are its attributes, 0 and NaN where it has none; `clamps` is 1 where the
 * file says so (out_of_range "clamp") or the user does (for `sky_source_elevation` as for `source_elevation`). */
void skyshine_set_axis(SkyDatabase *database, int32_t array, int32_t axis, const double *nodes, size_t count, int32_t rule,
                       double period, double dark_below, int32_t clamps);
void skyshine_set_number(SkyDatabase *database, int32_t number, double value);

/* Whether a database has an array, by its name. */
int32_t skyshine_has(const SkyDatabase *database, const char *array);

/* Refuse what no file of the format has: missing arrays, axes that do not ascend, rules and codes that are not those of the
 * format, values beyond their limits or not finite, shares that do not sum to 1. Returns the status. */
int32_t skyshine_database_check(const SkyDatabase *database, SkyFailure *failure);

/* ---- Tables ---- */

/* Of a surface, a band and an atmosphere, any of which may be NULL: what needs it is then not called. */
size_t skyshine_tables_size(const SkyDatabase *surface, const SkyDatabase *band, const SkyDatabase *air);
int32_t skyshine_tables_make(SkyTables *tables, const SkyDatabase *surface, const SkyDatabase *band, const SkyDatabase *air,
                             SkyFailure *failure);
size_t skyshine_scratch_size(const SkyTables *tables);

/* Wavelengths of the band, B; 1 without an atmosphere. */
size_t skyshine_wavelengths(const SkyTables *tables);

/* Linear interpolation in every axis of an array of a table, by its place in the list of the format; `where` has `count`
 * values for each of its axes, one axis behind the other. For tracks of Sun and Moon, the air's temperature and the like. */
int32_t skyshine_read(const SkyTables *tables, int32_t kind, int32_t array, size_t count, const double *where, double *values,
                      SkyFailure *failure);

/* ---- Temperatures: need the surface. Faces are lists of `count` values. ---- */

typedef struct {
    const int32_t *material; /* codes */
    const double *altitude, *azimuth, *slope;
} SkyFaces;

enum { SKY_STEPS = 288 }; /* of a day, each centred on its time, the first on midnight */

/* Temperatures in full sun under the whole sky, at `time` (count). */
int32_t skyshine_temperatures(const SkyTables *tables, size_t count, const SkyFaces *faces, const double *time,
                              double *temperature, SkyFailure *failure);

/* What stands around faces. With `each` 1 all lists but one have a row for each face, with 0 one row for all. */
typedef struct {
    const double *shaded;   /* SKY_STEPS a row: share of each step in which no light comes from the Sun's direction */
    const double *sky_view; /* open share of the sky */
    const double *facing;   /* temperature of the wall that hides the rest; NULL or NaN: that of the air */
    const double *facing_emissivity; /* NULL or NaN: 0.95 */
} SkySurroundings;

/* Change of the heat that faces absorb, (count, SKY_STEPS) [W m^-2]. */
int32_t skyshine_absorbed(const SkyTables *tables, size_t count, const SkyFaces *faces, const SkySurroundings *around,
                          int32_t each, double *absorbed, void *scratch, SkyFailure *failure);

/* Temperatures of faces that absorb other heat than that of the table: `absorbed` (count, steps) [W m^-2], means over
 * equal steps of every day; at `hours` (count, times). With `steps` 0, `absorbed` is not read and nothing changes. */
int32_t skyshine_heated(const SkyTables *tables, size_t count, const SkyFaces *faces, const double *absorbed, size_t steps,
                        const double *hours, size_t times, double *temperature, void *scratch, SkyFailure *failure);

/* Changes of temperature, (count, SKY_STEPS), by changes of heat (count, SKY_STEPS), of faces whose temperatures in the open
 * are given, (count, SKY_STEPS), NaN where they are not known, and the highest that they can have, (count). */
int32_t skyshine_changes(const SkyTables *tables, size_t count, const SkyFaces *faces, const double *absorbed,
                         const double *temperature, const double *highest, double *moved, void *scratch, SkyFailure *failure);

/* ---- Quantities of the air ---- */

enum {
    SKY_BETA_STAR,        /* (8) */
    SKY_PATH_RATIO,       /* (10), at the source's azimuth from the line */
    SKY_PATH_RATIO_ANGLE, /* (10), at an angle between line and source, of the source's elevation where the line enters the air */
    SKY_AMBIENT,          /* (20): light of the sky on a level face, over pi */
    SKY_DIRECT,           /* (36): light of the source on a face normal to it, over pi */
    SKY_HARMONIC,         /* coefficient of a harmonic of the light around the end of a line */
    SKY_GROUND_HARMONIC,  /* the same of the ground's emission, per unit of what it emits */
    SKY_OPTICAL_DEPTH,    /* -ln of the transmittance of emitted light, by wavelength alone */
    SKY_IN_AIR            /* 1 where the range ends in air, 0 where it would pass through the ground */
};

typedef struct {
    const double *range, *altitude, *elevation; /* of lines of sight, from the observer */
    const double *source_elevation; /* not of SKY_BETA_STAR, SKY_OPTICAL_DEPTH, SKY_IN_AIR; of SKY_GROUND_HARMONIC the
                                       temperature of the ground */
    const double *last;             /* azimuth, angle, or code of the harmonic; others do not read it */
} SkyPlaces;

/* A quantity at places: `values` (count), or (count, B) by wavelength. */
int32_t skyshine_quantity(const SkyTables *tables, int32_t quantity, int32_t by_wavelength, size_t count,
                          const SkyPlaces *places, double *values, void *scratch, SkyFailure *failure);

/* Light of the sky on faces at the ends of lines, over pi: of a slope and an azimuth from that of the source, (count) each.
 * `ground_temperature` (count) is that of the ground around; NULL or NaN: as the file states it, without a band. */
int32_t skyshine_ambient(const SkyTables *tables, int32_t by_wavelength, size_t count, const SkyPlaces *places, const double *slope,
                         const double *azimuth, const double *ground_temperature, double *values, void *scratch, SkyFailure *failure);

/* ---- Pixels: need all three. ---- */

/* Lists of `count` values where nothing else is said; M is the number of materials of a pixel, L that of lines: `count`,
 * each pixel at the end of its own, or 1, the line of the centre of their frame. */
typedef struct {
    const int32_t *material;     /* (count, M) codes; 0 where there is no more */
    const double *share;         /* (count, M); NULL: all of the first */
    const double *temperature;   /* (count, M); NULL or NaN: those of the surface file */
    const double *surface_altitude, *surface_azimuth, *surface_slope, *time;
    const double *range;         /* from the observer to the pixel's point */
    /* The lines at which the air is read, (L): range, altitude of the observer, elevation; elevation of the source and its
     * azimuth from the line; azimuth of the source from north eastward, NULL: the sky of level faces. */
    const double *line_range, *altitude, *elevation, *source_elevation, *source_azimuth, *source_heading;
    /* Directions from the point, (count, 3), of any length, in any frame. NULL: to east, north and up, of the face, of the
     * source (needs `source_heading`), and against the lines of sight of the next two. */
    const double *normal, *to_source, *to_observer;
    const double *sight_elevation, *sight_heading; /* of each pixel's line of sight; NULL: those of the lines */
    const double *lit;              /* share of the direct light that reaches the face; NULL: all */
    const double *sky_view;         /* open share of the sky above it; NULL: all */
    const double *wall_temperature; /* of what hides the rest; NULL or NaN: that of the air */
    const double *shade;            /* share of the face in the shade all day; NULL: none */
    const double *shaded_sky;       /* open share of the sky there, at most; NULL: 0.5 */
    const double *shaded_temperature; /* (count, M) there; NULL or NaN: by the response of the surface file */
    const int32_t *ground_material;   /* code of the ground around the face; NULL or 0: that of the atmosphere file, at the
                                         pixel's hour; where it names none, the temperature that it states */
    const double *ground_temperature; /* in place of it; NULL or NaN: that */
} SkyPixels;

/* Results, (count) each; NULL: not wanted. */
typedef struct {
    double *temperature, *blackbody_radiance; /* means over the materials; (7) */
    double *beta_star, *transmittance;        /* (8), (9) */
    double *thermal, *path, *skyshine, *diffuse, *specular; /* (6), (11), (19), (34), (35) */
    double *radiance;                         /* their sum, (1) */
} SkyTerms;

int32_t skyshine_pixel_terms(const SkyTables *tables, size_t count, size_t materials, size_t lines, const SkyPixels *pixels,
                        const SkyTerms *terms, void *scratch, SkyFailure *failure);

/* Temperatures of black bodies of radiances, linear in the table of (7). */
int32_t skyshine_apparent_temperatures(const SkyTables *tables, size_t count, const double *radiance, double *temperature,
                                       SkyFailure *failure);

/* Pixel value of a radiance, (44), rounded to the nearest integer: of `bits` bits, gain, buffer gain and offset. */
int64_t skyshine_value_of_pixel(double radiance, int32_t bits, double gain, double buffer_gain, double offset);

#endif
