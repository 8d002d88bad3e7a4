/* Lines of sight through the air, and the light at their ends: the formulas of schemas/formats/atmq-1.md. */
#ifndef SKYSHINE_AIR_H
#define SKYSHINE_AIR_H

#include "pixel_tables.h"

enum { BLOCK = 32 }; /* lines or pixels that go through a step together */

static const double EARTH_RADIUS_KM = 6371.0088, TOP_OF_AIR_KM = 100, SHORTEST_KM = 1e-12, BETA_FACTOR = 5.5, LONGEST_BETA_KM = 1e12;
static const double CIVIL_TWILIGHT = -6;  /* degree: a table whose lowest source elevation is above says nothing of twilight */
static const double OPAQUE = 500;         /* least optical depth from which transmittances are relative to the largest */
static const double LEAST_NORMAL = 2.2250738585072014e-308;

/* Lines of a block: their places in the tables, the lengths that mean extinction is multiplied by, the heights of their
 * ends. Of lines from space: the angle at the Earth's centre to where they enter the air, and the height of an end in space. */
typedef struct {
    double range[BLOCK], altitude[BLOCK], elevation[BLOCK], looked[BLOCK]; /* bounded; at the entry; elevation at the observer */
    double height[BLOCK], root[BLOCK], rho[BLOCK], share[BLOCK], direction[BLOCK], length[BLOCK], end_height[BLOCK];
    double distance[BLOCK]; /* to the ground; infinite for lines to space */
    double turn[BLOCK], end_in_space[BLOCK];
    double angle[BLOCK]; /* between line and source */
    Place root_place[BLOCK];
} Lines;

static inline int32_t within(const SkyTables *tables, int which, double value, size_t row, double *inside, SkyFailure *failure) {
    static const char *const NAMES[] = {"range", "altitude", "elevation"};
    const double *numbers = tables->air.numbers;
    double first = which == 2 ? -90 : numbers[SKY_RANGE_FIRST + 2 * which], last = which == 2 ? 90 : numbers[SKY_RANGE_LAST + 2 * which];
    int outside = !(value >= first && value <= last) && !(numbers[SKY_CLAMP_RANGE + which] != 0);
    if (!is_finite(value) || outside || (which == 0 && value < 0))
        return refuse(failure, SKY_OUTSIDE, SKY_AIR, row, NAMES[which], value, first, last);
    *inside = clipped(value, first, last);
    return SKY_OK;
}

/* The rest of a line from an observer above the air: it begins where it enters the air, with the elevation there, and has
 * no length where it does not. */
static inline void enter(Lines *lines, size_t i) {
    double cosine, radius = EARTH_RADIUS_KM + lines->altitude[i], top = EARTH_RADIUS_KM + TOP_OF_AIR_KM;
    double elevation = lines->elevation[i], reach = lines->range[i], rise = radius * sine_and_cosine(elevation, &cosine);
    double inside = rise * rise - (radius * radius - top * top);
    int enters = elevation < 0 && inside >= 0;
    double way = enters ? -rise - __builtin_sqrt(inside) : INFINITE;
    double there = enters ? arc_sine(clipped((rise + way) / top, -1, 1)) * (180 / PI) : 90;
    lines->turn[i] = enters ? (there - elevation) * (PI / 180) : 0;
    lines->range[i] = larger(reach - way, 0);
    lines->altitude[i] = TOP_OF_AIR_KM;
    lines->elevation[i] = there;
    double end = __builtin_sqrt(larger(radius * radius + 2 * rise * reach + reach * reach, 0)) - EARTH_RADIUS_KM;
    lines->end_in_space[i] = reach > way ? NOT_A_NUMBER : end;
}

