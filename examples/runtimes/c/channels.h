/* The quantities of an atmosphere, computed from its channels, whose tables have no axis of range. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include "database.h"

/* Names of quantities beside beta_star, path_radiance_ratio, ambient_radiance and direct_radiance. */
#define LIGHT "ambient_radiance_harmonics"
#define GLOW "ground_radiance_harmonics"

/* A quantity in the band at a place: range, altitude and elevation of a line of sight, elevation of the source (of GLOW the
 * temperature of the ground), and the scattering angle, or the code of a harmonic. Below the lowest elevation of the source,
 * its light fades into what the air emits. */
double sky_quantity_at(const struct database *air, const char *name, const double *where);

/* Elevation of the source, degree, where a line of sight enters the air, or at its observer in the air; `where` ends in the
 * elevation of the source at the observer and its azimuth from the line. */
double sky_source_at_entry(const struct database *air, const double *where);

/* Light on surfaces at such a place, one value for each wavelength of the band. */
void sky_light_by_wavelength(const struct database *air, const char *name, const double *where, double *to);

/* Extinction per km of emitted light at each wavelength, a mean over the range of the place: (8) and (9). */
void sky_extinction_by_wavelength(const struct database *air, const double *where, double *to);

#endif
