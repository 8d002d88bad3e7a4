/* Equation (1) for pixels: each at the end of its own line of sight, or all with the air at the centre of their frame.
 *
 * Of its own line, a pixel's light is summed in the channels, with what materials emit and reflect of each; where light
 * in a channel falls below 0, which the bound of light by wavelength may cut, it is parted by wavelength. Of a frame's
 * line, light by wavelength is resolved once. */
#include "air.h"
#include "export.h"
#include "shade.h"

static const double WALL_EMISSIVITY = 0.95; /* of masonry, concrete and foliage in the thermal infrared */
static const double SHADED_SKY = 0.5;       /* open share of the sky above ground in the shade where nothing is said */
enum { BASES = HARMONICS + 1 }; /* weights of light: of a level face, of the harmonics */

/* What a call needs of one pixel after another. */
typedef struct {
    const SkyTables *tables;
    const SkyPixels *pixels;
    size_t materials;
    int shared; /* one line for all */
    int tilted; /* light of the face's own direction is read */
    Path path;
    SkyPlace sky;
    double path_ratio;
    double *level_thermal, *level_source, *face_thermal, *face_source, *beam; /* light in the channels; of harmonics alone */
    double *ground_spectrum, *part;
    double *depth, *through, *level, *face, *of_beam, *spectrum, *glow; /* by wavelength; `depth` over the line's range */
    double *bases; /* (BASES, wavelengths) of a frame's line: of the level face, of each harmonic */
    double *beam_of;  /* (materials) of the band: direct light of the frame's line that each reflects */
    double line_range;
    /* Of the pixel before, while nothing of it changes: the ground, and a frame's harmonics over it. */
    double ground_code, ground_altitude, ground_time, ground_kelvin, ground_emitted, bases_kelvin;
    void *shade;
} Work;

/* Directions of a block, its faces' weights of light. */
typedef struct {
    double incidence[BLOCK], log_chi[BLOCK], cosine[BLOCK]; /* of the slope */
    double weight[BASES][BLOCK];
} Faces;

/* Terms of a pixel; reflected light before the path to the observer, the path's radiance over its absorptance. */
typedef struct {
    double temperature, blackbody, thermal, path_ratio, sky, diffuse, specular, beta_star;
} Terms;

static size_t rows_of(const SkyTables *tables) {
    return path_size(tables) + 6 * tables->channel_row + most_parts(tables) + (7 + BASES) * tables->wavelength_row + row_of(tables->materials);
}

size_t SKYSHINE_NAME(skyshine_pixel_scratch)(const SkyTables *tables);
SKYSHINE_EXPORT size_t SKYSHINE_NAME(skyshine_pixel_scratch)(const SkyTables *tables) {
    return rows_of(tables) * sizeof(double) + SKYSHINE_NAME(skyshine_shade_scratch)(tables);
}

static void set_rows(Work *work, double *rows) {
    const SkyTables *tables = work->tables;
    double **const channels[] = {&work->level_thermal, &work->level_source, &work->face_thermal, &work->face_source, &work->beam, &work->ground_spectrum};
    double **const wavelengths[] = {&work->depth, &work->through, &work->face, &work->of_beam, &work->spectrum, &work->glow};
    set_path(tables, &work->path, rows);
    rows += path_size(tables);
    for (int k = 0; k < 6; k++, rows += tables->channel_row) *channels[k] = rows;
    work->part = rows;
    rows += most_parts(tables);
    for (int k = 0; k < 6; k++, rows += tables->wavelength_row) *wavelengths[k] = rows;
    rows += tables->wavelength_row; /* `glow` is two rows, of which `optical_depths` needs both */
    work->level = work->bases = rows;
    work->beam_of = rows + BASES * tables->wavelength_row;
    work->shade = work->beam_of + row_of(tables->materials);
}

/* ---- Directions ---- */

/* A direction of a block: those given, to unit length, or of elevations and headings. */
static int32_t take_direction(const char *name, const double *given, size_t from, size_t count, const double *elevation,
                              const double *heading, double sign, double (*to)[BLOCK], SkyFailure *failure) {
    for (size_t i = 0; i < BLOCK && given; i++)
        for (int k = 0; k < 3; k++) to[k][i] = given[3 * (from + (i < count ? i : count - 1)) + k];
    for (size_t i = 0; i < BLOCK; i += DOUBLES) {
        VectorD x, y, z;
        if (given) {
            x = load_d(to[0] + i), y = load_d(to[1] + i), z = load_d(to[2] + i);
            VectorD length = root_d(x * x + y * y + z * z);
            x /= length, y /= length, z /= length;
        } else {
            VectorD rise, level, sine, cosine;
            sine_and_cosine_d(load_d(elevation + i), &rise, &level);
            sine_and_cosine_d(load_d(heading + i), &sine, &cosine);
            x = sign * level * sine, y = sign * level * cosine, z = sign * rise;
        }
        store_d(to[0] + i, x), store_d(to[1] + i, y), store_d(to[2] + i, z);
    }
    for (size_t i = 0; i < count; i++)
        if (!is_finite(to[0][i] + to[1][i] + to[2][i]))
            return refuse(failure, SKY_DIRECTION, SKY_AIR, from + i, name, NOT_A_NUMBER, 0, 0);
    return SKY_OK;
}

