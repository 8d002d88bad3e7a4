/* The formulas are those of ../../../schemas/formats/atmq-4.md; lengths are in km. */
#include "channels.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double SHORTEST = 1e-12, FARTHEST_BETA = 1e12, EARTH_RADIUS = 6371.0088, RADIAN = 0.017453292519943295;
static const double CIVIL_TWILIGHT = -6.0; /* degree: a table whose lowest source elevation is above says nothing of twilight */
enum { RANGE, ALTITUDE, ELEVATION, SOURCE, LAST };

/* A path: its place in the tables, the length that mean extinction is multiplied by, and the height of its end; of a line
 * from space, the angle at the centre of the Earth between the observer and the point where it enters the air. */
struct line {
    double share, height_root, direction, length, end_height, turn;
    int grounded;
};

/* The optical depth and mean extinction of the channels along a path. */
struct path {
    struct line line;
    size_t channels;
    double *depth, *extinction;
};

static double limited(double value)
{
    return fmin(fmax(value, 0.0), 1.0);
}

/* Range, altitude or elevation, which must be one that the file is for; no range is negative, clamped or not. */
static double within(const struct database *database, int which, double value)
{
    static const char *const names[] = {"range", "altitude", "elevation"};
    const double *ends = database->channels.ends[which];
    const int negative = which == RANGE && value < 0, beyond = !(value >= ends[0] && value <= ends[1]);
    if (!isfinite(value) || negative || (beyond && !database->channels.clamps[which]))
        sky_fail("%s: found %g; allowed: %g to %g", names[which], value, ends[0], ends[1]);
    return fmin(fmax(value, ends[0]), ends[1]);
}

/* A line that meets the ground; `rise` and `fall` are a and c of the page. */
static void into_ground(struct line *line, double reach, double height, double rho, double rise, double fall)
{
    const double distance = fall / (sqrt(rise * rise - fall) - rise), across = 2 * rho * height;
    line->share = distance > 0 ? fmin(reach / distance, 1.0) : 1.0;
    line->direction = across > 0 ? limited((distance * distance - height * height) / across) : 0.0;
    line->length = reach;
    line->grounded = reach >= distance;
}

static void into_space(struct line *line, double reach, double height, double radius, double angle, double scale)
{
    const double rise = radius * sin(angle), above = scale * (2 * radius + scale), level = sqrt(above);
    const double way = above / (rise + sqrt(rise * rise + above)), half = sin(angle / 2);
    line->share = -expm1(-reach / way);
    line->direction = angle < 0 ? 3 - sqrt(limited(2 * radius * half * half / height)) : 3 + limited((level - way) / (level - scale));
    line->length = way * line->share;
}

/* Height of the end of a straight line over an Earth of a radius. */
static double height_at(double reach, double earth, double height, double angle)
{
    const double radius = earth + height, step = reach * reach + 2 * radius * sin(angle) * reach;
    return (step + height * (2 * earth + height)) / (earth + sqrt(fmax(radius * radius + step, 0.0)));
}

/* Height of the end of a line that has its place in the tables. */
static double end_height(const struct database *database, const struct line *line, double reach, double rho, double height, double angle)
{
    if (line->grounded) return 0.0;
    if (!sky_holds(database, "end_rise")) return fmax(height_at(reach, rho, height, angle), 0.0);
    const double straight = height_at(reach, EARTH_RADIUS + database->channels.ground_km, height, angle);
    return fmax(straight + reach * sky_value_at(database, "end_rise", (double[]){line->share, line->height_root, line->direction}), 0.0);
}

/* The rest of a line from an observer above the air: it begins where it enters the air, with the elevation there, and has
 * no length where it does not. Returns the altitude of its end where that is in space, NaN otherwise. */
static double enter(double *reach, double *altitude, double *angle, double *turn)
{
    const double radius = EARTH_RADIUS + *altitude, top = EARTH_RADIUS + SKY_TOP_KM, rise = radius * sin(*angle);
    const double inside = rise * rise - (radius * radius - top * top), whole = *reach;
    const int enters = *angle < 0 && inside >= 0;
    const double way = enters ? -rise - sqrt(inside) : HUGE_VAL;
    const double there = enters ? asin(fmin(fmax((rise + way) / top, -1.0), 1.0)) : acos(0.0);
    *turn = enters ? there - *angle : 0.0;
    *reach = fmax(whole - way, 0.0);
    *altitude = SKY_TOP_KM;
    *angle = there;
    return whole > way ? NAN : sqrt(fmax(radius * radius + 2 * rise * whole + whole * whole, 0.0)) - EARTH_RADIUS;
}

