/* Many pixels of one observer, one source and one time. What they share is resolved once; the pixels are then computed in
 * blocks, each step over a whole block, so that a compiler can use vector instructions. */
#include "tables.h"
#include "vector_math.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The same function for several instruction sets, of which the loader takes the best that the processor has. */
#if defined __x86_64__ && defined __linux__ && defined __GNUC__ && !defined __clang__ && __GNUC__ >= 12 && !defined __SANITIZE_ADDRESS__
#define EACH_PROCESSOR __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define EACH_PROCESSOR
#endif

/* The turns of a loop read nothing that another one writes. */
#if defined __clang__
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined __GNUC__
#define INDEPENDENT _Pragma("GCC ivdep")
#else
#define INDEPENDENT
#endif

enum { BLOCK = 256, CODES = 65536, CELLS_LIMIT = 65536 };
/* Panels of the lattice of ranges: in each octave of range + NEAREST equally many of equal length, each with a cubic. */
enum { OCTAVE_BITS = 4, OCTAVES = 22, PANELS = OCTAVES << OCTAVE_BITS, CUBIC = 4 };
static const double NEAREST = 1.0 / 1024, FARTHEST = 4095.0; /* km */

/* An axis whose cells are found by one division and few comparisons. A periodic one has its first node again at its end; one
 * of a single node has a second one, at which the same values stand. */
struct grid {
    const char *name;
    double *nodes, *per_length, first, last, scale, period;
    int32_t *cell; /* the lowest that reaches into an equal part of the axis */
    int parts, steps, count, clamps;
    int even; /* all cells are of the same length */
};

/* Of each material: what the beam becomes by (34) and by (35), without incidence and lobe. */
struct materials {
    double *diffuse, *specular, *shininess;
};

struct skyshine_frame {
    const skyshine_tables *tables;
    struct block *memory;
    double extinction, path_ratio; /* of the centre: 5.5 / beta*, and (10) */
    double source_heading, sine, cosine; /* of the source's elevation */
    double elevation, heading; /* of the centre's line */
    int32_t *in_band, *in_surface; /* index of a code; -1 where there is none */
    struct materials materials;
    struct grid altitude, azimuth, slope, kelvin, planck;
    size_t plane; /* temperatures of one material */
    double *temperature, *blackbody;
    double *emission; /* by material, panel and node of `planck`: coefficients of a cubic */
    size_t bases;
    double *sky; /* by material and basis: reflected light */
    /* Wavelengths at which light may fall below 0, where it is bounded: taken out of `sky`. */
    size_t bounded;
    double *sky_bounded, *rho_bounded;
};

/* ---- The frame. ---- */

static void make_grid(struct grid *grid, const struct axis *axis)
{
    const int closed = !strcmp(axis->rule, "linear_periodic"), single = axis->count == 1 && !closed;
    grid->name = axis->name;
    grid->count = (int)axis->count + (closed || single);
    grid->nodes = sky_allocate((size_t)grid->count, sizeof(double));
    memcpy(grid->nodes, axis->nodes, axis->count * sizeof(double));
    grid->first = grid->nodes[0];
    grid->period = closed ? axis->period : 0.0;
    if (closed) grid->nodes[axis->count] = grid->first + axis->period;
    if (single) grid->nodes[1] = grid->first + 1.0;
    grid->last = single ? grid->first : grid->nodes[grid->count - 1];
    grid->clamps = axis->clamps;
    const double length = grid->nodes[grid->count - 1] - grid->first;
    double shortest = length;
    grid->per_length = sky_allocate((size_t)grid->count, sizeof(double));
    for (int i = 0; i + 1 < grid->count; ++i) {
        shortest = fmin(shortest, grid->nodes[i + 1] - grid->nodes[i]);
        grid->per_length[i] = 1.0 / (grid->nodes[i + 1] - grid->nodes[i]);
    }
    grid->even = 1;
    for (int i = 1; i + 1 < grid->count; ++i) grid->even = grid->even && fabs(grid->nodes[i] - grid->first - i * shortest) < 1e-9 * shortest;
    /* More than two parts to the shortest cell: then one comparison finds the cell. */
    grid->parts = grid->even ? grid->count - 1 : (int)fmin(ceil(2.1 * length / shortest), CELLS_LIMIT);
    grid->scale = grid->parts / length;
    grid->cell = sky_allocate((size_t)grid->parts + 1, sizeof *grid->cell);
    grid->steps = 1;
    for (int part = 0, at = 0; part <= grid->parts; ++part) {
        /* One part earlier, for the division that finds the part may round. */
        while (at + 2 < grid->count && grid->nodes[at + 1] <= grid->first + (part - 1) / grid->scale) ++at;
        grid->cell[part] = at;
        int steps = 0;
        while (at + steps + 2 < grid->count && grid->nodes[at + steps + 1] <= grid->first + (part + 1) / grid->scale) ++steps;
        if (steps > grid->steps) grid->steps = steps;
    }
}