/* Weights of the level light and of the harmonics in the light on faces with a unit normal in the frame of the source:
 * S(normal) + (level - S(up)) P(cosine of slope), A_l / pi times Y_lm in S (Ramamoorthi and Hanrahan 2001). */
static void weigh_faces(const SkyTables *tables, double (*normal)[BLOCK], Faces *faces) {
    static const double UPRIGHT[HARMONICS] = {0.28209479177387814, 0.32573500793527993, 0, 0.15769578262626002, 0, 0,
                                              -0.03526184897173477, 0, 0, 0, 0};
    int second_degree = tables->harmonics == 6;
    for (size_t i = 0; i < BLOCK; i += DOUBLES) {
        VectorD x = load_d(normal[0] + i), y = load_d(normal[1] + i), z = load_d(normal[2] + i), even = x * x - y * y, square = z * z;
        VectorD share = second_degree ? ((35 * square - 30) * square + 3) / 8 : (((231 * square - 315) * square + 105) * square - 5) / 16;
        VectorD at[HARMONICS] = {
            all_d(0.28209479177387814),
            0.32573500793527993 * z,
            0.32573500793527993 * x,
            0.15769578262626002 * (3 * square - 1) / 2,
            0.2731371076480198 * x * z,
            0.1365685538240099 * even,
            -0.03526184897173477 * ((35 * square - 30) * square + 3) / 8,
            -0.0557538786297741 * x * z * (7 * square - 3) / 2,
            -0.039423945656565 * even * (7 * square - 1) / 2,
            -0.14751089748166088 * x * z * (x * x - 3 * y * y) / 2,
            -0.026076488977049006 * (even * even - 4 * x * x * y * y),
        };
        store_d(faces->weight[0] + i, share);
        for (size_t h = 0; h < HARMONICS; h++) store_d(faces->weight[h + 1] + i, at[h] - UPRIGHT[h] * share);
    }
}

/* Normals of faces of a block: x towards the source, from which azimuths count, z up. */
static void face_normals(const double *slope, const double *azimuth, double (*normal)[BLOCK]) {
    for (size_t i = 0; i < BLOCK; i += DOUBLES) {
        VectorD sine, cosine, across, turn;
        sine_and_cosine_d(load_d(slope + i), &across, &cosine);
        sine_and_cosine_d(load_d(azimuth + i), &sine, &turn);
        store_d(normal[0] + i, across * turn), store_d(normal[1] + i, across * sine), store_d(normal[2] + i, cosine);
    }
}

static int32_t take_faces(Work *work, size_t from, size_t count, Faces *faces, SkyFailure *failure) {
    const SkyPixels *of = work->pixels;
    double normal[3][BLOCK], source[3][BLOCK], observer[3][BLOCK], slope[BLOCK], azimuth[BLOCK], heading[BLOCK], up[BLOCK], high[BLOCK];
    int lines = work->shared;
    spread(of->surface_slope, 0, from, count, slope);
    spread(of->surface_azimuth, 0, from, count, azimuth);
    spread(of->source_heading, lines, from, count, heading);
    for (size_t i = 0; i < BLOCK; i++) up[i] = 90 - slope[i];
    int32_t status = take_direction("normal", of->normal, from, count, up, azimuth, 1, normal, failure);
    spread(of->source_elevation, lines, from, count, high);
    if (!status) status = take_direction("to_source", of->to_source, from, count, high, heading, 1, source, failure);
    double sight[BLOCK], along[BLOCK];
    spread(of->sight_elevation ? of->sight_elevation : of->elevation, !of->sight_elevation && lines, from, count, sight);
    spread(of->sight_heading ? of->sight_heading : of->source_azimuth, !of->sight_heading && lines, from, count, along);
    for (size_t i = 0; i < BLOCK && !of->sight_heading; i++) along[i] = heading[i] - along[i];
    if (!status) status = take_direction("to_observer", of->to_observer, from, count, sight, along, -1, observer, failure);
    if (status) return status;
    for (size_t i = 0; i < BLOCK; i += DOUBLES) {
        VectorD length = all_d(0), along_normal = all_d(0), incidence = all_d(0), unused, cosine;
        for (int k = 0; k < 3; k++) {
            VectorD n = load_d(normal[k] + i), s = load_d(source[k] + i), between = s + load_d(observer[k] + i);
            length += between * between;
            along_normal += between * n;
            incidence += s * n;
        }
        VectorD chi = select_d(length > all_d(0), along_normal / root_d(length), all_d(0));
        store_d(faces->log_chi + i, logarithm_d(smaller_d(larger_d(chi, all_d(1e-300)), all_d(1))));
        store_d(faces->incidence + i, larger_d(incidence, all_d(0)));
        sine_and_cosine_d(load_d(slope + i), &unused, &cosine);
        store_d(faces->cosine + i, cosine);
    }
    for (size_t h = 0; h < BASES; h++)
        for (size_t i = 0; i < BLOCK; i++) faces->weight[h][i] = h == 0;
    if (!work->tilted) return SKY_OK;
    for (size_t i = 0; i < BLOCK; i++) azimuth[i] -= heading[i];
    face_normals(slope, azimuth, normal);
    weigh_faces(work->tables, normal, faces);
    return SKY_OK;
}

/* ---- The ground ---- */

