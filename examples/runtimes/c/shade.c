/* The formulas of schemas/formats/htt-1.md. */
#include "shade.h"
#include "film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 288, CORRECTIONS = 8, MOST = 512 };
static const double LOWEST_AUREOLE = 10.0; /* degree: light around a lower Sun comes from there */
static const double DAY = 24.0, STEFAN_BOLTZMANN = 5.670374419e-8, MELTING_RANGE = 0.01, STEP = 24.0 / STEPS;
const double SKY_WALL_EMISSIVITY = 0.95; /* of masonry, concrete and foliage in the thermal infrared */

/* Sums of step means, for integrals to any hour. */
struct sums {
    const double *values;
    double *totals;
    size_t steps;
};

static void add_up(struct sums *sums, const double *values)
{
    sums->values = values;
    sums->totals[0] = 0;
    for (size_t k = 0; k < sums->steps; ++k) sums->totals[k + 1] = sums->totals[k] + values[k];
}

/* Integral from the beginning of the first step to an hour of any day. */
static double integral(const struct sums *sums, double hour)
{
    const double steps = (double)sums->steps;
    double place = hour * steps / DAY + 0.5;
    const double day = floor(place / steps);
    place -= day * steps;
    const double before = fmin(fmax(floor(place), 0.0), steps - 1);
    const size_t at = (size_t)before;
    return (sums->totals[at] + (place - before) * sums->values[at] + day * sums->totals[sums->steps]) * DAY / steps;
}

/* Means over the steps of the day of values that are means over other equal steps. */
static void step_means(const double *values, size_t count, double *means)
{
    struct sums sums = {values, sky_allocate(count + 1, sizeof(double)), count};
    add_up(&sums, values);
    for (size_t k = 0; k < STEPS; ++k) {
        const double hour = (double)k * STEP;
        means[k] = count == STEPS ? values[k] : (integral(&sums, hour + STEP / 2) - integral(&sums, hour - STEP / 2)) / STEP;
    }
    sky_release(sums.totals);
}

/* Cell of an axis in which a point lies, or that next to it. */
static size_t cell(const struct axis *axis, double at)
{
    size_t lower = 0;
    while (lower + 2 < axis->count && axis->nodes[lower + 1] <= at) ++lower;
    return lower;
}

/* Value at a point, linear between nodes and beyond their ends. */
static double read_at(const struct axis *axis, const double *values, double at)
{
    const size_t lower = cell(axis, at);
    return values[lower] + (at - axis->nodes[lower]) * (values[lower + 1] - values[lower]) / (axis->nodes[lower + 1] - axis->nodes[lower]);
}

/* Slope of what `read_at` reads. */
static double rise(const struct axis *axis, const double *values, double at)
{
    const size_t lower = cell(axis, at);
    return (values[lower + 1] - values[lower]) / (axis->nodes[lower + 1] - axis->nodes[lower]);
}

/* Point at which ascending values are a wanted one. */
static double inverse(const struct axis *axis, const double *values, double wanted)
{
    size_t count = 0;
    for (size_t i = 0; i < axis->count; ++i) count += values[i] <= wanted;
    size_t lower = count ? count - 1 : 0;
    if (lower + 2 > axis->count) lower = axis->count - 2;
    const double rise = values[lower + 1] - values[lower];
    return axis->nodes[lower] + (rise > 0 ? (wanted - values[lower]) / rise : 0.0) * (axis->nodes[lower + 1] - axis->nodes[lower]);
}

static double within(const struct axis *axis, double value)
{
    return fmin(fmax(value, axis->nodes[0]), axis->nodes[axis->count - 1]);
}

/* Whether the temperatures hold an hour. */
static int is_held(const struct axis *time, double hour)
{
    const double since = hour - time->nodes[0];
    return !strcmp(time->rule, "linear_periodic") || since - DAY * floor(since / DAY) <= time->nodes[time->count - 1] - time->nodes[0];
}