/* Share, direction and length, of lines whose `rho` is known; the straight height of their ends. */
static inline void ray_places(const SkyTables *tables, Lines *lines) {
    double scale = tables->air.numbers[SKY_SCALE_HEIGHT], ground = tables->air.numbers[SKY_GROUND_ALTITUDE];
    int straight = tables->air.arrays[END_RISE].values != 0;
    for (size_t i = 0; i < BLOCK; i += DOUBLES) {
        VectorD angle = load_d(lines->elevation + i), reach = load_d(lines->range + i), height = load_d(lines->height + i);
        VectorD rho = load_d(lines->rho + i), sine, cosine, half, unused, none = all_d(0), one = all_d(1);
        sine_and_cosine_d(angle, &sine, &cosine);
        sine_and_cosine_d(angle * 0.5, &half, &unused);
        VectorD radius = rho + height, rise = radius * sine, fall = height * (2 * rho + height), inside = rise * rise - fall;
        BitsD down = angle < none, grounded = down & (inside >= none);
        VectorD below = root_d(larger_d(inside, none)) - rise;
        VectorD distance = select_d(grounded, fall / select_d(grounded, below, one), none);
        VectorD across = 2 * rho * height, curved = (distance * distance - height * height) / select_d(across > none, across, one);
        VectorD above = scale * (2 * radius + scale), way = above / (rise + root_d(rise * rise + above)), level = root_d(above);
        VectorD drop = 2 * radius * half * half / select_d(height > none, height, one);
        VectorD passing = 3.0 - root_d(smaller_d(larger_d(drop, none), one));
        VectorD upward = 3.0 + smaller_d(larger_d((level - way) / (level - scale), none), one);
        VectorD part = select_d(distance > none, reach / select_d(distance > none, distance, one), one), through, to_space;
        attenuation_d(reach / way, &through, &to_space);
        VectorD direction = select_d(grounded, smaller_d(larger_d(curved, none), one), select_d(down, passing, upward));
        store_d(lines->share + i, select_d(grounded, smaller_d(part, one), to_space));
        store_d(lines->direction + i, direction);
        store_d(lines->length + i, select_d(grounded, reach, way * to_space));
        store_d(lines->distance + i, select_d(grounded, distance, all_d(INFINITE)));
        /* Of a straight line over the Earth, or over one that has the horizon of the bent lines. */
        VectorD earth = straight ? all_d(EARTH_RADIUS_KM + ground) : rho, walked = select_d(grounded, smaller_d(reach, distance), reach);
        VectorD start = earth + height, step = walked * walked + 2 * start * sine * walked;
        VectorD end = (step + height * (2 * earth + height)) / (earth + root_d(larger_d(start * start + step, none)));
        store_d(lines->end_height + i, end);
    }
}

/* Lines of a block, at most BLOCK; the rest of the block repeats the last one. */
static inline int32_t take_lines(const SkyTables *tables, size_t count, const double *range, const double *altitude,
                                 const double *elevation, size_t row, Lines *lines, SkyFailure *failure) {
    const double *given[] = {range, altitude, elevation};
    double *const to[] = {lines->range, lines->altitude, lines->looked};
    double ground = tables->air.numbers[SKY_GROUND_ALTITUDE];
    for (size_t i = 0; i < count; i++)
        for (int which = 0; which < 3; which++) {
            int32_t status = within(tables, which, given[which][i], row + i, &to[which][i], failure);
            if (status) return status;
        }
    for (size_t i = 0; i < BLOCK; i++) {
        for (int which = 0; which < 3 && i >= count; which++) to[which][i] = to[which][count - 1];
        lines->elevation[i] = lines->looked[i];
        lines->turn[i] = 0;
        lines->end_in_space[i] = NOT_A_NUMBER;
        if (lines->altitude[i] > TOP_OF_AIR_KM) enter(lines, i);
        lines->height[i] = larger(lines->altitude[i] - ground, 0);
    }
    const Array *radius = &tables->air.arrays[EFFECTIVE_RADIUS];
    for (size_t i = 0; i < BLOCK; i += DOUBLES) store_d(lines->root + i, cube_root_d(load_d(lines->height + i)));
    for (size_t i = 0; i < BLOCK; i++) {
        int32_t status = find(&radius->axes[0], lines->root[i], SKY_AIR, row, &lines->root_place[i], failure);
        if (status) return status;
        lines->rho[i] = corner_sum(radius, &lines->root_place[i]);
    }
    ray_places(tables, lines);
    return SKY_OK;
}