/* Temperature of the ground around a pixel and what it emits in the band; as before where nothing of it changed. */
static int32_t take_ground(Work *work, size_t row, SkyFailure *failure) {
    const SkyPixels *of = work->pixels;
    const SkyDatabase *surface = &work->tables->surface, *air = &work->tables->air;
    const Axis *axes = surface->arrays[TEMPERATURE].axes;
    double given = of->ground_temperature ? of->ground_temperature[row] : NOT_A_NUMBER, time = of->time[row];
    double code = of->ground_material && of->ground_material[row] ? of->ground_material[row] : air->numbers[SKY_GROUND_CODE];
    double altitude = of->ground_material && of->ground_material[row] ? of->surface_altitude[row] : axes[1].nodes[0];
    if (given == given) code = -1, altitude = given, time = 0;
    else if (code != code) code = -2, altitude = time = 0; /* as the file states it */
    if (code == work->ground_code && altitude == work->ground_altitude && time == work->ground_time) return SKY_OK;
    double kelvin = given;
    if (code == 0 || (code == -2 && !is_finite(air->numbers[SKY_GROUND_TEMPERATURE])))
        return refuse(failure, SKY_NO_GROUND, SKY_AIR, row, code == 0 ? "ground_material" : "ground_temperature", code, 0, 0);
    if (code == -2) kelvin = air->numbers[SKY_GROUND_TEMPERATURE];
    if (code > 0) {
        double place[] = {code, altitude, axes[2].nodes[0], axes[3].count > 1 ? 0 : axes[3].nodes[0], time};
        int32_t status = read_array(surface, TEMPERATURE, place, row, &kelvin, failure);
        if (status) return status;
    }
    work->ground_emitted = air->numbers[SKY_GROUND_RADIANCE];
    if (code != -2) {
        int32_t status = read_array(&work->tables->band, BLACKBODY, &kelvin, row, &work->ground_emitted, failure);
        if (status) return status;
        work->ground_emitted *= air->numbers[SKY_GROUND_EMISSIVITY];
    }
    work->ground_code = code, work->ground_altitude = altitude, work->ground_time = time;
    work->ground_kelvin = kelvin;
    return work->tilted ? ground_spectrum(work->tables, kelvin, row, work->ground_spectrum, failure) : SKY_OK;
}

/* ---- Light ---- */

/* Light of harmonics with weights, in the channels, before the path weighs it. */
static void face_light(Work *work, const double *weights, double *thermal, double *source) {
    const SkyTables *tables = work->tables;
    static const size_t ZONAL_OF[ZONAL] = {0, 1, 3, 6};
    double zonal[ZONAL];
    add_sky(tables, &tables->thermal_harmonics, &tables->scattered_harmonics, &work->sky, weights, work->part, thermal, source);
    for (size_t z = 0; z < tables->zonal; z++) zonal[z] = weights[ZONAL_OF[z]];
    light_parts(&tables->ground_harmonics, work->sky.height_corner, work->sky.height_weight, 2, zonal, work->part);
    add_channels(tables, &tables->ground_harmonics, work->part, work->ground_emitted, work->ground_spectrum, thermal);
}

/* The air along a line and the light at its end, in the channels. */
static int32_t take_line(Work *work, const Lines *lines, size_t i, size_t line, size_t row, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    const SkyPixels *of = work->pixels;
    const double level[HARMONICS] = {1}, *numbers = tables->air.numbers;
    double source = of->source_elevation[line], azimuth = of->source_azimuth[line];
    work->line_range = larger(of->line_range[line], SHORTEST_KM);
    if (!is_finite(azimuth)) return refuse(failure, SKY_OUTSIDE, SKY_AIR, row, "source_azimuth", azimuth, 0, 180);
    int32_t status = take_path(tables, lines, i, clipped(of->line_range[line], numbers[SKY_RANGE_FIRST], numbers[SKY_RANGE_LAST]), row, &work->path, failure);
    if (!status) status = place_sky(tables, &work->path, source, row, &work->sky, failure);
    if (status) return status;
    double entered = source_at_entry(lines->turn[i], source, azimuth);
    status = path_ratio(tables, &work->path, entered, lines->angle[i], row, &work->path_ratio, failure);
    if (status) return status;
    clear(work->level_thermal, 5 * tables->channel_row); /* and all behind it */
    status = add_direct(tables, &work->path, source, row, work->part, work->beam, failure);
    add_sky(tables, &tables->thermal_sky, &tables->scattered_sky, &work->sky, level, work->part, work->level_thermal, work->level_source);
    weigh(tables, &work->path, work->level_thermal);
    weigh(tables, &work->path, work->level_source);
    weigh(tables, &work->path, work->beam);
    return status;
}

static void by_wavelength(const Work *work, const double *thermal, const double *source, double *to) {
    clear(to, work->tables->wavelength_row);
    add_wavelengths(work->tables, thermal, work->tables->thermal_share, to);
    add_wavelengths(work->tables, source, work->tables->source_share, to);
}

/* Lines of a block, with their angles from the source. */
static int32_t take_block(const Work *work, size_t from, size_t count, Lines *lines, SkyFailure *failure) {
    const SkyPixels *of = work->pixels;
    double source[BLOCK], azimuth[BLOCK];
    int32_t status = take_lines(work->tables, count, of->line_range + from, of->altitude + from, of->elevation + from, from, lines, failure);
    if (status) return status;
    spread(of->source_elevation, 0, from, count, source);
    spread(of->source_azimuth, 0, from, count, azimuth);
    scattering_angles(lines->looked, source, azimuth, lines->angle);
    return SKY_OK;
}