/* Temperatures of the frame's time, with the nodes that grids have beyond those of the axes. */
static void make_temperatures(skyshine_frame *frame, double time)
{
    const struct database *surface = &frame->tables->surface;
    const struct axis *axes = sky_array_of(surface, "temperature")->axes;
    make_grid(&frame->altitude, &axes[1]);
    make_grid(&frame->azimuth, &axes[2]);
    make_grid(&frame->slope, &axes[3]);
    const size_t lengths[] = {(size_t)frame->altitude.count, (size_t)frame->azimuth.count, (size_t)frame->slope.count};
    frame->plane = lengths[0] * lengths[1] * lengths[2];
    frame->temperature = sky_allocate(axes[0].count * frame->plane, sizeof(double));
    frame->in_surface = sky_allocate(CODES, sizeof(int32_t));
    for (size_t code = 0; code < CODES; ++code) frame->in_surface[code] = -1;
    size_t at = 0;
    for (size_t m = 0; m < axes[0].count; ++m) {
        frame->in_surface[(size_t)axes[0].nodes[m]] = (int32_t)m;
        for (size_t i = 0; i < lengths[0]; ++i)
            for (size_t j = 0; j < lengths[1]; ++j)
                for (size_t k = 0; k < lengths[2]; ++k)
                    frame->temperature[at++] = sky_value_at(surface, "temperature", (double[]){axes[0].nodes[m], axes[1].nodes[i % axes[1].count],
                                                            axes[2].nodes[j % axes[2].count], axes[3].nodes[k % axes[3].count], time});
    }
}

/* Sums over wavelengths of weight times e^(-extinction range) as cubics of the range's place in each panel. */
static void make_panels(size_t parts, const double *weight, const double *extinction, double *to, size_t stride)
{
    for (size_t p = 0; p < PANELS; ++p) {
        const double begin = number_of(bits_of(NEAREST) + ((uint64_t)p << (52 - OCTAVE_BITS)));
        const double length = number_of(bits_of(NEAREST) + ((uint64_t)(p + 1) << (52 - OCTAVE_BITS))) - begin;
        double value[2] = {0, 0}, slope[2] = {0, 0};
        for (size_t b = 0; b < parts; ++b)
            for (int end = 0; end < 2; ++end) {
                const double part = weight[b] * exp(-extinction[b] * (begin - NEAREST + end * length));
                value[end] += part;
                slope[end] -= part * extinction[b] * length;
            }
        double *cubic = to + p * stride;
        cubic[0] = value[0];
        cubic[1] = slope[0];
        cubic[2] = 3 * (value[1] - value[0]) - 2 * slope[0] - slope[1];
        cubic[3] = 2 * (value[0] - value[1]) + slope[0] + slope[1];
    }
}

