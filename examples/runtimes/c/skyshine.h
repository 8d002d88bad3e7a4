/* Reading of the databases that `mat build` and `tmm classify` write, for a scene runtime.
 *
 * Files are read and checked whole when they are opened; after that a handle is constant, and any number of threads may
 * read it. Only `skyshine_open`, `skyshine_open_files`, `skyshine_texture_open` and the first request of each level by
 * `skyshine_texture_mixture` use the HDF5 library, which most systems build for one thread at a time.
 *
 * A call returns SKYSHINE_OK, or a status whose reason stands in `error` (which may be NULL) as one line of text: what was
 * found, and what is allowed. Results are written only where it returns SKYSHINE_OK. The library writes to no stream, ends
 * no process and keeps no state between calls. Radiances are in W m^-2 sr^-1, lengths in km, angles in degree, times in
 * hours of the local clock, temperatures in K. Elevations of lines of sight are apparent, those of Sun and Moon geometric;
 * headings are azimuths from north eastward. Equation numbers are those of DSTO-TN-0193. */
#ifndef SKYSHINE_H
#define SKYSHINE_H

#include <stddef.h>
#include <stdint.h>

#if defined _WIN32 && defined SKYSHINE_SHARED
#ifdef SKYSHINE_BUILDING
#define SKYSHINE_API __declspec(dllexport)
#else
#define SKYSHINE_API __declspec(dllimport)
#endif
#elif defined __GNUC__
#define SKYSHINE_API __attribute__((visibility("default")))
#else
#define SKYSHINE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define SKYSHINE_VERSION "0.1.0"
/* Version of the formats that this version knows; it reads all minor versions of its major one. */
#define SKYSHINE_FORMAT "1.0"

enum { SKYSHINE_MESSAGE = 300, SKYSHINE_COMPONENTS = 3 };
/* Open share of the sky above what a texture shows in the shade, where a scene says nothing else. */
#define SKYSHINE_SHADED_SKY 0.5

typedef enum {
    SKYSHINE_OK = 0,
    SKYSHINE_FILE_ERROR,  /* a file is missing, damaged, of another format, or does not fit the others */
    SKYSHINE_VALUE_ERROR, /* a value that the tables do not hold */
    SKYSHINE_NO_MEMORY
} skyshine_status;

typedef struct {
    skyshine_status status;
    char message[SKYSHINE_MESSAGE];
} skyshine_error;

typedef enum { SKYSHINE_SUN, SKYSHINE_MOON } skyshine_source;

/* The tables of a state, a band and a source. */
typedef struct skyshine_tables skyshine_tables;
typedef struct skyshine_texture skyshine_texture;
typedef struct skyshine_frame skyshine_frame;

/* A face of a material. */
typedef struct {
    int32_t material; /* code */
    double altitude, azimuth, slope, time;
} skyshine_face;

/* A line of sight, and the source: its azimuth relative to the line. */
typedef struct {
    double range, altitude, elevation, source_elevation, source_azimuth;
} skyshine_line;

/* What keeps sunlight and sky from a face. */
typedef struct {
    const double (*shade)[2]; /* hours from first to last, over midnight where the first is later; they do not overlap */
    size_t shade_count;
    double sky_view;          /* open share of the sky */
    double facing;            /* temperature of the wall that hides the rest; NaN: that of the air */
    double facing_emissivity; /* NaN: 0.95 */
} skyshine_surroundings;

/* A pixel; the atmosphere is read at the range and elevation of the centre. */
typedef struct {
    size_t materials; /* 1 to SKYSHINE_COMPONENTS */
    int32_t material[SKYSHINE_COMPONENTS];
    double share[SKYSHINE_COMPONENTS];
    double temperature[SKYSHINE_COMPONENTS]; /* NaN: that of the tables */
    double surface_altitude, surface_azimuth, surface_slope, time;
    double range, centre_range, centre_elevation, altitude;
    double source_elevation, source_azimuth;
    double source_heading;   /* NaN: the sky of a level face */
    int32_t ground_material; /* 0: the ground that the atmosphere file names, at `time`, or states */
    double normal[3], to_source[3], to_observer[3]; /* of any length, in any frame */
    double hidden_sky; /* share of the sky above it that something as warm as the air hides; 0: none */
    double shade;      /* share of it in the shade all day, of `skyshine_texture_shade`; 0: none, and the next two are not read */
    double shaded_sky; /* open share of the sky above that share, which is never more than that above the pixel */
    double shaded_temperature[SKYSHINE_COMPONENTS]; /* NaN: by the response of the surface file */
} skyshine_pixel;

/* The terms of a pixel; `specular` has the lobe of (37) and (38). */
typedef struct {
    double temperature, blackbody_radiance, beta_star, transmittance; /* (7), (9) */
    double thermal, path, skyshine, diffuse, specular, radiance;     /* (6), (11), (19), (34), (35), (1) */
} skyshine_terms;

/* What all pixels of a frame share. */
typedef struct {
    double altitude;                                       /* of the observer */
    double centre_range, centre_elevation, centre_heading; /* the line of sight at which the atmosphere is read */
    double source_elevation, source_heading, time;
    int32_t ground_material;                               /* 0: the ground that the atmosphere file names, at `time`, or states */
    double ground_altitude;                                /* of `ground_material` */
} skyshine_view;

/* Pixels of a frame: lists with one value for each. */
typedef struct {
    const int32_t *material;
    const double *range;
    const double *elevation, *heading;     /* of the line of sight, for the lobe; both NULL: those of the centre */
    const double *surface_altitude, *surface_azimuth, *surface_slope;
    const double *temperature;             /* NULL: those of the tables; then `surface_altitude` may be NULL */
} skyshine_pixels;

/* ---- The ten calls. ---- */