/* A path: what it lets through of each channel (times e^shift) and absorbs, and means of the band. */
typedef struct {
    double *extinction, *through, *absorbed; /* (channel_row); mean extinction per km */
    double shift, mean;                      /* weighted sum of `through` */
    double log_tau, absorptance, beta_star;  /* of the band */
    double end_height, thermal_ratio;
    double emitted, lit; /* sums of what the channels absorb of emitted light and of the source's */
    double *fields;                          /* (field_row) */
} Path;

/* Sum of products of two rows, in eight parts. */
static inline double dot(const double *a, const double *b, size_t row) {
    VectorD part[8 / DOUBLES];
    double of[8];
    for (int h = 0; h < 8 / DOUBLES; h++) part[h] = all_d(0);
    for (size_t j = 0; j < row; j += 8)
        for (int h = 0; h < 8 / DOUBLES; h++) part[h] += load_d(a + j + h * DOUBLES) * load_d(b + j + h * DOUBLES);
    for (int h = 0; h < 8 / DOUBLES; h++) store_d(of + h * DOUBLES, part[h]);
    return ((of[0] + of[4]) + (of[1] + of[5])) + ((of[2] + of[6]) + (of[3] + of[7]));
}

/* Rows of numbers at corners, times their weights; rows of a multiple of eight. */
static inline void mix_rows(const float *values, size_t row, const size_t *corner, const double *weight, int corners, double *to) {
    for (size_t k = 0; k < row; k += DOUBLES) {
        VectorD sum = all_d(0);
        for (int c = 0; c < corners; c++) sum += weight[c] * load_fd(values + corner[c] * row + k);
        store_d(to + k, sum);
    }
}

/* Rows of a matrix times numbers, added to `to`; times `by` and, where it is not NULL, another row. */
static inline void add_rows(const double *matrix, size_t rows, size_t row, const double *numbers, double by, const double *times, double *to) {
    enum { WIDE = 8 }; /* vectors at once, for one sum waits for its last */
    size_t b = 0;
    for (; b + WIDE * DOUBLES <= row; b += WIDE * DOUBLES) {
        VectorD sum[WIDE];
        for (int h = 0; h < WIDE; h++) sum[h] = all_d(0);
        for (size_t r = 0; r < rows; r++)
            for (int h = 0; h < WIDE; h++) sum[h] += numbers[r] * load_d(matrix + r * row + b + h * DOUBLES);
        for (int h = 0; h < WIDE; h++) {
            sum[h] *= by;
            if (times) sum[h] *= load_d(times + b + h * DOUBLES);
            store_d(to + b + h * DOUBLES, load_d(to + b + h * DOUBLES) + sum[h]);
        }
    }
    for (; b < row; b += DOUBLES) {
        VectorD sum = all_d(0);
        for (size_t r = 0; r < rows; r++) sum += numbers[r] * load_d(matrix + r * row + b);
        sum *= by;
        if (times) sum *= load_d(times + b);
        store_d(to + b, load_d(to + b) + sum);
    }
}

/* Corners of a cell of two axes. */
static inline void corners_of(const Place *first, const Place *second, size_t count, size_t *corner, double *weight) {
    for (int c = 0; c < 4; c++) {
        corner[c] = (c & 2 ? first->upper : first->lower) * count + (c & 1 ? second->upper : second->lower);
        weight[c] = (c & 2 ? first->weight : 1 - first->weight) * (c & 1 ? second->weight : 1 - second->weight);
    }
}