/* The line of a frame, by wavelength. */
static int32_t take_frame(Work *work, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    Lines lines;
    int32_t status = take_block(work, 0, 1, &lines, failure);
    if (!status) status = take_line(work, &lines, 0, 0, 0, failure);
    if (status) return status;
    optical_depths(tables, &work->path, work->glow, work->depth);
    by_wavelength(work, work->level_thermal, work->level_source, work->level);
    bound_at_zero(work->level, tables->wavelength_row);
    clear(work->of_beam, tables->wavelength_row);
    add_wavelengths(tables, work->beam, tables->source_share, work->of_beam);
    bound_at_zero(work->of_beam, tables->wavelength_row);
    for (size_t m = 0; m < tables->materials; m++)
        work->beam_of[m] = dot(tables->reflectance + m * tables->wavelength_row, work->of_beam, tables->wavelength_row);
    return SKY_OK;
}

/* A frame's harmonics by wavelength, over the ground of the pixel. */
static void take_bases(Work *work) {
    const SkyTables *tables = work->tables;
    if (work->bases_kelvin == work->ground_kelvin) return;
    work->bases_kelvin = work->ground_kelvin;
    for (size_t h = 0; h < tables->harmonics; h++) {
        double weights[HARMONICS] = {0};
        weights[h] = 1;
        clear(work->face_thermal, 2 * tables->channel_row);
        face_light(work, weights, work->face_thermal, work->face_source);
        weigh(tables, &work->path, work->face_thermal);
        weigh(tables, &work->path, work->face_source);
        by_wavelength(work, work->face_thermal, work->face_source, work->bases + (h + 1) * tables->wavelength_row);
    }
}

/* What a pixel sees and is lit by. */
typedef struct {
    size_t row, i;
    const Faces *faces;
    double hidden;          /* share of the light of a level face that a wall replaces */
    double wall, shade;     /* the wall's temperature; share in the shade */
    double lit, stretch;    /* the pixel's range over that of the line */
    int emits, sky, beam;   /* sums of emission, of light of the sky and of the source are over channels, not wavelengths */
    Terms *terms;
} Pixel;

/* Nodes of a temperature in the band's tables: of black bodies, and of their spectra. */
typedef struct {
    double radiance;
    Place planck;
} Glow;

static int32_t take_glow(const SkyTables *tables, double kelvin, size_t row, Glow *glow, SkyFailure *failure) {
    int32_t status = read_array(&tables->band, BLACKBODY, &kelvin, row, &glow->radiance, failure);
    return status ? status : find(&tables->band.arrays[EMISSION_SHARE].axes[0], kelvin, SKY_BAND, row, &glow->planck, failure);
}

/* Radiance by wavelength of black bodies beside the pixel, over the transmittance of the line, times `by`: added to `to`. */
static int32_t add_glow(Work *work, double kelvin, double by, size_t row, double *to, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    Glow glow;
    int32_t status = take_glow(tables, kelvin, row, &glow, failure);
    if (status) return status;
    const double *below = tables->emission + glow.planck.lower * tables->wavelength_row;
    const double *above = tables->emission + glow.planck.upper * tables->wavelength_row;
    double tau = exponential(-BETA_FACTOR * work->line_range / work->path.beta_star), scale = tau > 0 ? by * glow.radiance / tau : 0;
    for (size_t b = 0; b < tables->wavelength_row; b += DOUBLES) {
        VectorD share = (1 - glow.planck.weight) * load_d(below + b) + glow.planck.weight * load_d(above + b);
        store_d(to + b, load_d(to + b) + scale * share * exp_d(-load_d(work->depth + b)));
    }
    return status;
}

/* Light of the sky on the pixel's face by wavelength, with what walls hide. */
static int32_t take_sky(Work *work, const Pixel *pixel, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    size_t row = tables->wavelength_row;
    double weights[BASES];
    for (size_t h = 0; h < BASES; h++) weights[h] = pixel->faces->weight[h][pixel->i];
    if (!work->shared) {
        by_wavelength(work, work->level_thermal, work->level_source, work->level);
        bound_at_zero(work->level, row);
        if (work->tilted) by_wavelength(work, work->face_thermal, work->face_source, work->face);
        else clear(work->face, row);
        for (size_t b = 0; b < row; b++) work->face[b] += weights[0] * work->level[b];
    } else {
        clear(work->face, row);
        add_rows(work->bases, work->tilted ? 1 + tables->harmonics : 1, row, weights, 1, 0, work->face);
    }
    bound_at_zero(work->face, row);
    if (!(pixel->hidden > 0)) return SKY_OK;
    double mirrored = 0.5 * (1 - WALL_EMISSIVITY);
    for (size_t b = 0; b < row; b++) work->face[b] += pixel->hidden * (mirrored - 1) * work->level[b];
    int32_t status = add_glow(work, pixel->wall, pixel->hidden * WALL_EMISSIVITY, pixel->row, work->face, failure);
    if (!status) status = add_glow(work, work->ground_kelvin, pixel->hidden * mirrored, pixel->row, work->face, failure);
    bound_at_zero(work->face, row);
    return status;
}