static struct line line_of(const struct database *database, const double *where)
{
    double reach = within(database, RANGE, where[RANGE]), altitude = within(database, ALTITUDE, where[ALTITUDE]);
    double angle = RADIAN * within(database, ELEVATION, where[ELEVATION]), turn = 0.0;
    const double end_in_space = altitude > SKY_TOP_KM ? enter(&reach, &altitude, &angle, &turn) : NAN;
    const double height = fmax(altitude - database->channels.ground_km, 0.0);
    struct line line = {.height_root = cbrt(height), .turn = turn};
    const double rho = sky_value_at(database, "effective_radius", &line.height_root);
    const double radius = rho + height, rise = radius * sin(angle), fall = height * (2 * rho + height);
    if (angle < 0 && rise * rise >= fall) into_ground(&line, reach, height, rho, rise, fall);
    else into_space(&line, reach, height, radius, angle, database->channels.scale_km);
    line.end_height = isnan(end_in_space) ? end_height(database, &line, reach, rho, height, angle) : end_in_space - database->channels.ground_km;
    return line;
}

static struct path path_of(const struct database *database, const double *where)
{
    const struct array *factor = sky_array_of(database, "absorber_factor");
    const struct axis *absorbers = &sky_array_of(database, "log_mean_extinction")->axes[0];
    const size_t count = factor->axes[1].count;
    struct path path = {.line = line_of(database, where), .channels = factor->axes[0].count};
    double *mean = sky_allocate(count, sizeof *mean);
    path.depth = sky_allocate(path.channels, sizeof *path.depth);
    path.extinction = sky_allocate(path.channels, sizeof *path.extinction);
    for (size_t i = 0; i < count; ++i)
        mean[i] = exp(sky_value_at(database, "log_mean_extinction",
                                   (double[]){absorbers->nodes[i], path.line.share, path.line.height_root, path.line.direction}));
    for (size_t j = 0; j < path.channels; ++j) {
        for (size_t i = 0; i < count; ++i) path.extinction[j] += factor->values[j * count + i] * mean[i];
        path.extinction[j] = fmax(path.extinction[j], 0.0);
        path.depth[j] = path.extinction[j] * fmax(path.line.length, SHORTEST);
    }
    sky_release(mean);
    return path;
}

/* Sum over the channels of a spectrum times 1 - exp(-optical depth). */
static double absorbed(const struct database *database, const char *spectrum, const struct path *path)
{
    const float *values = sky_array_of(database, spectrum)->values;
    double sum = 0.0;
    for (size_t j = 0; j < path->channels; ++j) sum += values[j] * -expm1(-path->depth[j]);
    return sum;
}

static double least_depth(const struct path *path)
{
    double least = path->depth[0];
    for (size_t j = 1; j < path->channels; ++j) least = fmin(least, path->depth[j]);
    return least;
}

static double beta_star(const struct database *database, const struct path *path, double reach)
{
    const float *weight = sky_array_of(database, "channel_weight")->values;
    const double absorptance = absorbed(database, "channel_weight", path), least = least_depth(path);
    double local = 0.0, through = 0.0;
    for (size_t j = 0; j < path->channels; ++j) {
        local += weight[j] * path->extinction[j];
        through += weight[j] * exp(least - path->depth[j]);
    }
    const double depth = absorptance < 0.5 ? -log1p(-absorptance) : least - log(through);
    const double over = reach > 0 ? depth / reach : local;
    return over > 0 ? fmin(5.5 / over, FARTHEST_BETA) : FARTHEST_BETA;
}

static const struct axis *source_elevations(const struct database *database)
{
    return &sky_array_of(database, "source_factor")->axes[1];
}

/* The elevation of the source, or the first node where it is below; one that the file is for. */
static double lit(const struct database *database, double height)
{
    const struct axis *axis = source_elevations(database);
    const double lowest = axis->nodes[0], highest = axis->nodes[axis->count - 1];
    if (!isfinite(height) || (height > highest && !axis->clamps)) sky_fail("%s: found %g; allowed: %g to %g", axis->name, height, lowest, highest);
    return fmax(height, lowest);
}