/* Reflectance of each material at each wavelength, or in the band. */
static double *reflectances(const skyshine_tables *tables, size_t parts)
{
    const struct array *array = sky_array_of(&tables->band, tables->air.parted ? "reflectance_spectrum" : "reflectance");
    const size_t count = array->axes[0].count * parts;
    double *rho = sky_allocate(count, sizeof *rho);
    for (size_t i = 0; i < count; ++i) rho[i] = array->values[i];
    return rho;
}

/* What each material emits through the air over each range, as a share of a black body. */
static void make_emission(skyshine_frame *frame, const double *place, size_t parts, const double *rho)
{
    const skyshine_tables *tables = frame->tables;
    double *extinction = sky_allocate(parts, sizeof *extinction), *weight = sky_allocate(parts, sizeof *weight);
    sky_extinction_at(&tables->air, place, extinction);
    double whole_band[] = {1.0};
    const struct axis undivided = {.name = "planck_temperature", .rule = "linear", .nodes = whole_band, .count = 1, .clamps = 1};
    const struct array *shares = tables->air.parted ? sky_array_of(&tables->band, "emission_share") : NULL;
    make_grid(&frame->planck, shares ? &shares->axes[0] : &undivided);
    const size_t nodes = (size_t)frame->planck.count, stride = nodes * CUBIC, materials = sky_array_of(&tables->band, "reflectance")->axes[0].count;
    frame->emission = sky_allocate(materials * PANELS * stride, sizeof(double));
    for (size_t m = 0; m < materials; ++m)
        for (size_t n = 0; n < nodes; ++n) {
            const size_t stored = shares && n < shares->axes[0].count ? n : 0;
            for (size_t b = 0; b < parts; ++b) weight[b] = (1.0 - rho[m * parts + b]) * (shares ? shares->values[stored * parts + b] : 1.0);
            make_panels(parts, weight, extinction, frame->emission + m * PANELS * stride + n * CUBIC, stride);
        }
}

/* Whether light at a wavelength may fall below 0, or near it, in some direction of a face. */
static int may_be_bounded(const struct database *air, size_t bases, size_t parts, const double *weights, size_t b)
{
    if (bases == 1) return weights[b] < 0.0;
    double least = HUGE_VAL, most = 0.0;
    for (int tilt = 0; tilt <= 180; tilt += 6)
        for (int turn = 0; turn <= 180; turn += 6) {
            double normal[3], across, at[BASES], light = 0.0;
            sine_and_cosine(tilt, &across, &normal[2]);
            sine_and_cosine(turn, &normal[1], &normal[0]);
            normal[0] *= across;
            normal[1] *= across;
            sky_bases(air, normal, at);
            for (size_t k = 0; k < bases; ++k) light += at[k] * weights[k * parts + b];
            least = fmin(least, light);
            most = fmax(most, fabs(light));
        }
    return least < 0.02 * most;
}

/* Light of the sky and the source that each material reflects, before the air in front of it. */
static void make_light(skyshine_frame *frame, const skyshine_view *view, const double *place, size_t parts, const double *rho)
{
    const skyshine_tables *tables = frame->tables;
    const size_t materials = sky_array_of(&tables->band, "reflectance")->axes[0].count;
    double ground[2], *weights = sky_allocate(BASES * parts, sizeof *weights), *beam = sky_allocate(parts, sizeof *beam);
    sky_ground_of(tables, tables->air.tilted ? view->ground_material : 0, view->ground_altitude, view->time, ground);
    frame->bases = sky_ambient_weights(&tables->air, place, tables->air.tilted, ground, parts, weights);
    frame->sky = sky_allocate(materials * BASES, sizeof(double));
    frame->sky_bounded = sky_allocate(BASES * parts, sizeof(double));
    frame->rho_bounded = sky_allocate(materials * parts, sizeof(double));
    frame->materials.diffuse = sky_allocate(materials, sizeof(double));
    sky_light_at(&tables->air, "direct_radiance", place, beam);
    for (size_t b = 0; b < parts; ++b) {
        const int bounded = may_be_bounded(&tables->air, frame->bases, parts, weights, b);
        for (size_t m = 0; m < materials; ++m) {
            frame->materials.diffuse[m] += rho[m * parts + b] * beam[b];
            if (bounded) frame->rho_bounded[m * parts + frame->bounded] = rho[m * parts + b];
            for (size_t k = 0; k < frame->bases && !bounded; ++k) frame->sky[m * BASES + k] += rho[m * parts + b] * weights[k * parts + b];
        }
        for (size_t k = 0; k < frame->bases && bounded; ++k) frame->sky_bounded[frame->bounded * BASES + k] = weights[k * parts + b];
        frame->bounded += (size_t)bounded;
    }
}