/* What the response of a face is at one step of the day; with a film its heat loss above that of the dry face, the water that it loses, and the
   heat loss under the share of it that covers the face. */
struct response {
    double slope, start, base, *loss, *kernel, *film_loss, *evaporation, *whole;
};

/* The kernel applied to a history of heat. */
static void linear(const struct response *steps, const struct axis *lags, const double *heat, double *moved)
{
    double totals[STEPS + 1];
    struct sums sums = {heat, totals, STEPS};
    add_up(&sums, heat);
    for (size_t k = 0; k < STEPS; ++k) {
        moved[k] = 0;
        for (size_t l = 0; l < lags->count; ++l) {
            const double near = lags->nodes[l], far = l + 1 < lags->count ? lags->nodes[l + 1] : lags->nodes[0] + DAY;
            const double hour = (double)k * STEP;
            moved[k] += steps[k].kernel[l] * (integral(&sums, hour - near) - integral(&sums, hour - far)) / (far - near);
        }
    }
}

/* Read the film on a face; 0 where no water stays. */
static int read_film(const struct database *surface, const double *face, const struct axis *axes, const struct axis *offsets, struct response *steps,
                     struct film *film)
{
    if (!sky_holds(surface, "film_heat_loss") || !(sky_value_at(surface, "film_capacity", face) > 0)) return 0;
    const double upward = fmax(cos(face[SLOPE] * acos(-1.0) / 180.0), 0);
    double place[] = {face[MATERIAL], within(&axes[1], face[ALTITUDE]), within(&axes[2], face[SLOPE]), 0, 0};
    double *tables = sky_allocate(STEPS * 3 * offsets->count, sizeof *tables);
    film->capacity = sky_value_at(surface, "film_capacity", face);
    film->before = sky_holds(surface, "film_before") ? sky_value_at(surface, "film_before", place) : NAN;
    for (size_t k = 0; k < STEPS; ++k) {
        struct response *step = &steps[k];
        step->film_loss = &tables[3 * k * offsets->count];
        step->evaporation = step->film_loss + offsets->count;
        step->whole = step->evaporation + offsets->count;
        place[3] = (double)k * STEP;
        film->rain[k] = upward * sky_value_at(surface, "rain", &place[3]);
        film->sunlight[k] = sky_value_at(surface, "film_sunlight", place);
        film->dry_sunlight[k] = sky_value_at(surface, "absorbed_sunlight", place);
        for (size_t i = 0; i < offsets->count; ++i) {
            place[4] = offsets->nodes[i];
            step->film_loss[i] = sky_value_at(surface, "film_heat_loss", place);
            step->evaporation[i] = sky_value_at(surface, "film_evaporation", place);
        }
    }
    return 1;
}

static void evaporation_of(const struct response *steps, const struct axis *offsets, const double *moved, double *evaporation)
{
    for (size_t k = 0; k < STEPS; ++k) evaporation[k] = read_at(offsets, steps[k].evaporation, steps[k].start + moved[k]);
}