static int any_of(BitsD bits) {
    int64_t any = 0;
    for (int h = 0; h < DOUBLES; h++) any |= bits[h];
    return any != 0;
}

/* Whether no light of the source, or of the sky, is below 0 in a channel, so that none is by wavelength. */
static int bright_beam(const Work *work) {
    BitsD below = (BitsD){0};
    for (size_t j = 0; j < work->tables->channel_row; j += DOUBLES) below |= load_d(work->beam + j) < all_d(0);
    return !any_of(below);
}

static int bright_sky(const Work *work, const Pixel *pixel) {
    const SkyTables *tables = work->tables;
    double level = pixel->faces->weight[0][pixel->i], rest = level - pixel->hidden * (1 - 0.5 * (1 - WALL_EMISSIVITY));
    BitsD below = (BitsD){0};
    for (size_t j = 0; j < tables->channel_row; j += DOUBLES) {
        VectorD thermal = load_d(work->level_thermal + j), source = load_d(work->level_source + j), none = all_d(0);
        VectorD face = load_d(work->face_thermal + j), lit = load_d(work->face_source + j);
        below |= (thermal < none) | (source < none) | (face + level * thermal < none) | (lit + level * source < none);
        below |= (face + rest * thermal < none) | (lit + rest * source < none);
    }
    return !any_of(below);
}

/* ---- Materials ---- */

/* A share of the pixel that emits at a temperature: (5). */
static int32_t add_emission(Work *work, const Pixel *pixel, size_t m, double share, double kelvin, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    Glow glow;
    double emitted;
    int32_t status = take_glow(tables, kelvin, pixel->row, &glow, failure);
    if (status) return status;
    double low = 1 - glow.planck.weight, high = glow.planck.weight;
    if (pixel->emits) {
        const double *below = tables->emits + (m * tables->planck + glow.planck.lower) * tables->channel_row;
        const double *above = tables->emits + (m * tables->planck + glow.planck.upper) * tables->channel_row;
        const double *dark = tables->emits_dark + m * tables->planck;
        double scale = work->path.shift > 0 ? exponential(-work->path.shift) : 1, rest = low * dark[glow.planck.lower] + high * dark[glow.planck.upper];
        emitted = scale * (low * dot(below, work->path.through, tables->channel_row) + high * dot(above, work->path.through, tables->channel_row));
        if (rest > 0) emitted += rest * exponential(work->path.log_tau);
    } else {
        const double *below = tables->emission + glow.planck.lower * tables->wavelength_row;
        const double *above = tables->emission + glow.planck.upper * tables->wavelength_row;
        const double *rho = tables->reflectance + m * tables->wavelength_row;
        for (size_t b = 0; b < tables->wavelength_row; b += DOUBLES)
            store_d(work->spectrum + b, (1 - load_d(rho + b)) * (low * load_d(below + b) + high * load_d(above + b)));
        emitted = dot(work->spectrum, work->through, tables->wavelength_row);
    }
    pixel->terms->temperature += share * kelvin;
    pixel->terms->blackbody += share * glow.radiance; /* (7) */
    pixel->terms->thermal += share * glow.radiance * emitted;
    return SKY_OK;
}

/* Light of the sky and of the source that a material reflects. */
static int32_t reflected(Work *work, const Pixel *pixel, size_t m, double *sky, double *beam, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    size_t row = tables->channel_row;
    const double *thermal = tables->reflects_thermal + m * row, *source = tables->reflects_source + m * row;
    const double *rho = tables->reflectance + m * tables->wavelength_row;
    double level = pixel->faces->weight[0][pixel->i], mirrored = 0.5 * (1 - WALL_EMISSIVITY);
    if (work->shared) *beam = work->beam_of[m];
    else *beam = pixel->beam ? dot(source, work->beam, row) : dot(rho, work->of_beam, tables->wavelength_row);
    if (!pixel->sky) {
        *sky = dot(rho, work->face, tables->wavelength_row);
        return SKY_OK;
    }
    level -= pixel->hidden * (1 - mirrored);
    *sky = level * (dot(thermal, work->level_thermal, row) + dot(source, work->level_source, row));
    if (work->tilted) *sky += dot(thermal, work->face_thermal, row) + dot(source, work->face_source, row);
    if (!(pixel->hidden > 0)) return SKY_OK;
    /* Of what black bodies emit, a material reflects what it does not emit itself. */
    double tau = exponential(-BETA_FACTOR * work->line_range / work->path.beta_star), scale = exponential(-work->path.shift);
    for (int of_ground = 0; of_ground < 2; of_ground++) {
        Glow glow;
        int32_t status = take_glow(tables, of_ground ? work->ground_kelvin : pixel->wall, pixel->row, &glow, failure);
        if (status) return status;
        double shine = 0, part = of_ground ? mirrored : WALL_EMISSIVITY;
        for (int upper = 0; upper < 2; upper++) {
            size_t n = upper ? glow.planck.upper : glow.planck.lower, at = m * tables->planck + n;
            double weight = upper ? glow.planck.weight : 1 - glow.planck.weight;
            double all = dot(tables->glows + n * row, work->path.through, row), own = dot(tables->emits + at * row, work->path.through, row);
            shine += weight * (scale * (all - own) + (tables->glows_dark[n] - tables->emits_dark[at]) * exponential(work->path.log_tau));
        }
        *sky += tau > 0 ? pixel->hidden * part * glow.radiance * shine / tau : 0;
    }
    return SKY_OK;
}