static void make_materials(skyshine_frame *frame)
{
    const struct database *band = &frame->tables->band;
    const struct axis *codes = &sky_array_of(band, "reflectance")->axes[0];
    struct materials *of = &frame->materials;
    of->specular = sky_allocate(codes->count, sizeof(double));
    of->shininess = sky_allocate(codes->count, sizeof(double));
    frame->in_band = sky_allocate(CODES, sizeof(int32_t));
    for (size_t code = 0; code < CODES; ++code) frame->in_band[code] = -1;
    for (size_t m = 0; m < codes->count; ++m) {
        const double direct = fmax(of->diffuse[m], 0.0), fraction = sky_array_of(band, "specular_fraction")->values[m];
        frame->in_band[(size_t)codes->nodes[m]] = (int32_t)m;
        of->diffuse[m] = direct * (1.0 - fraction);
        of->specular[m] = direct * fraction * sky_array_of(band, "normalisation")->values[m];
        of->shininess[m] = sky_array_of(band, "shininess")->values[m];
    }
    const struct array *blackbody = sky_array_of(band, "blackbody_radiance");
    make_grid(&frame->kelvin, &blackbody->axes[0]);
    frame->blackbody = sky_allocate((size_t)frame->kelvin.count, sizeof(double));
    for (int i = 0; i < frame->kelvin.count; ++i) frame->blackbody[i] = blackbody->values[(size_t)i < blackbody->axes[0].count ? i : 0];
}

static void make_frame(skyshine_frame *frame, const skyshine_tables *tables, const skyshine_view *view)
{
    const struct database *air = &tables->air;
    const double place[] = {view->centre_range, view->altitude, view->centre_elevation, view->source_elevation, view->source_heading - view->centre_heading};
    const size_t parts = sky_parts_of(air);
    if (!isfinite(place[4])) sky_fail("heading: found %g, %g; allowed: finite numbers", view->centre_heading, view->source_heading);
    frame->tables = tables;
    frame->extinction = 5.5 / sky_value_at(air, "beta_star", place);
    frame->path_ratio = sky_path_ratio_at(air, place);
    frame->source_heading = view->source_heading;
    sine_and_cosine(view->source_elevation, &frame->sine, &frame->cosine);
    frame->elevation = view->centre_elevation;
    frame->heading = view->centre_heading;
    const double *rho = reflectances(tables, parts);
    make_light(frame, view, place, parts, rho);
    make_emission(frame, place, parts, rho);
    make_materials(frame);
    make_temperatures(frame, view->time);
    frame->memory = sky_keep();
}

skyshine_status skyshine_frame_open(const skyshine_tables *tables, const skyshine_view *view, skyshine_frame **frame, skyshine_error *error)
{
    struct call call;
    skyshine_frame *opened = calloc(1, sizeof *opened);
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed)) {
        if (!opened) sky_fail("no memory is left");
        make_frame(opened, tables, view);
        *frame = opened;
    } else {
        free(opened);
    }
    return sky_end(&call, error);
}

void skyshine_frame_close(skyshine_frame *frame)
{
    if (!frame) return;
    sky_release_all(frame->memory);
    free(frame);
}

