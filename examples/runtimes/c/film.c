/* The march of schemas/formats/htt-1.md. */
#include "film.h"

#include <math.h>

enum { DAYS = 30 }; /* marched through at most until a film returns */
static const double RETURNS = 1e-9; /* of the capacity, by which it may differ then */

/* The root r of r^3 + loss r^2 = water, 0 to 1, by Newton's method from above. */
static double root(double loss, double water)
{
    if (!(water > 0)) return 0;
    double side = cbrt(water);
    if (loss > 0) side = fmin(side, sqrt(water / loss));
    for (int pass = 0; pass < 60; ++pass) {
        const double change = (side * side * (side + loss) - water) / (side * (3 * side + 2 * loss));
        side -= change;
        if (fabs(change) <= 1e-16 * side) break;
    }
    return fmin(side, 1);
}

void sky_march_film(const struct film *film, const double *evaporation, struct wet_day *day)
{
    const double scale = 86400.0 / FILM_STEPS / film->capacity;
    day->end = day->start;
    for (size_t k = 0; k < FILM_STEPS; ++k) {
        const double gain = (fmax(-evaporation[k], 0) + film->rain[k]) * scale;
        const double side = root(fmax(evaporation[k], 0) * scale, day->end + gain);
        day->covered[k] = side * side;
        day->end = side * side * side;
    }
}

void sky_open_film(const struct film *film, const double *evaporation, struct wet_day *day)
{
    if (!isnan(film->before)) {
        day->start = fmin(film->before / film->capacity, 1);
        sky_march_film(film, evaporation, day);
        return;
    }
    day->end = 0;
    for (int pass = 0; pass < DAYS; ++pass) {
        day->start = day->end;
        sky_march_film(film, evaporation, day);
        if (day->end - day->start <= RETURNS) break;
    }
}

double sky_film_light(const struct film *film, size_t step, double absorbed)
{
    const double dry = film->dry_sunlight[step];
    return film->sunlight[step] * fmin(fmax(1 + (dry > 0 ? absorbed / dry : 0), 0), 1);
}