/* A material of the pixel, its share of all terms. */
static int32_t add_material(Work *work, const Pixel *pixel, size_t part, double share, double under, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    const SkyPixels *of = work->pixels;
    const SkyDatabase *band = &tables->band;
    size_t row = pixel->row, at = row * work->materials + part;
    double code = of->material[at], sky, beam, kelvin = of->temperature ? of->temperature[at] : NOT_A_NUMBER;
    double face[] = {code, of->surface_altitude[row], of->surface_azimuth[row], of->surface_slope[row], of->time[row]};
    Place place;
    int32_t status = find(&band->arrays[REFLECTANCE].axes[0], code, SKY_BAND, row, &place, failure);
    if (!status && kelvin != kelvin) status = read_array(&tables->surface, TEMPERATURE, face, row, &kelvin, failure);
    if (!status) status = add_emission(work, pixel, place.lower, share * (1 - pixel->shade), kelvin, failure);
    if (!status && pixel->shade > 0) {
        double shaded = of->shaded_temperature ? of->shaded_temperature[at] : NOT_A_NUMBER;
        if (shaded != shaded) status = SKYSHINE_NAME(skyshine_shaded)(tables, face, under, row, &shaded, work->shade, failure);
        if (!status) status = add_emission(work, pixel, place.lower, share * pixel->shade, shaded, failure);
    }
    if (!status) status = reflected(work, pixel, place.lower, &sky, &beam, failure);
    if (status) return status;
    double fraction = band->arrays[SPECULAR_FRACTION].values[place.lower], shininess = band->arrays[SHININESS].values[place.lower];
    double incidence = pixel->faces->incidence[pixel->i];
    double direct = incidence > 0 ? larger(beam, 0) * pixel->lit : 0;
    pixel->terms->sky += share * larger(sky, 0);                        /* (18) */
    pixel->terms->diffuse += share * direct * incidence * (1 - fraction); /* (34) */
    if (direct == 0) return SKY_OK;
    double lobe = exponential(shininess * pixel->faces->log_chi[pixel->i]); /* (37), (38) */
    pixel->terms->specular += share * direct * lobe * fraction * band->arrays[NORMALISATION].values[place.lower]; /* (35) */
    return SKY_OK;
}

static int32_t share_of(const double *list, double otherwise, const char *name, size_t row, double *share, SkyFailure *failure) {
    *share = list ? list[row] : otherwise;
    if (*share >= 0 && *share <= 1) return SKY_OK;
    return refuse(failure, SKY_SHARE, SKY_AIR, row, name, *share, 0, 1);
}

/* What hides the sky and the source: `under` is the open share of the sky above what is in the shade. */
static int32_t take_surroundings(Work *work, Pixel *pixel, double *under, SkyFailure *failure) {
    const SkyPixels *of = work->pixels;
    const SkyDatabase *surface = &work->tables->surface;
    size_t row = pixel->row;
    double own, below;
    int32_t status = share_of(of->shade, 0, "shade", row, &pixel->shade, failure);
    if (!status) status = share_of(of->sky_view, 1, "sky_view", row, &own, failure);
    if (!status) status = pixel->shade > 0 ? share_of(of->shaded_sky, SHADED_SKY, "shaded_sky", row, &below, failure) : SKY_OK;
    if (status) return status;
    *under = pixel->shade > 0 ? smaller(own, below) : own;
    double view = own - pixel->shade * (own - *under);
    pixel->lit = (1 - pixel->shade) * (of->lit ? of->lit[row] : 1);
    pixel->hidden = view < 1 ? (1 - view) * 0.5 * (1 + pixel->faces->cosine[pixel->i]) : 0;
    pixel->wall = of->wall_temperature ? of->wall_temperature[row] : NOT_A_NUMBER;
    if (!(pixel->hidden > 0) || pixel->wall == pixel->wall) return SKY_OK;
    if (!surface->arrays[AIR_TEMPERATURE].values) return refuse(failure, SKY_NO_RESPONSE, SKY_SURFACE, row, "response_kernel", 0, 0, 0);
    double place[] = {bounded(&surface->arrays[AIR_TEMPERATURE].axes[0], of->surface_altitude[row]), of->time[row]};
    return read_array(surface, AIR_TEMPERATURE, place, row, &pixel->wall, failure);
}

/* Light and transmittance of the pixel: in the channels where that will do, else by wavelength. Without harmonics those of
 * the face stay 0, as `take_line` leaves them. */