/* ---- Its pixels. ---- */

/* Lower nodes and weights of the upper ones; returns whether a value lies outside. */
INLINE int locate(const struct grid *grid, const double *values, int count, int32_t *lower, double *weight)
{
    const double first = grid->first, last = grid->last, scale = grid->scale, period = grid->period, per_period = period > 0.0 ? 1.0 / period : 0.0;
    const double *nodes = grid->nodes, *per_length = grid->per_length;
    const int32_t *cell = grid->cell;
    const int clamps = grid->clamps, last_cell = grid->count - 2;
    int outside = 0;
    INDEPENDENT
    for (int i = 0; i < count; ++i) {
        double value = values[i];
        value -= period * floor((value - first) * per_period);
        outside |= !((fabs(value) < 1e300) & (clamps | ((value >= first) & (value <= last))));
        value = value >= first ? value : first;
        weight[i] = value <= last ? value : last;
    }
    if (grid->even) {
        INDEPENDENT
        for (int i = 0; i < count; ++i) {
            const double place = (weight[i] - first) * scale;
            const int32_t at = (int32_t)place;
            lower[i] = at < last_cell ? at : last_cell;
            weight[i] = place - lower[i];
        }
        return outside;
    }
    if (grid->steps == 1) {
        INDEPENDENT
        for (int i = 0; i < count; ++i) {
            int32_t at = cell[(int32_t)((weight[i] - first) * scale)];
            at += (weight[i] >= nodes[at + 1]) & (at < last_cell);
            lower[i] = at;
            weight[i] = (weight[i] - nodes[at]) * per_length[at];
        }
        return outside;
    }
    for (int i = 0; i < count; ++i) {
        int32_t at = cell[(int32_t)((weight[i] - first) * scale)];
        while (at < last_cell && weight[i] >= nodes[at + 1]) ++at;
        lower[i] = at;
        weight[i] = (weight[i] - nodes[at]) * per_length[at];
    }
    return outside;
}

/* Pixels of a block. */
struct block_of {
    int count;
    int32_t material[BLOCK], surface[BLOCK], low[3][BLOCK], at[BLOCK];
    double weight[3][BLOCK], kelvin[BLOCK], blackbody[BLOCK], emitted[BLOCK], normal[3][BLOCK], sky[BLOCK], chi[BLOCK], incidence[BLOCK];
};

INLINE int read_temperatures(const skyshine_frame *frame, const skyshine_pixels *pixels, size_t from, struct block_of *block)
{
    int outside = locate(&frame->altitude, pixels->surface_altitude + from, block->count, block->low[0], block->weight[0]);
    outside |= locate(&frame->azimuth, pixels->surface_azimuth + from, block->count, block->low[1], block->weight[1]);
    outside |= locate(&frame->slope, pixels->surface_slope + from, block->count, block->low[2], block->weight[2]);
    const int32_t row = frame->slope.count, plane = row * frame->azimuth.count, whole = (int32_t)frame->plane;
    const double *values = frame->temperature, *u0 = block->weight[0], *v0 = block->weight[1], *w0 = block->weight[2];
    const int32_t *material = block->surface, *i0 = block->low[0], *j0 = block->low[1], *k0 = block->low[2];
    double *kelvin = block->kelvin;
    INDEPENDENT
    for (int i = 0; i < block->count; ++i) {
        const int32_t a0 = whole * material[i] + plane * i0[i] + row * j0[i] + k0[i], b0 = a0 + row, c0 = a0 + plane, d0 = c0 + row;
        const double a = values[a0] + w0[i] * (values[a0 + 1] - values[a0]), b = values[b0] + w0[i] * (values[b0 + 1] - values[b0]);
        const double c = values[c0] + w0[i] * (values[c0 + 1] - values[c0]), d = values[d0] + w0[i] * (values[d0 + 1] - values[d0]);
        const double lower = a + v0[i] * (b - a), upper = c + v0[i] * (d - c);
        kelvin[i] = lower + u0[i] * (upper - lower);
    }
    return outside;
}

