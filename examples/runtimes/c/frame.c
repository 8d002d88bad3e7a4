/* A frame of one observer, one source and one time: what its pixels share is resolved once. */
#include "frame.h"
#include "channels.h"
#include "vector_math.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS_LIMIT = 65536 };

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

/* Reflectance of each material at each wavelength. */
static double *reflectances(const skyshine_tables *tables)
{
    const struct array *array = sky_array_of(&tables->band, "reflectance_spectrum");
    const size_t count = array->axes[0].count * array->axes[1].count;
    double *rho = sky_allocate(count, sizeof *rho);
    for (size_t i = 0; i < count; ++i) rho[i] = array->values[i];
    return rho;
}

/* What each material emits through the air over each range, as a share of a black body. */
static void make_emission(skyshine_frame *frame, const double *place, size_t parts, const double *rho)
{
    const skyshine_tables *tables = frame->tables;
    double *extinction = sky_allocate(parts, sizeof *extinction), *weight = sky_allocate(parts, sizeof *weight);
    sky_extinction_by_wavelength(&tables->air, place, extinction);
    const struct array *shares = sky_array_of(&tables->band, "emission_share");
    make_grid(&frame->planck, &shares->axes[0]);
    const size_t nodes = (size_t)frame->planck.count, stride = nodes * CUBIC, materials = sky_array_of(&tables->band, "reflectance")->axes[0].count;
    frame->emission = sky_allocate(materials * PANELS * stride, sizeof(double));
    for (size_t m = 0; m < materials; ++m)
        for (size_t n = 0; n < nodes; ++n) {
            const size_t stored = n < shares->axes[0].count ? n : 0;
            for (size_t b = 0; b < parts; ++b) weight[b] = (1.0 - rho[m * parts + b]) * shares->values[stored * parts + b];
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
    double ground[2] = {0.0}, *weights = sky_allocate(BASES * parts, sizeof *weights), *beam = sky_allocate(parts, sizeof *beam);
    if (tables->air.tilted) sky_ground_of(tables, view->ground_material, view->ground_altitude, view->time, ground);
    frame->bases = sky_ambient_weights(&tables->air, place, tables->air.tilted, ground, parts, weights);
    frame->sky = sky_allocate(materials * BASES, sizeof(double));
    frame->sky_bounded = sky_allocate(BASES * parts, sizeof(double));
    frame->rho_bounded = sky_allocate(materials * parts, sizeof(double));
    frame->materials.diffuse = sky_allocate(materials, sizeof(double));
    sky_light_by_wavelength(&tables->air, "direct_radiance", place, beam);
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
    const size_t parts = sky_wavelengths_of(air);
    if (!isfinite(place[4])) sky_fail("heading: found %g, %g; allowed: finite numbers", view->centre_heading, view->source_heading);
    frame->tables = tables;
    frame->extinction = 5.5 / sky_quantity_at(air, "beta_star", place);
    frame->path_ratio = sky_path_ratio_at(air, place);
    frame->source_heading = view->source_heading;
    sine_and_cosine(view->source_elevation, &frame->sine, &frame->cosine);
    frame->elevation = view->centre_elevation;
    frame->heading = view->centre_heading;
    const double *rho = reflectances(tables);
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
