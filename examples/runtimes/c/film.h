/* The film of water on a face through a day. */
#ifndef FILM_H
#define FILM_H

#include <stddef.h>

enum { FILM_STEPS = 288 };

/* At each step of the day: sunlight that a whole film absorbs more than the dry face and that of the dry face, W m^-2; rain, kg m^-2 s^-1. */
struct film {
    double sunlight[FILM_STEPS], dry_sunlight[FILM_STEPS], rain[FILM_STEPS];
    double capacity, before; /* kg m^-2; water at midnight before the day, NAN where the film returns after the day */
};

/* A day of a film: the share that it covers at each step, the water before the day and at its end over the capacity. */
struct wet_day {
    double covered[FILM_STEPS], start, end;
};

/* A day from `start` on, under the evaporation of a wholly wet face, kg m^-2 s^-1. */
void sky_march_film(const struct film *film, const double *evaporation, struct wet_day *day);

/* The file's own day. */
void sky_open_film(const struct film *film, const double *evaporation, struct wet_day *day);

/* Sunlight that a whole film absorbs more under a change of heat. */
double sky_film_light(const struct film *film, size_t step, double absorbed);

#endif