/* Open a state, a band (numbers from 1, as in the names of the files) and a source in the folder of a build, by its
 * `catalog.json`. `clamp` lists axes on which values outside are read at the nearest node, with NULL behind the last one;
 * NULL: none. */
SKYSHINE_API skyshine_status skyshine_open(const char *folder, int state, int band, skyshine_source source, const char *const *clamp,
                                           skyshine_tables **tables, skyshine_error *error);

/* Codes, ascending, and names of the materials of the band; they live as long as the tables. Returns how many. */
SKYSHINE_API size_t skyshine_materials(const skyshine_tables *tables, const int32_t **codes, const char *const **names);

/* Temperature of a face in full sun under the whole sky. */
SKYSHINE_API skyshine_status skyshine_temperature(const skyshine_tables *tables, const skyshine_face *face, double *temperature, skyshine_error *error);

/* Temperature of a face with surroundings. */
SKYSHINE_API skyshine_status skyshine_shaded_temperature(const skyshine_tables *tables, const skyshine_face *face,
                                                         const skyshine_surroundings *surroundings, double *temperature, skyshine_error *error);

/* Transmittance of the band along a line, (9). Its source is not read. */
SKYSHINE_API skyshine_status skyshine_transmittance(const skyshine_tables *tables, const skyshine_line *line, double *transmittance, skyshine_error *error);

/* What the air along a line emits and scatters to its beginning, (11). */
SKYSHINE_API skyshine_status skyshine_path_radiance(const skyshine_tables *tables, const skyshine_line *line, double *radiance, skyshine_error *error);

/* Light of the sky on a face at the end of a line, over pi; `azimuth` of the face is relative to that of the source. A
 * tilted face needs a file with harmonics; its ground is that which the file states. */
SKYSHINE_API skyshine_status skyshine_ambient_radiance(const skyshine_tables *tables, const skyshine_line *line, double slope, double azimuth,
                                                       double *radiance, skyshine_error *error);

/* Light of the source on a surface normal to it at the end of a line, over pi. */
SKYSHINE_API skyshine_status skyshine_direct_radiance(const skyshine_tables *tables, const skyshine_line *line, double *radiance, skyshine_error *error);

/* The terms of a pixel, (1). */
SKYSHINE_API skyshine_status skyshine_pixel_radiance(const skyshine_tables *tables, const skyshine_pixel *pixel, skyshine_terms *terms, skyshine_error *error);

/* Temperature of the black body that has a radiance in the band, within the band's temperatures. */
SKYSHINE_API skyshine_status skyshine_apparent_temperature(const skyshine_tables *tables, double radiance, double *temperature, skyshine_error *error);

/* ---- A frame: many pixels of one observer, one source and one time. ---- */

/* Take what the pixels of a frame share, and refuse a centre, a source or a ground that the tables do not hold. The frame
 * reads `tables`, which must outlive it. */
SKYSHINE_API skyshine_status skyshine_frame_open(const skyshine_tables *tables, const skyshine_view *view, skyshine_frame **frame, skyshine_error *error);

/* Radiances of `count` pixels, in one thread. */
SKYSHINE_API skyshine_status skyshine_frame_radiance(const skyshine_frame *frame, const skyshine_pixels *pixels, size_t count, double *radiance,
                                                     skyshine_error *error);
SKYSHINE_API void skyshine_frame_close(skyshine_frame *frame);

/* ---- Beside them. ---- */

/* `skyshine_open` of named files: an .htt, a .band and an .atmq or .lunar_atmq file. */
SKYSHINE_API skyshine_status skyshine_open_files(const char *surface, const char *band, const char *atmosphere, const char *const *clamp,
                                                 skyshine_tables **tables, skyshine_error *error);
SKYSHINE_API void skyshine_close(skyshine_tables *tables);

/* Temperature of a face that absorbs other heat than that of the tables: `count` means over equal steps of the day, each
 * centred on its time, the first on midnight, in W m^-2. */
SKYSHINE_API skyshine_status skyshine_heated_temperature(const skyshine_tables *tables, const skyshine_face *face, const double *absorbed, size_t count,
                                                         double *temperature, skyshine_error *error);

/* Elevation and heading of the tables' source at a time, 0 to 36 h, from the tracks of the surface file. */
SKYSHINE_API skyshine_status skyshine_source_position(const skyshine_tables *tables, double time, double *elevation, double *heading, skyshine_error *error);

/* Open a .tmm file and read its level 0. */
SKYSHINE_API skyshine_status skyshine_texture_open(const char *path, skyshine_texture **texture, skyshine_error *error);

/* Codes and shares of the materials at a point, in texels of level 0 from the top left corner of the image. Its level is
 * read with the first request, which no other thread may share. */
SKYSHINE_API skyshine_status skyshine_texture_mixture(skyshine_texture *texture, double across, double down, unsigned level, size_t *count,
                                                      int32_t codes[SKYSHINE_COMPONENTS], double shares[SKYSHINE_COMPONENTS], skyshine_error *error);

/* Share of the texel at that point in the shade of its photograph; 0 where the file has no such layer. Its level is read as
 * for `skyshine_texture_mixture`. */
SKYSHINE_API skyshine_status skyshine_texture_shade(skyshine_texture *texture, double across, double down, unsigned level, double *shade, skyshine_error *error);
SKYSHINE_API void skyshine_texture_close(skyshine_texture *texture);

/* Pixel value of a radiance, (44), rounded to the nearest integer: of `bits` bits, a gain [W m^-2 sr^-1], buffer gain and
 * offset. */
SKYSHINE_API long skyshine_pixel_value(double radiance, int bits, double gain, double buffer_gain, double offset);

#ifdef __cplusplus
}
#endif

#endif