/* `change` of a face with a film. */
static void wet_change(const struct film *film, struct response *steps, const struct axis *offsets, const struct axis *lags, const double *absorbed, double *moved)
{
    struct wet_day open, day;
    double evaporation[STEPS], heat[STEPS], rest[STEPS], target[STEPS];
    for (size_t k = 0; k < STEPS; ++k) moved[k] = 0;
    evaporation_of(steps, offsets, moved, evaporation);
    sky_open_film(film, evaporation, &open);
    for (size_t k = 0; k < STEPS; ++k) steps[k].base += open.covered[k] * (read_at(offsets, steps[k].film_loss, steps[k].start) - film->sunlight[k]);
    day = open;
    for (int pass = 0; pass <= CORRECTIONS; ++pass) {
        double lowest = 0, highest = 0;
        for (size_t k = 0; k < STEPS; ++k) {
            struct response *step = &steps[k];
            for (size_t i = 0; i < offsets->count; ++i) step->whole[i] = step->loss[i] + day.covered[k] * step->film_loss[i];
            heat[k] = absorbed[k] + day.covered[k] * sky_film_light(film, k, absorbed[k]);
            const double surplus = heat[k] - (read_at(offsets, step->whole, step->start) - step->base);
            const double balanced = inverse(offsets, step->whole, step->base + heat[k]) - step->start;
            if (surplus < 0) lowest = fmin(lowest, balanced);
            if (surplus > 0) highest = fmax(highest, balanced);
            rest[k] = heat[k] - (read_at(offsets, step->whole, step->start + moved[k]) - step->base - step->slope * moved[k]);
        }
        linear(steps, lags, pass ? rest : absorbed, target);
        for (size_t k = 0; k < STEPS; ++k) {
            const double steeper = pass ? fmax(rise(offsets, steps[k].whole, steps[k].start + moved[k]) / steps[k].slope, 1) : 1;
            moved[k] = fmin(fmax(moved[k] + (target[k] - moved[k]) / steeper, lowest), highest);
        }
        day.start = pass && isnan(film->before) ? fmin(fmax(open.start + (day.end - open.end), 0), 1) : open.start;
        evaporation_of(steps, offsets, moved, evaporation);
        sky_march_film(film, evaporation, &day);
    }
}

/* Change of temperature at each step of the day by a change of absorbed heat at each step, less what ends melting. */
static void change(const struct database *surface, const double *face, double *absorbed, double *moved)
{
    const struct axis *axes = sky_array_of(surface, "response_kernel")->axes, *lags = &axes[4];
    const struct axis *offsets = &sky_array_of(surface, "heat_loss_excess")->axes[4], *time = &sky_array_of(surface, "temperature")->axes[TIME];
    if (lags->count > MOST || offsets->count > MOST || offsets->count < 2) sky_fail("the response has too many nodes, or too few");
    struct response *steps = sky_allocate(STEPS, sizeof *steps);
    double *loss = sky_allocate(STEPS * MOST, sizeof *loss), *kernel = sky_allocate(STEPS * MOST, sizeof *kernel);
    const double limit = sky_value_at(surface, "highest_temperature", face);
    double lowest = 0, highest = 0, heat[STEPS], target[STEPS], beyond[STEPS];
    for (size_t k = 0; k < STEPS; ++k) {
        const double hour = (double)k * STEP;
        double place[] = {face[MATERIAL], within(&axes[1], face[ALTITUDE]), within(&axes[2], face[SLOPE]), hour, 0};
        const double now[] = {face[MATERIAL], face[ALTITUDE], face[AZIMUTH], face[SLOPE], hour};
        struct response *step = &steps[k];
        step->loss = &loss[k * MOST];
        step->kernel = &kernel[k * MOST];
        step->slope = sky_value_at(surface, "heat_loss_slope", place);
        step->start = 0.0;
        if (is_held(time, hour)) {
            const double sunlit = sky_value_at(surface, "temperature", now);
            step->start = sunlit - sky_value_at(surface, "response_temperature", place);
            if (sunlit >= limit - MELTING_RANGE) absorbed[k] = fmin(absorbed[k] + sky_value_at(surface, "melting_heat", place), 0.0);
        }
        for (size_t i = 0; i < offsets->count; ++i) {
            place[4] = offsets->nodes[i];
            step->loss[i] = step->slope * offsets->nodes[i] + sky_value_at(surface, "heat_loss_excess", place);
        }
        for (size_t i = 0; i < lags->count; ++i) {
            place[4] = lags->nodes[i];
            step->kernel[i] = sky_value_at(surface, "response_kernel", place);
        }
        step->base = read_at(offsets, step->loss, step->start);
        const double balanced = inverse(offsets, step->loss, step->base + absorbed[k]) - step->start;
        if (absorbed[k] < 0) lowest = fmin(lowest, balanced);
        if (absorbed[k] > 0) highest = fmax(highest, balanced);
    }
    struct film film;
    if (read_film(surface, face, axes, offsets, steps, &film)) {
        wet_change(&film, steps, offsets, lags, absorbed, moved);
        return;
    }
    linear(steps, lags, absorbed, moved);
    for (size_t k = 0; k < STEPS; ++k) moved[k] = fmin(fmax(moved[k], lowest), highest);
    for (int pass = 0; pass < CORRECTIONS; ++pass) {
        for (size_t k = 0; k < STEPS; ++k) {
            beyond[k] = read_at(offsets, steps[k].loss, steps[k].start + moved[k]) - steps[k].base - steps[k].slope * moved[k];
            heat[k] = absorbed[k] - beyond[k];
        }
        linear(steps, lags, heat, target);
        for (size_t k = 0; k < STEPS; ++k) {
            const double steeper = moved[k] != 0 ? beyond[k] / (steps[k].slope * moved[k]) : 0.0;
            moved[k] = fmin(fmax(moved[k] + (target[k] - moved[k]) / (1 + fmax(steeper, 0.0)), lowest), highest);
        }
    }
}