/* (7), and the share of it that comes through the air. */
INLINE int emit(const skyshine_frame *frame, const double *range, struct block_of *block)
{
    int outside = locate(&frame->kelvin, block->kelvin, block->count, block->low[0], block->weight[0]);
    const double *blackbody = frame->blackbody, *emission = frame->emission, *weight = block->weight[0];
    const int32_t *lower = block->low[0], *material = block->material;
    const int32_t stride = frame->planck.count * CUBIC;
    double *radiance = block->blackbody, *emitted = block->emitted;
    const int count = block->count;
    INDEPENDENT
    for (int i = 0; i < count; ++i) radiance[i] = blackbody[lower[i]] + weight[i] * (blackbody[lower[i] + 1] - blackbody[lower[i]]);
    locate(&frame->planck, block->kelvin, count, block->low[0], block->weight[0]);
    INDEPENDENT
    for (int i = 0; i < count; ++i) {
        double length = range[i];
        outside |= !((length >= 0.0) & (length <= FARTHEST));
        length = length >= 0.0 ? length : 0.0;
        length = length <= FARTHEST ? length : FARTHEST;
        const uint64_t bits = bits_of(length + NEAREST) - bits_of(NEAREST);
        const int32_t panel = (int32_t)(bits >> (52 - OCTAVE_BITS));
        /* The bits within the panel, read as the mantissa of a number from 1 to 2. */
        const double t = number_of(((bits << OCTAVE_BITS) & 0x000FFFFFFFFFFFFFull) | 0x3FF0000000000000ull) - 1.0;
        const int32_t j = (material[i] * PANELS + panel) * stride + CUBIC * lower[i];
        const double cold = emission[j] + t * (emission[j + 1] + t * (emission[j + 2] + t * emission[j + 3]));
        const double warm = emission[j + 4] + t * (emission[j + 5] + t * (emission[j + 6] + t * emission[j + 7]));
        emitted[i] = radiance[i] * (cold + weight[i] * (warm - cold));
    }
    return outside;
}

/* Directions of faces and lines of sight, in the frame of the source's azimuth; incidence, and chi of (38). */
INLINE void face(const skyshine_frame *frame, const skyshine_pixels *pixels, size_t from, struct block_of *block)
{
    const double *slope = pixels->surface_slope + from, *azimuth = pixels->surface_azimuth + from, source = frame->source_heading;
    const double *elevations = pixels->elevation ? pixels->elevation + from : NULL, *headings = pixels->heading ? pixels->heading + from : NULL;
    const double ahead = frame->cosine, up = frame->sine;
    double constant_up, constant_level, constant_x, constant_y;
    sine_and_cosine(frame->elevation, &constant_up, &constant_level);
    sine_and_cosine(frame->heading - source, &constant_y, &constant_x);
    INDEPENDENT
    for (int i = 0; i < block->count; ++i) {
        double across, x, y, z;
        sine_and_cosine(slope[i], &across, &z);
        sine_and_cosine(azimuth[i] - source, &y, &x);
        block->normal[0][i] = across * x;
        block->normal[1][i] = across * y;
        block->normal[2][i] = z;
    }
    INDEPENDENT
    for (int i = 0; i < block->count; ++i) {
        double rise = constant_up, level = constant_level, turn_x = constant_x, turn_y = constant_y;
        if (elevations) {
            sine_and_cosine(elevations[i], &rise, &level);
            sine_and_cosine(headings[i] - source, &turn_y, &turn_x);
        }
        const double x = ahead - level * turn_x, y = -level * turn_y, z = up - rise;
        const double length = x * x + y * y + z * z, n0 = block->normal[0][i], n1 = block->normal[1][i], n2 = block->normal[2][i];
        double chi = (x * n0 + y * n1 + z * n2) / sqrt(length > 0.0 ? length : 1.0), incidence = ahead * n0 + up * n2;
        chi = chi > 1e-300 ? chi : 1e-300;
        block->chi[i] = chi < 1.0 ? chi : 1.0;
        block->incidence[i] = incidence > 0.0 ? incidence : 0.0;
    }
}

