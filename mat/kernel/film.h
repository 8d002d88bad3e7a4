/* The film of water on a face through a day. */
#ifndef SKYSHINE_FILM_H
#define SKYSHINE_FILM_H

#include "pixel_tables.h"

static const double FILM_RETURNS = 1e-9; /* of the capacity, by which a film that returns after a day may differ */
enum { FILM_DAYS = 30 };                 /* marched through at most until it returns */

/* At each step of the day: sunlight that a whole film absorbs more than the dry face and that of the dry face, W m^-2; rain
 * on the face, kg m^-2 s^-1. Capacity, and water at midnight before the day, kg m^-2: NaN where the film returns. */
typedef struct {
    double sunlight[SKY_STEPS], dry_sunlight[SKY_STEPS], rain[SKY_STEPS];
    double capacity, before;
} Film;

/* A day of a film: the share that it covers at each step, the water before the day and at its end over the capacity. */
typedef struct {
    double covered[SKY_STEPS], start, end;
} WetDay;

/* The root r of r^3 + loss r^2 = water, 0 to 1, by Newton's method from above. */
static inline double film_side(double loss, double water) {
    if (water <= 0) return 0;
    double side = cube_root(water);
    if (loss > 0) side = smaller(side, __builtin_sqrt(water / loss));
    for (int pass = 0; pass < 60; pass++) {
        double change = (side * side * (side + loss) - water) / (side * (3 * side + 2 * loss));
        side -= change;
        if (!(change > 1e-16 * side || -change > 1e-16 * side)) break;
    }
    return smaller(side, 1);
}

/* A day from `start` on, under the evaporation of a wholly wet face, kg m^-2 s^-1. */
static inline void march_film(const Film *film, const double *evaporation, WetDay *day) {
    double scale = 86400.0 / SKY_STEPS / film->capacity;
    day->end = day->start;
    for (size_t k = 0; k < SKY_STEPS; k++) {
        double gain = (larger(-evaporation[k], 0) + film->rain[k]) * scale;
        double side = film_side(larger(evaporation[k], 0) * scale, day->end + gain);
        day->covered[k] = side * side;
        day->end = side * side * side;
    }
}

/* The file's own day. */
static inline void open_film(const Film *film, const double *evaporation, WetDay *day) {
    if (is_finite(film->before)) {
        day->start = smaller(film->before / film->capacity, 1);
        march_film(film, evaporation, day);
        return;
    }
    day->end = 0;
    for (int pass = 0; pass < FILM_DAYS; pass++) {
        day->start = day->end;
        march_film(film, evaporation, day);
        if (day->end - day->start <= FILM_RETURNS) break;
    }
}

/* Sunlight that a whole film absorbs more under a change of heat. */
static inline double film_light(const Film *film, size_t step, double absorbed) {
    double dry = film->dry_sunlight[step];
    return film->sunlight[step] * clipped(1 + (dry > 0 ? absorbed / dry : 0), 0, 1);
}

#endif