/* Fields at the place of a line; the height of its end. */
static inline int32_t read_fields(const SkyTables *tables, const Lines *lines, size_t i, size_t row, Path *path, SkyFailure *failure) {
    const Axis *axes = &tables->air.arrays[THERMAL_RATIO].axes[0];
    Place share, direction;
    int32_t status = find(&axes[0], lines->share[i], SKY_AIR, row, &share, failure);
    if (!status) status = find(&axes[2], lines->direction[i], SKY_AIR, row, &direction, failure);
    if (status) return status;
    size_t corner[8];
    double weight[8];
    const Place *root = &lines->root_place[i];
    corners_of(root, &direction, axes[2].count, corner, weight);
    for (int c = 3; c >= 0; c--)
        for (int s = 1; s >= 0; s--) {
            corner[s * 4 + c] = (s ? share.upper : share.lower) * axes[1].count * axes[2].count + corner[c];
            weight[s * 4 + c] = (s ? share.weight : 1 - share.weight) * weight[c];
        }
    mix_rows(tables->field, tables->field_row, corner, weight, 8, path->fields);
    path->thermal_ratio = path->fields[tables->absorbers + tables->source_parts];
    int grounded = lines->range[i] >= lines->distance[i];
    double end = lines->end_height[i];
    if (tables->air.arrays[END_RISE].values) end += smaller(lines->range[i], lines->distance[i]) * path->fields[tables->fields - 1];
    path->end_height = grounded ? 0 : larger(end, 0);
    if (is_finite(lines->end_in_space[i])) path->end_height = lines->end_in_space[i] - tables->air.numbers[SKY_GROUND_ALTITUDE];
    return SKY_OK;
}

/* Optical depths of the channels and what follows from them. `range` is that of the whole line. */
static inline int32_t take_path(const SkyTables *tables, const Lines *lines, size_t i, double range, size_t row, Path *path,
                                SkyFailure *failure) {
    int32_t status = read_fields(tables, lines, i, row, path, failure);
    if (status) return status;
    size_t count = tables->channel_row, last = tables->channels - 1;
    double length = larger(lines->length[i], SHORTEST_KM), *fields = path->fields;
    for (size_t k = 0; k < tables->field_row; k += DOUBLES)
        if (k < tables->absorbers) {
            double mean[DOUBLES];
            store_d(mean, exp_d(load_d(fields + k)));
            for (size_t h = 0; h < DOUBLES && k + h < tables->absorbers; h++) fields[k + h] = mean[h];
        }
    for (size_t j = 0; j < count; j++) path->extinction[j] = 0;
    add_rows(tables->absorber_factor, tables->absorbers, count, fields, 1, 0, path->extinction);
    for (size_t j = 0; j < count; j += DOUBLES) store_d(path->extinction + j, larger_d(load_d(path->extinction + j), all_d(0)));
    for (size_t j = last + 1; j < count; j++) path->extinction[j] = path->extinction[last];
    VectorD least = load_d(path->extinction);
    for (size_t j = DOUBLES; j < count; j += DOUBLES) least = smaller_d(load_d(path->extinction + j), least);
    double thinnest = least[0];
    for (int h = 1; h < DOUBLES; h++) thinnest = smaller(thinnest, least[h]);
    path->shift = thinnest * length > OPAQUE ? thinnest * length : 0;
    for (size_t j = 0; j < count; j += DOUBLES) {
        VectorD through, absorbed, depth = load_d(path->extinction + j) * length;
        attenuation_d(depth - path->shift, &through, &absorbed);
        store_d(path->through + j, through);
        store_d(path->absorbed + j, path->shift > 0 ? all_d(1) : absorbed);
    }
    path->mean = dot(tables->weight, path->through, count);
    path->absorptance = dot(tables->weight, path->absorbed, count);
    path->emitted = dot(path->absorbed, tables->thermal_reference, count);
    path->lit = dot(path->absorbed, tables->source_reference, count);
    path->log_tau = path->absorptance < 0.5 ? log_of_rest(path->absorptance) : logarithm(path->mean) - path->shift;
    double thickness = path->log_tau < 0 ? -path->log_tau : path->log_tau;
    double per_km = range > 0 ? thickness / range : dot(tables->weight, path->extinction, count);
    path->beta_star = per_km <= 0 ? LONGEST_BETA_KM : smaller(BETA_FACTOR / per_km, LONGEST_BETA_KM);
    return SKY_OK;
}