/* Reflected light of the sky. */
INLINE void reflect(const skyshine_frame *frame, struct block_of *block)
{
    const double *weights = frame->sky;
    if (frame->bases == 1) {
        for (int i = 0; i < block->count; ++i) block->sky[i] = weights[(size_t)BASES * (size_t)block->material[i]];
        return;
    }
    const int32_t *material = block->material;
    const double *n0 = block->normal[0], *n1 = block->normal[1], *n2 = block->normal[2];
    double *sky = block->sky;
    const int fourth_degree = frame->bases > 7, count = block->count;
    INDEPENDENT
    for (int i = 0; i < count; ++i) {
        const int32_t w = BASES * material[i];
        const double x = n0[i], y = n1[i], z = n2[i], even = x * x - y * y, square = z * z;
        const double share = fourth_degree ? (((231 * square - 315) * square + 105) * square - 5) / 16 : ((35 * square - 30) * square + 3) / 8;
        double light = share * weights[w] + 0.28209479177387814 * weights[w + 1] + 0.32573500793527993 * (z * weights[w + 2] + x * weights[w + 3]);
        light += 0.07884789131313001 * (3 * square - 1) * weights[w + 4];
        sky[i] = light + 0.2731371076480198 * x * z * weights[w + 5] + 0.1365685538240099 * even * weights[w + 6];
    }
    if (!fourth_degree) return;
    INDEPENDENT
    for (int i = 0; i < count; ++i) {
        const int32_t w = BASES * material[i];
        const double x = n0[i], y = n1[i], z = n2[i], even = x * x - y * y, square = z * z;
        double light = -0.03526184897173477 / 8 * ((35 * square - 30) * square + 3) * weights[w + 7];
        light += -0.0557538786297741 / 2 * x * z * (7 * square - 3) * weights[w + 8] - 0.039423945656565 / 2 * even * (7 * square - 1) * weights[w + 9];
        light += -0.14751089748166088 / 2 * x * z * (x * x - 3 * y * y) * weights[w + 10];
        sky[i] += light - 0.026076488977049006 * (even * even - 4 * x * x * y * y) * weights[w + 11];
    }
}

/* Wavelengths at which light is bounded at 0 are added one by one. */
static void add_bounded(const skyshine_frame *frame, struct block_of *block)
{
    const size_t parts = sky_parts_of(&frame->tables->air);
    for (int i = 0; i < block->count; ++i) {
        double at[BASES] = {1.0};
        if (frame->bases > 1) sky_bases(&frame->tables->air, (double[]){block->normal[0][i], block->normal[1][i], block->normal[2][i]}, at);
        for (size_t b = 0; b < frame->bounded; ++b) {
            double light = 0.0;
            for (size_t k = 0; k < frame->bases; ++k) light += at[k] * frame->sky_bounded[b * BASES + k];
            block->sky[i] += frame->rho_bounded[(size_t)block->material[i] * parts + b] * fmax(light, 0.0);
        }
    }
}

/* (1), its terms in the order of the equations. */
INLINE void add_terms(const skyshine_frame *frame, const double *range, const struct block_of *block, double *radiance)
{
    const double *diffuse = frame->materials.diffuse, *specular = frame->materials.specular, *shininess = frame->materials.shininess;
    const double extinction = frame->extinction, ratio = frame->path_ratio;
    const int32_t *material = block->material;
    const double *chi = block->chi, *incidence = block->incidence, *sky = block->sky, *emitted = block->emitted;
    INDEPENDENT
    for (int i = 0; i < block->count; ++i) {
        const int32_t m = material[i];
        const double tau = exponential(-extinction * range[i]), shape = exponential(shininess[m] * logarithm(chi[i])) * specular[m];
        const double beam = incidence[i] * diffuse[m] + (incidence[i] > 0.0 ? shape : 0.0);
        radiance[i] = emitted[i] + ((sky[i] > 0.0 ? sky[i] : 0.0) + beam) * tau + ratio * (1.0 - tau);
    }
}