/* Share of the light of the first node that the source gives below it; 1 above. */
static double night(const struct database *database, double height)
{
    const struct axis *axis = source_elevations(database);
    const double lowest = axis->nodes[0], dark = axis->dark_below;
    if (!(height < lowest)) return 1.0;
    if (height <= dark) return 0.0;
    if (lowest > CIVIL_TWILIGHT && !axis->clamps) sky_fail("%s: found %g; allowed: %g to %g", axis->name, height, lowest, axis->nodes[axis->count - 1]);
    return lowest > CIVIL_TWILIGHT ? 1.0 : (height - dark) / (lowest - dark);
}

static double path_radiance_ratio(const struct database *database, const struct path *path, double source, double angle)
{
    const struct axis *parts = &sky_array_of(database, "scattered_ratio")->axes[0];
    const struct line *line = &path->line;
    const double absorptance = absorbed(database, "channel_weight", path);
    double scattered = 0.0;
    for (size_t k = 0; k < parts->count; ++k)
        scattered += sky_value_at(database, "source_factor", (double[]){parts->nodes[k], lit(database, source), angle}) *
                     sky_value_at(database, "scattered_ratio", (double[]){parts->nodes[k], line->share, line->height_root, line->direction});
    scattered = night(database, source) * fmax(scattered, 0.0) * absorbed(database, "source_reference", path);
    const double thermal = sky_value_at(database, "thermal_ratio", (double[]){line->share, line->height_root, line->direction}) *
                           absorbed(database, "thermal_reference", path);
    return absorptance > 0 ? (thermal + scattered) / absorptance : 0.0;
}

/* How light is parted: by shares of so many wavelengths in each channel, or not at all where they are NULL. */
struct parting {
    size_t count;
    const float *thermal, *source;
};

/* Light on the surface at the end of a path as the path weighs it, over its transmittance, parted by the shares, and
 * added `by` times; `where` has one value for each axis of the light behind its parts, `spectrum` multiplies the channels
 * where it is not NULL. */
static void add_light(const struct database *database, const char *name, const struct path *path, const double *where, const double *spectrum,
                      size_t count, const float *shares, double by, double *to)
{
    char factor_name[2 * NAME];
    snprintf(factor_name, sizeof factor_name, "%s_factor", name);
    const struct array *array = sky_array_of(database, name);
    const float *factor = sky_array_of(database, factor_name)->values, *weight = sky_array_of(database, "channel_weight")->values;
    const size_t parts = array->axes[0].count;
    const double least = least_depth(path);
    double mean = 0.0, place[AXES] = {0}, *value = sky_allocate(parts, sizeof *value);
    for (size_t k = 1; k < array->rank; ++k) place[k] = where[k - 1];
    for (size_t q = 0; q < parts; ++q) {
        place[0] = array->axes[0].nodes[q];
        value[q] = sky_value_at(database, name, place);
    }
    for (size_t j = 0; j < path->channels; ++j) mean += weight[j] * exp(least - path->depth[j]);
    for (size_t j = 0; j < path->channels; ++j) {
        double lit = 0.0;
        for (size_t q = 0; q < parts; ++q) lit += factor[j * parts + q] * value[q];
        lit *= by * exp(least - path->depth[j]) * (spectrum ? spectrum[j] : 1.0) / mean;
        for (size_t b = 0; b < count; ++b) to[b] += lit * (shares ? shares[j * count + b] : 1.0);
    }
    sky_release(value);
}

static void bound_at_zero(size_t count, double *values)
{
    for (size_t b = 0; b < count; ++b) values[b] = fmax(values[b], 0.0);
}

static void add_direct(const struct database *database, const struct path *path, double source, const struct parting *parting, double *to)
{
    const double height = path->line.end_height;
    lit(database, source);
    const double above = source - sky_value_at(database, "source_rise", &height);
    if (above >= 0) add_light(database, "direct_light", path, (double[]){height, above}, NULL, parting->count, parting->source, 1.0, to);
    bound_at_zero(parting->count, to);
}

/* What the air emits and what it scatters; `harmonic` is its code, of the sky itself of no account. */
static void add_sky(const struct database *database, const char *thermal, const char *scattered, const struct path *path, double source,
                    double harmonic, const struct parting *parting, double *to)
{
    const double height = path->line.end_height, share = night(database, source);
    add_light(database, thermal, path, (double[]){height, harmonic}, NULL, parting->count, parting->thermal, 1.0, to);
    add_light(database, scattered, path, (double[]){height, lit(database, source), harmonic}, NULL, parting->count, parting->source, share, to);
}