static void need_response(const struct database *surface)
{
    if (!sky_holds(surface, "response_kernel")) sky_fail("the surface file holds no response to shade");
}

/* Altitude at which the air over a surface is read. */
static double air_altitude(const struct database *surface, double altitude)
{
    return within(&sky_array_of(surface, "air_temperature")->axes[0], altitude);
}

double sky_air_temperature(const struct database *surface, double altitude, double time)
{
    need_response(surface);
    return sky_value_at(surface, "air_temperature", (double[]){air_altitude(surface, altitude), time});
}

double sky_temperature_under(const struct database *surface, const double *face, const double *absorbed, size_t count)
{
    need_response(surface);
    for (size_t k = 0; k < count; ++k)
        if (!isfinite(absorbed[k])) sky_fail("absorbed_change must be a list of finite numbers");
    double heat[STEPS], moved[STEPS];
    if (!count) sky_fail("absorbed_change must be a list of finite numbers");
    step_means(absorbed, count, heat);
    change(surface, face, heat, moved);
    const double place = (face[TIME] - DAY * floor(face[TIME] / DAY)) / STEP, weight = place - floor(place);
    const size_t before = (size_t)place % STEPS;
    const double sunlit = sky_value_at(surface, "temperature", face), limit = sky_value_at(surface, "highest_temperature", face);
    return fmin(sunlit + moved[before] * (1 - weight) + moved[(before + 1) % STEPS] * weight, fmax(limit, sunlit));
}

/* Share of a step of the day in the shade, of intervals that do not overlap. */
static double shaded_share(const skyshine_surroundings *around, double hour)
{
    const double first = hour - STEP / 2, last = hour + STEP / 2;
    double covered = 0;
    for (size_t i = 0; i < around->shade_count; ++i) {
        const double begin = around->shade[i][0], given = around->shade[i][1], end = given < begin ? given + DAY : given;
        for (int turn = -1; turn <= 1; ++turn) covered += fmax(fmin(last, end + turn * DAY) - fmax(first, begin + turn * DAY), 0.0);
    }
    return fmin(covered / STEP, 1.0);
}