/* Radiances of a block; returns whether a value lies outside the tables. */
EACH_PROCESSOR static int compute(const skyshine_frame *frame, const skyshine_pixels *pixels, size_t from, struct block_of *block, double *radiance)
{
    const int32_t *in_band = frame->in_band, *in_surface = frame->in_surface;
    int outside = 0, missing = 0;
    INDEPENDENT
    for (int i = 0; i < block->count; ++i) {
        const int32_t code = pixels->material[from + (size_t)i], known = (code > 0) & (code < CODES);
        const int32_t material = in_band[known ? code : 0], surface = in_surface[known ? code : 0];
        outside |= material < 0;
        missing |= surface < 0;
        block->material[i] = material > 0 ? material : 0;
        block->surface[i] = surface > 0 ? surface : 0;
    }
    if (pixels->temperature) memcpy(block->kelvin, pixels->temperature + from, (size_t)block->count * sizeof(double));
    else outside |= missing | read_temperatures(frame, pixels, from, block);
    outside |= emit(frame, pixels->range + from, block);
    face(frame, pixels, from, block);
    reflect(frame, block);
    if (frame->bounded) add_bounded(frame, block);
    add_terms(frame, pixels->range + from, block, radiance + from);
    return outside;
}

/* Say which pixel of a block has a value outside. */
static _Noreturn void refuse(const skyshine_frame *frame, const skyshine_pixels *pixels, size_t from, size_t count)
{
    for (size_t i = from; i < from + count; ++i) {
        const struct grid *grids[] = {&frame->altitude, &frame->azimuth, &frame->slope, &frame->kelvin};
        const double *values[] = {pixels->surface_altitude, pixels->surface_azimuth, pixels->surface_slope, pixels->temperature};
        const int32_t code = pixels->material[i];
        if (code < 1 || code >= CODES || frame->in_band[code] < 0 || (!pixels->temperature && frame->in_surface[code] < 0))
            sky_fail("pixel %zu: material: found %d; allowed: a code of the file", i, (int)code);
        if (!(pixels->range[i] >= 0 && pixels->range[i] <= FARTHEST)) sky_fail("pixel %zu: range: found %g; allowed: 0 to %g", i, pixels->range[i], FARTHEST);
        for (size_t k = pixels->temperature ? 3 : 0; k < (pixels->temperature ? 4 : 3); ++k) {
            int32_t lower;
            double weight;
            if (locate(grids[k], values[k] + i, 1, &lower, &weight))
                sky_fail("pixel %zu: %s: found %g; allowed: %g to %g", i, grids[k]->name, values[k][i], grids[k]->first, grids[k]->last);
        }
    }
    sky_fail("a temperature of the tables lies outside those of the band, %g to %g", frame->kelvin.first, frame->kelvin.last);
}

skyshine_status skyshine_frame_radiance(const skyshine_frame *frame, const skyshine_pixels *pixels, size_t count, double *radiance, skyshine_error *error)
{
    struct call call;
    struct block_of block;
    sky_begin(&call, SKYSHINE_VALUE_ERROR);
    if (!setjmp(call.failed))
        for (size_t from = 0; from < count; from += BLOCK) {
            block.count = count - from < BLOCK ? (int)(count - from) : BLOCK;
            if (compute(frame, pixels, from, &block, radiance)) refuse(frame, pixels, from, (size_t)block.count);
        }
    return sky_end(&call, error);
}