static void add_ground(const struct database *database, const struct path *path, double kelvin, double harmonic, const struct parting *parting, double *to)
{
    const struct axis *channels = &sky_array_of(database, "ground_emission")->axes[1];
    double *emission = sky_allocate(path->channels, sizeof *emission);
    for (size_t j = 0; j < path->channels; ++j)
        emission[j] = sky_value_at(database, "ground_emission", (double[]){kelvin, channels->nodes[j]});
    add_light(database, "ground_harmonics", path, (double[]){path->line.end_height, harmonic}, emission, parting->count, parting->thermal, 1.0, to);
    sky_release(emission);
}

static void add_on_surface(const struct database *database, const char *name, const struct path *path, const double *where,
                           const struct parting *parting, double *to)
{
    if (!strcmp(name, "direct_radiance")) add_direct(database, path, where[SOURCE], parting, to);
    else if (!strcmp(name, "ambient_radiance")) {
        add_sky(database, "thermal_sky", "scattered_sky", path, where[SOURCE], 0.0, parting, to);
        bound_at_zero(parting->count, to);
    } else if (!strcmp(name, LIGHT)) add_sky(database, "thermal_harmonics", "scattered_harmonics", path, where[SOURCE], where[LAST], parting, to);
    else add_ground(database, path, where[3], where[LAST], parting, to);
}

static void release(struct path *path)
{
    sky_release(path->depth);
    sky_release(path->extinction);
}

double sky_quantity_at(const struct database *database, const char *name, const double *where)
{
    struct path path = path_of(database, where);
    double value = 0.0;
    if (!strcmp(name, "beta_star")) value = beta_star(database, &path, within(database, RANGE, where[RANGE]));
    else if (!strcmp(name, "path_radiance_ratio")) value = path_radiance_ratio(database, &path, where[SOURCE], where[LAST]);
    else add_on_surface(database, name, &path, where, &(struct parting){1, NULL, NULL}, &value);
    release(&path);
    return value;
}

double sky_source_at_entry(const struct database *database, const double *where)
{
    const double turn = line_of(database, where).turn, up = RADIAN * where[SOURCE], aside = RADIAN * where[LAST];
    const double sine = cos(turn) * sin(up) + sin(turn) * cos(up) * cos(aside);
    return turn > 0 ? asin(fmin(fmax(sine, -1.0), 1.0)) / RADIAN : where[SOURCE];
}

void sky_light_by_wavelength(const struct database *database, const char *name, const double *where, double *to)
{
    const struct array *thermal = sky_array_of(database, "thermal_wavelength_share"), *source = sky_array_of(database, "source_wavelength_share");
    const struct parting parting = {thermal->axes[1].count, thermal->values, source->values};
    struct path path = path_of(database, where);
    for (size_t b = 0; b < parting.count; ++b) to[b] = 0.0;
    add_on_surface(database, name, &path, where, &parting, to);
    release(&path);
}

void sky_extinction_by_wavelength(const struct database *database, const double *where, double *to)
{
    const struct array *shares = sky_array_of(database, "thermal_wavelength_share");
    const float *emitted = sky_array_of(database, "thermal_reference")->values, *weight = sky_array_of(database, "channel_weight")->values;
    const size_t count = shares->axes[1].count;
    const double reach = fmax(within(database, RANGE, where[RANGE]), SHORTEST);
    struct path path = path_of(database, where);
    for (size_t b = 0; b < count; ++b) {
        double all = 0.0, whole = 0.0, absorbed = 0.0, through = 0.0;
        for (size_t j = 0; j < path.channels; ++j) all += (double)emitted[j] * shares->values[j * count + b];
        for (size_t j = 0; j < path.channels; ++j) {
            const double part = all > 0 ? (double)emitted[j] * shares->values[j * count + b] : weight[j];
            whole += part;
            absorbed += part * -expm1(-path.depth[j]);
            through += part * exp(-path.depth[j]);
        }
        absorbed /= all > 0 ? whole : 1.0;
        through /= all > 0 ? whole : 1.0;
        to[b] = -(absorbed < 0.5 ? log1p(-absorbed) : log(fmax(through, DBL_MIN))) / reach;
    }
    release(&path);
}