/* Heat that a face absorbs more than in the open, from the sky that surroundings leave; and the sunlight that reaches it less, below 0. */
static void of_the_sky(const struct database *surface, const double *face, const skyshine_surroundings *around, double *absorbed, double *light)
{
    const double degree = acos(-1.0) / 180.0, open = around->sky_view, facing = around->facing;
    const double emissivity = isnan(around->facing_emissivity) ? SKY_WALL_EMISSIVITY : around->facing_emissivity;
    const double absorbs = sky_value_at(surface, "solar_absorptance", face), emits = sky_value_at(surface, "thermal_emissivity", face);
    const double altitude = air_altitude(surface, face[ALTITUDE]);
    const double cosine = cos(face[SLOPE] * degree), sine = sin(face[SLOPE] * degree), view = 0.5 * (1 + cosine);
    for (size_t k = 0; k < STEPS; ++k) {
        const double hour = (double)k * STEP, place[] = {altitude, hour};
        const double up = sky_value_at(surface, "solar_elevation", &hour) * degree;
        const double turn = (sky_value_at(surface, "solar_azimuth", &hour) - face[AZIMUTH]) * degree;
        const double normal = sky_value_at(surface, "direct_normal_irradiance", place), level = sky_value_at(surface, "diffuse_irradiance", place);
        const double sky = sky_value_at(surface, "sky_irradiance", place);
        const double incidence = fmax(cosine * sin(up) + sine * cos(up) * cos(turn), 0.0);
        const double aureole = sky_value_at(surface, "aureole_share", &hour), above = fmax(up, LOWEST_AUREOLE * degree);
        const double towards = fmax(cosine * sin(above) + sine * cos(above) * cos(turn), 0.0) / sin(above);
        const double spread = (1 - aureole) * view * level, beam = normal * incidence + aureole * level * towards;
        const double air = STEFAN_BOLTZMANN * pow(sky_value_at(surface, "air_temperature", place), 4);
        const double emitted = isnan(facing) || facing < 0 ? air : STEFAN_BOLTZMANN * pow(facing, 4);
        const double wall = emissivity * emitted + (1 - emissivity) * (sky + air) / 2;
        light[k] = -(shaded_share(around, hour) * beam + (1 - open) * spread);
        absorbed[k] = emits * (1 - open) * view * (wall - sky) + absorbs * light[k];
    }
}

/* Add what comes from ground that has the same surroundings: it is colder in the shade, and reflects less light. */
static void add_ground(const struct database *surface, const double *face, const skyshine_surroundings *around, double *absorbed)
{
    const struct axis *axes = sky_array_of(surface, "temperature")->axes;
    const double below = (1 - cos(face[SLOPE] * acos(-1.0) / 180.0)) / 2;
    if (surface->ground_code == 0.0 || !(face[SLOPE] > 0)) return;
    const double absorbs = sky_value_at(surface, "solar_absorptance", face), emits = sky_value_at(surface, "thermal_emissivity", face);
    double level[] = {surface->ground_code, within(&axes[ALTITUDE], face[ALTITUDE]), axes[AZIMUTH].nodes[0], 0.0, 0.0};
    double heat[STEPS], light[STEPS], moved[STEPS];
    const double limit = sky_value_at(surface, "highest_temperature", level);
    of_the_sky(surface, level, around, heat, light);
    change(surface, level, heat, moved);
    for (size_t k = 0; k < STEPS; ++k) {
        absorbed[k] += below * absorbs * surface->ground_albedo * light[k];
        level[TIME] = (double)k * STEP;
        if (!is_held(&axes[TIME], level[TIME])) continue;
        const double sunlit = sky_value_at(surface, "temperature", level), kelvin = fmin(sunlit + moved[k], fmax(limit, sunlit));
        absorbed[k] += below * emits * surface->ground[0] * STEFAN_BOLTZMANN * (pow(kelvin, 4) - pow(sunlit, 4));
    }
}

double sky_temperature_beside(const struct database *surface, const double *face, const skyshine_surroundings *around)
{
    need_response(surface);
    const double open = around->sky_view, facing = around->facing;
    const double emissivity = isnan(around->facing_emissivity) ? SKY_WALL_EMISSIVITY : around->facing_emissivity;
    int finite = isfinite(open) && !isinf(facing) && isfinite(emissivity);
    for (size_t i = 0; i < around->shade_count; ++i) finite = finite && isfinite(around->shade[i][0]) && isfinite(around->shade[i][1]);
    if (!finite) sky_fail("surroundings must be finite numbers");
    double absorbed[STEPS], light[STEPS];
    of_the_sky(surface, face, around, absorbed, light);
    add_ground(surface, face, around, absorbed);
    return sky_temperature_under(surface, face, absorbed, STEPS);
}