/* ---- The source ---- */

/* One value for each line of a block, of a list of one or of a value for each; the last is repeated, 0 without a list. */
static inline void spread(const double *list, int single, size_t from, size_t count, double *to) {
    for (size_t i = 0; i < BLOCK; i++) to[i] = list ? list[single ? 0 : from + (i < count ? i : count - 1)] : 0;
}

static inline const Axis *source_axis(const SkyTables *tables) { return &tables->air.arrays[SOURCE_FACTOR].axes[1]; }

/* Share of the light of the lowest elevation that the source gives below it, 1 above; and an elevation of the tables. */
static inline int32_t night(const SkyTables *tables, double elevation, size_t row, double *share, double *lit, SkyFailure *failure) {
    const Axis *axis = source_axis(tables);
    double lowest = axis->first, dark = axis->dark_below;
    if (!is_finite(elevation) || (elevation > axis->last && !axis->clamps))
        return refuse(failure, SKY_OUTSIDE, SKY_AIR, row, axis->name, elevation, lowest, axis->last);
    *lit = larger(elevation, lowest);
    *share = 1;
    if (elevation >= lowest) return SKY_OK;
    int fades = lowest <= CIVIL_TWILIGHT;
    if (!fades && elevation > dark && !axis->clamps)
        return refuse(failure, SKY_TWILIGHT, SKY_AIR, row, axis->name, elevation, lowest, dark);
    *share = elevation <= dark ? 0 : fades ? (elevation - dark) / (lowest - dark) : 1;
    return SKY_OK;
}

/* Angles between lines of sight and the source, of a block. */
static inline void scattering_angles(const double *elevation, const double *source, const double *azimuth, double *angle) {
    for (size_t i = 0; i < BLOCK; i += DOUBLES) {
        VectorD apart, turn, level, lit, unused, up = load_d(elevation + i), height = load_d(source + i), one = all_d(1);
        sine_and_cosine_d((up - height) * 0.5, &apart, &unused);
        sine_and_cosine_d(load_d(azimuth + i) * 0.5, &turn, &unused);
        sine_and_cosine_d(up, &unused, &level);
        sine_and_cosine_d(height, &unused, &lit);
        VectorD half = smaller_d(larger_d(apart * apart + level * lit * turn * turn, all_d(0)), one);
        store_d(angle + i, smaller_d(2 * arc_sine_d(root_d(half)) * (180 / PI), all_d(180)));
    }
}

/* Elevation of the source where a line enters the air, from that at its observer and its azimuth from the line. */
static inline double source_at_entry(double turn, double source, double azimuth) {
    if (!(turn > 0)) return source;
    double level, aside, of_turn, up = sine_and_cosine(source, &level), sine = sine_and_cosine(turn * (180 / PI), &of_turn);
    sine_and_cosine(azimuth, &aside);
    return arc_sine(clipped(of_turn * up + sine * level * aside, -1, 1)) * (180 / PI);
}

/* Path radiance over the absorptance, (10); `source` where the line enters the air. */
static inline int32_t path_ratio(const SkyTables *tables, const Path *path, double source, double angle, size_t row, double *ratio,
                                 SkyFailure *failure) {
    const Axis *axes = tables->air.arrays[SOURCE_FACTOR].axes;
    double share, lit, scattered = 0, weight[4];
    size_t corner[4], parts = tables->source_parts;
    Place height, turned;
    int32_t status = night(tables, source, row, &share, &lit, failure);
    if (!status) status = find(&axes[1], lit, SKY_AIR, row, &height, failure);
    if (!status) status = find(&axes[2], angle, SKY_AIR, row, &turned, failure);
    if (status) return status;
    corners_of(&height, &turned, axes[2].count, corner, weight);
    for (size_t k = 0; k < parts; k++) {
        double factor = 0;
        for (int c = 0; c < 4; c++) factor += weight[c] * tables->source_factor[corner[c] * parts + k];
        scattered += factor * path->fields[tables->absorbers + k];
    }
    scattered = larger(scattered, 0) * share * path->lit;
    *ratio = path->absorptance <= 0 ? 0 : (path->thermal_ratio * path->emitted + scattered) / path->absorptance;
    return SKY_OK;
}