static int32_t take_light(Work *work, Pixel *pixel, SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    double weights[HARMONICS];
    if (work->tilted || pixel->hidden > 0) {
        int32_t status = take_ground(work, pixel->row, failure);
        if (status) return status;
    }
    if (work->shared) {
        if (work->tilted) take_bases(work);
    } else {
        if (work->tilted) {
            clear(work->face_thermal, 2 * tables->channel_row);
            for (size_t h = 0; h < HARMONICS; h++) weights[h] = pixel->faces->weight[h + 1][pixel->i];
            face_light(work, weights, work->face_thermal, work->face_source);
            weigh(tables, &work->path, work->face_thermal);
            weigh(tables, &work->path, work->face_source);
        }
        pixel->emits = pixel->stretch == 1;
        pixel->sky = bright_sky(work, pixel);
        pixel->beam = !(pixel->faces->incidence[pixel->i] > 0) || bright_beam(work);
        if (!pixel->beam) {
            clear(work->of_beam, tables->wavelength_row);
            add_wavelengths(tables, work->beam, tables->source_share, work->of_beam);
            bound_at_zero(work->of_beam, tables->wavelength_row);
        }
        if (!pixel->emits || (!pixel->sky && pixel->hidden > 0)) optical_depths(tables, &work->path, work->glow, work->depth);
    }
    VectorD stretch = all_d(pixel->stretch);
    for (size_t b = 0; b < tables->wavelength_row && !pixel->emits; b += DOUBLES)
        store_d(work->through + b, exp_d(-load_d(work->depth + b) * stretch));
    return pixel->sky ? SKY_OK : take_sky(work, pixel, failure);
}

static int32_t pixel_of(Work *work, const Lines *lines, const Faces *faces, size_t from, size_t i, Terms *terms, SkyFailure *failure) {
    const SkyPixels *of = work->pixels;
    size_t row = from + i, used = 0;
    double range = of->range[row], under;
    Pixel pixel = {.row = row, .i = i, .faces = faces, .terms = terms};
    int32_t status = work->shared ? SKY_OK : take_line(work, lines, i, row, row, failure);
    if (status) return status;
    if (!(is_finite(range) && range >= 0)) return refuse(failure, SKY_LENGTH, SKY_AIR, row, "range", range, 0, INFINITE);
    *terms = (Terms){.path_ratio = work->path_ratio, .beta_star = work->path.beta_star};
    pixel.stretch = range == of->line_range[work->shared ? 0 : row] ? 1 : range / work->line_range;
    status = take_surroundings(work, &pixel, &under, failure);
    if (!status) status = take_light(work, &pixel, failure);
    for (size_t part = 0; part < work->materials && !status; part++) {
        size_t at = row * work->materials + part;
        double share = of->share ? of->share[at] : part == 0;
        if (share <= 0) continue;
        used++;
        if (!of->material[at]) return refuse(failure, SKY_NO_MATERIAL, SKY_BAND, row, "material", 0, 0, 0);
        status = add_material(work, &pixel, part, share, under, failure);
    }
    if (!status && !used) return refuse(failure, SKY_NO_MATERIAL, SKY_BAND, row, "material", 0, 0, 0);
    return status;
}

/* Put the path in front of the pixels of a block. */
static void write_terms(const SkyTerms *to, const double *range, size_t from, size_t count, const Terms *terms) {
    double *const columns[] = {to->temperature, to->blackbody_radiance, to->beta_star, to->transmittance, to->thermal,
                               to->path, to->skyshine, to->diffuse, to->specular, to->radiance};
    double depth[BLOCK] = {0}, tau[BLOCK], absorbed[BLOCK];
    for (size_t i = 0; i < count; i++) depth[i] = BETA_FACTOR * range[from + i] / terms[i].beta_star;
    for (size_t i = 0; i < BLOCK; i += DOUBLES) {
        VectorD through, rest;
        attenuation_d(load_d(depth + i), &through, &rest); /* (9) */
        store_d(tau + i, through), store_d(absorbed + i, rest);
    }
    for (size_t i = 0; i < count; i++) {
        const Terms *of = &terms[i];
        double path = of->path_ratio * absorbed[i], sky = of->sky * tau[i], diffuse = of->diffuse * tau[i], specular = of->specular * tau[i]; /* (11) */
        const double values[] = {of->temperature, of->blackbody, of->beta_star, tau[i], of->thermal, path, sky, diffuse, specular,
                                 of->thermal + path + sky + diffuse + specular}; /* (1) */
        for (int k = 0; k < 10; k++)
            if (columns[k]) columns[k][from + i] = values[k];
    }
}

int32_t SKYSHINE_NAME(skyshine_pixel_terms)(const SkyTables *tables, size_t count, size_t materials, size_t lines, const SkyPixels *pixels,
                                       const SkyTerms *terms, void *scratch, SkyFailure *failure);
SKYSHINE_EXPORT int32_t SKYSHINE_NAME(skyshine_pixel_terms)(const SkyTables *tables, size_t count, size_t materials, size_t lines, const SkyPixels *pixels,
                                       const SkyTerms *terms, void *scratch, SkyFailure *failure) {
    Work work = {.tables = tables, .pixels = pixels, .materials = materials, .shared = lines == 1,
                 .tilted = tables->tilted && pixels->source_heading, .ground_code = NOT_A_NUMBER, .bases_kelvin = NOT_A_NUMBER};
    Lines of;
    Faces faces;
    Terms computed[BLOCK];
    if (!tables->surface.arrays[TEMPERATURE].values) return refuse(failure, SKY_LACKS, SKY_SURFACE, 0, "temperature", 0, 0, 0);
    if (!pixels->source_heading && (!pixels->to_source || (!pixels->to_observer && !pixels->sight_heading)))
        return refuse(failure, SKY_DIRECTION, SKY_AIR, 0, pixels->to_source ? "to_observer" : "to_source", NOT_A_NUMBER, 0, 0);
    set_rows(&work, scratch);
    int32_t status = work.shared && count ? take_frame(&work, failure) : SKY_OK;
    for (size_t from = 0; from < count && !status; from += BLOCK) {
        size_t number = count - from < BLOCK ? count - from : BLOCK;
        if (!work.shared) status = take_block(&work, from, number, &of, failure);
        if (!status) status = take_faces(&work, from, number, &faces, failure);
        for (size_t i = 0; i < number && !status; i++) status = pixel_of(&work, &of, &faces, from, i, computed + i, failure);
        if (!status) write_terms(terms, pixels->range, from, number, computed);
    }
    return status;
}

