/* Temperatures in the shade, beside a wall or under other heat. */
#ifndef SHADE_H
#define SHADE_H

#include "database.h"

/* A face: values of the axes of `temperature`, in their order. */
enum { MATERIAL, ALTITUDE, AZIMUTH, SLOPE, TIME };

/* Temperature of a face that absorbs other heat than the table's: `count` means over equal steps of the day, W m^-2. */
double sky_temperature_under(const struct database *surface, const double *face, const double *absorbed, size_t count);

/* The same for a face with surroundings: see `skyshine_surroundings`. */
double sky_temperature_beside(const struct database *surface, const double *face, const skyshine_surroundings *around);

/* Temperature of the air over surfaces at an altitude and a time. */
double sky_air_temperature(const struct database *surface, double altitude, double time);

extern const double SKY_WALL_EMISSIVITY;

#endif