/* ---- Light at the end of a path ---- */

/* Parts of light at a place, weighed by the weights of its codes: (parts). */
static inline void light_parts(const Light *light, const size_t *corner, const double *weight, int corners, const double *codes,
                               double *to) {
    for (size_t q = 0; q < light->parts; q++) {
        double sum = 0;
        for (int c = 0; c < corners; c++) {
            const float *values = light->values + (corner[c] * light->parts + q) * light->codes;
            double of_place = 0;
            for (size_t h = 0; h < light->codes; h++) of_place += codes[h] * values[h];
            sum += weight[c] * of_place;
        }
        to[q] = sum;
    }
}

/* Light in the channels from its parts, times `by` and, where it is not NULL, a spectrum: added to `to`. */
static inline void add_channels(const SkyTables *tables, const Light *light, const double *part, double by, const double *spectrum,
                                double *to) {
    add_rows(light->factor, light->parts, tables->channel_row, part, by, spectrum, to);
}

/* Places of the light of the sky at a height under a source: one corner an altitude, or four with its elevation. */
typedef struct {
    size_t height_corner[2], corner[4];
    double height_weight[2], weight[4], share; /* of the night */
    double end_height;
} SkyPlace;

static inline int32_t place_sky(const SkyTables *tables, const Path *path, double source, size_t row, SkyPlace *place,
                                SkyFailure *failure) {
    const Axis *axes = &tables->air.arrays[SCATTERED_SKY].axes[1];
    double lit;
    Place height, elevation;
    int32_t status = night(tables, source, row, &place->share, &lit, failure);
    if (!status) status = find(&axes[0], path->end_height, SKY_AIR, row, &height, failure);
    if (!status) status = find(&axes[1], lit, SKY_AIR, row, &elevation, failure);
    if (status) return status;
    place->end_height = path->end_height;
    place->height_corner[0] = height.lower, place->height_corner[1] = height.upper;
    place->height_weight[0] = 1 - height.weight, place->height_weight[1] = height.weight;
    corners_of(&height, &elevation, axes[1].count, place->corner, place->weight);
    return SKY_OK;
}

/* Light of the sky in the channels: what air emits is added to `thermal`, what it scatters to `scattered`. */
static inline void add_sky(const SkyTables *tables, const Light *emitted, const Light *lit, const SkyPlace *place, const double *codes,
                           double *part, double *thermal, double *scattered) {
    light_parts(emitted, place->height_corner, place->height_weight, 2, codes, part);
    add_channels(tables, emitted, part, 1, 0, thermal);
    light_parts(lit, place->corner, place->weight, 4, codes, part);
    add_channels(tables, lit, part, place->share, 0, scattered);
}

/* What the ground emits in the channels, per unit in the band. */
static inline int32_t ground_spectrum(const SkyTables *tables, double kelvin, size_t row, double *to, SkyFailure *failure) {
    Place place;
    int32_t status = find(&tables->air.arrays[GROUND_EMISSION].axes[0], kelvin, SKY_AIR, row, &place, failure);
    if (status) return status;
    const double *below = tables->ground_emission + place.lower * tables->channel_row;
    const double *above = tables->ground_emission + place.upper * tables->channel_row;
    for (size_t j = 0; j < tables->channel_row; j++) to[j] = (1 - place.weight) * below[j] + place.weight * above[j];
    return SKY_OK;
}

