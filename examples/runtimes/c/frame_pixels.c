/* The pixels of a frame, in blocks, each step over a whole block, so that a compiler can use vector instructions. */
#include "frame.h"
#include "vector_math.h"

#include <math.h>
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

enum { BLOCK = 256 };
static const double FARTHEST = 4095.0; /* km */

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
    const size_t parts = sky_wavelengths_of(&frame->tables->air);
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