/* ---- Light on faces ---- */

/* The air along a line and the light of the sky on a face at its end, in the channels. */
static int32_t face_at(Work *work, const Lines *lines, size_t i, const SkyPlaces *places, double kelvin, const double *weights, size_t row,
                       SkyFailure *failure) {
    const SkyTables *tables = work->tables;
    const SkyDatabase *air = &tables->air;
    const double level[HARMONICS] = {1};
    double whole = clipped(places->range[row], air->numbers[SKY_RANGE_FIRST], air->numbers[SKY_RANGE_LAST]);
    int32_t status = take_path(tables, lines, i, whole, row, &work->path, failure);
    if (!status) status = place_sky(tables, &work->path, places->source_elevation[row], row, &work->sky, failure);
    if (status) return status;
    clear(work->level_thermal, 5 * tables->channel_row);
    add_sky(tables, &tables->thermal_sky, &tables->scattered_sky, &work->sky, level, work->part, work->level_thermal, work->level_source);
    weigh(tables, &work->path, work->level_thermal);
    weigh(tables, &work->path, work->level_source);
    if (!tables->tilted) return SKY_OK;
    work->ground_emitted = air->numbers[SKY_GROUND_RADIANCE];
    work->ground_kelvin = kelvin == kelvin ? kelvin : air->numbers[SKY_GROUND_TEMPERATURE];
    if (kelvin == kelvin) status = read_array(&tables->band, BLACKBODY, &kelvin, row, &work->ground_emitted, failure);
    if (kelvin == kelvin) work->ground_emitted *= air->numbers[SKY_GROUND_EMISSIVITY];
    if (!status) status = ground_spectrum(tables, work->ground_kelvin, row, work->ground_spectrum, failure);
    if (status) return status;
    face_light(work, weights + 1, work->face_thermal, work->face_source);
    weigh(tables, &work->path, work->face_thermal);
    weigh(tables, &work->path, work->face_source);
    return SKY_OK;
}

static double sum_of(const double *thermal, const double *source, size_t count) {
    double sum = 0;
    for (size_t j = 0; j < count; j++) sum += thermal[j] + source[j];
    return sum;
}

int32_t SKYSHINE_NAME(skyshine_ambient)(const SkyTables *tables, int32_t by_wavelength_too, size_t count, const SkyPlaces *places,
                                        const double *slope, const double *azimuth, const double *ground_temperature, double *values,
                                        void *scratch, SkyFailure *failure);
SKYSHINE_EXPORT int32_t SKYSHINE_NAME(skyshine_ambient)(const SkyTables *tables, int32_t by_wavelength_too, size_t count, const SkyPlaces *places,
                                        const double *slope, const double *azimuth, const double *ground_temperature, double *values,
                                        void *scratch, SkyFailure *failure) {
    Work work = {.tables = tables, .tilted = tables->tilted};
    Lines lines;
    Faces faces;
    double tilt[BLOCK], turn[BLOCK], normal[3][BLOCK], weights[BASES];
    set_rows(&work, scratch);
    for (size_t from = 0; from < count; from += BLOCK) {
        size_t number = count - from < BLOCK ? count - from : BLOCK;
        int32_t status = take_lines(tables, number, places->range + from, places->altitude + from, places->elevation + from, from, &lines, failure);
        spread(slope, 0, from, number, tilt);
        spread(azimuth, 0, from, number, turn);
        face_normals(tilt, turn, normal);
        weigh_faces(tables, normal, &faces);
        for (size_t i = 0; i < number && !status; i++) {
            size_t row = from + i;
            for (size_t h = 0; h < BASES; h++) weights[h] = tables->tilted ? faces.weight[h][i] : h == 0;
            if (!is_finite(tilt[i] + turn[i]) || (!tables->tilted && tilt[i] != 0))
                return refuse(failure, SKY_OUTSIDE, SKY_AIR, row, "slope", tilt[i], 0, tables->tilted ? 180 : 0);
            status = face_at(&work, &lines, i, places, ground_temperature ? ground_temperature[row] : NOT_A_NUMBER, weights, row, failure);
            if (status) return status;
            if (by_wavelength_too) {
                Pixel pixel = {.row = row, .i = i, .faces = &faces};
                for (size_t h = 0; h < BASES; h++) faces.weight[h][i] = weights[h];
                status = take_sky(&work, &pixel, failure);
                for (size_t b = 0; b < tables->wavelengths; b++) values[row * tables->wavelengths + b] = work.face[b];
            } else {
                double level = larger(sum_of(work.level_thermal, work.level_source, tables->channels), 0);
                values[row] = larger(weights[0] * level + sum_of(work.face_thermal, work.face_source, tables->channels), 0);
            }
        }
        if (status) return status;
    }
    return SKY_OK;
}