/* Light of the source in the channels; 0 before it rises. */
static inline int32_t add_direct(const SkyTables *tables, const Path *path, double source, size_t row, double *part, double *to,
                                 SkyFailure *failure) {
    const Axis *axes = &tables->air.arrays[DIRECT_LIGHT].axes[1], *all = source_axis(tables);
    const Array *rise = &tables->air.arrays[SOURCE_RISE];
    static const double one = 1;
    double weight[4];
    size_t corner[4];
    Place height, target, above;
    if (!is_finite(source) || (source > all->last && !all->clamps))
        return refuse(failure, SKY_OUTSIDE, SKY_AIR, row, all->name, source, all->first, all->last);
    int32_t status = find(&rise->axes[0], path->end_height, SKY_AIR, row, &target, failure);
    if (status) return status;
    double up = source - corner_sum(rise, &target);
    if (up < 0) return SKY_OK;
    status = find(&axes[0], path->end_height, SKY_AIR, row, &height, failure);
    if (!status) status = find(&axes[1], up, SKY_AIR, row, &above, failure);
    if (status) return status;
    corners_of(&height, &above, axes[1].count, corner, weight);
    light_parts(&tables->direct, corner, weight, 4, &one, part);
    add_channels(tables, &tables->direct, part, 1, 0, to);
    return SKY_OK;
}

/* Weigh light in the channels as the path does, over its transmittance. */
static inline void weigh(const SkyTables *tables, const Path *path, double *light) {
    VectorD per_mean = all_d(1 / path->mean);
    for (size_t j = 0; j < tables->channel_row; j += DOUBLES)
        store_d(light + j, load_d(light + j) * load_d(path->through + j) * per_mean);
}

/* Light in the channels parted by wavelength, added to `to`. */
static inline void add_wavelengths(const SkyTables *tables, const double *light, const double *share, double *to) {
    add_rows(share, tables->channels, tables->wavelength_row, light, 1, 0, to);
}

static inline void bound_at_zero(double *values, size_t count) {
    for (size_t b = 0; b < count; b++) values[b] = larger(values[b], 0);
}

static inline void clear(double *values, size_t count) {
    for (size_t b = 0; b < count; b++) values[b] = 0;
}

/* -ln of the transmittance of emitted light by wavelength; 0 in the padding. */
static inline void optical_depths(const SkyTables *tables, const Path *path, double *part, double *to) {
    size_t row = tables->wavelength_row;
    double *through = part, *absorbed = part + row, scale = path->shift > 0 ? exponential(-path->shift) : 1;
    clear(part, 2 * row);
    add_wavelengths(tables, path->through, tables->emitted_share, through);
    add_wavelengths(tables, path->absorbed, tables->emitted_share, absorbed);
    for (size_t b = 0; b < row; b += DOUBLES) {
        VectorD rest = load_d(absorbed + b), left = larger_d(load_d(through + b) * scale, all_d(LEAST_NORMAL));
        VectorD thin = log_of_rest_d(smaller_d(rest, all_d(0.5))), depth = -select_d(rest < all_d(0.5), thin, logarithm_d(left));
        store_d(to + b, select_d(load_d(tables->dark + b) > all_d(0), all_d(-path->log_tau), depth));
    }
    for (size_t b = tables->wavelengths; b < row; b++) to[b] = 0;
}

/* Rows of a scratch for one path. */
static inline size_t path_size(const SkyTables *tables) { return 3 * tables->channel_row + tables->field_row; }

static inline void set_path(const SkyTables *tables, Path *path, double *rows) {
    path->extinction = rows;
    path->through = rows + tables->channel_row;
    path->absorbed = rows + 2 * tables->channel_row;
    path->fields = rows + 3 * tables->channel_row;
}

static inline size_t most_parts(const SkyTables *tables) {
    const Light *lights[] = {&tables->direct, &tables->thermal_sky, &tables->scattered_sky, &tables->thermal_harmonics,
                             &tables->scattered_harmonics, &tables->ground_harmonics};
    size_t most = 0;
    for (int k = 0; k < 6; k++) most = lights[k]->parts > most ? lights[k]->parts : most;
    return row_of(most);
}

#endif
