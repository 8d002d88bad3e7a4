/* Reads one frame of `mat export --to gpu`: the radiance of pixels from its textures, without HDF5 and without a library.
 * Build: cc -std=c11 -O2 -o gpu gpu.c -lm     Usage: ./gpu AIR.gpu.json BAND.gpu.json < PIXELS
 * A line of PIXELS is a pixel: code of its material, temperature (K), range (km), then the unit vectors normal, to the
 * source and to the observer (east, north, up). A line of the result is its radiance, its path radiance
 * (W m^-2 sr^-1) and its apparent temperature (K). The steps are those of skyshine.glsl;
 * schemas/formats/gpu-1.md describes the files. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COMPONENTS = 16, TERMS = 12 };

struct axis { double *nodes; int count; };
struct cell { int lower, upper; double weight; };

struct frame {
    struct axis first, second, temperature, angle, material;
    int components, light;
    double height, rho, scale;
    double *air;    /* (second, first, components) */
    double *terms;  /* rows: emission, thermal path, path, sky, direct */
    double first_temperature, temperature_step;
    struct axis blackbody;
    double *surfaces; /* specular fraction, shininess, normalisation, reflectance of each material */
};

static void fail(const char *path, const char *words)
{
    fprintf(stderr, "%s: %s\n", path, words);
    exit(1);
}

static char *contents(const char *path, long *size)
{
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END)) fail(path, "cannot be read");
    *size = ftell(file);
    char *bytes = *size >= 0 ? malloc((size_t)*size + 1) : NULL;
    rewind(file);
    if (!bytes || fread(bytes, 1, (size_t)*size, file) != (size_t)*size) fail(path, "cannot be read");
    fclose(file);
    bytes[*size] = 0;
    return bytes;
}

/* What stands behind a key of a header, which writes no blanks before a colon. */
static const char *behind(const char *path, const char *from, const char *key)
{
    char wanted[64];
    snprintf(wanted, sizeof wanted, "\"%s\":", key);
    const char *found = strstr(from, wanted);
    if (!found) fail(path, "lacks a key of the format");
    return found + strlen(wanted) + strspn(found + strlen(wanted), " \n");
}

static struct axis list(const char *path, const char *at)
{
    struct axis axis = {malloc(sizeof(double)), 0};
    if (*at++ != '[') fail(path, "has no list where one must be");
    while (*at && *at != ']') {
        char *end;
        axis.nodes = realloc(axis.nodes, sizeof(double) * (size_t)(axis.count + 1));
        if (!axis.nodes) fail(path, "is too large");
        axis.nodes[axis.count++] = strtod(at, &end);
        if (end == at) fail(path, "has no number where one must be");
        at = end + strspn(end, ", ");
    }
    return axis;
}

static double half(uint16_t word)
{
    int exponent = word >> 10 & 31, fraction = word & 1023;
    double size = exponent ? ldexp(1.0 + fraction / 1024.0, exponent - 15) : ldexp(fraction, -24);
    return word & 0x8000 ? -size : size;
}

/* Numbers of a texture of half floats or of single precision. */
static double *texels(const char *path, const char *text, const char *bytes, long size, const char *name, long *count)
{
    const char *entry = behind(path, text, name);
    int channels = strncmp(behind(path, entry, "format"), "\"RGBA", 5) ? 1 : 4;
    int width = strstr(behind(path, entry, "format"), "16F") == behind(path, entry, "format") + (channels == 4 ? 5 : 2) ? 2 : 4;
    struct axis sizes = list(path, behind(path, entry, "size"));
    long offset = (long)strtod(behind(path, entry, "offset"), NULL);
    if (sizes.count != 3) fail(path, "holds a texture without three sizes");
    *count = (long)(sizes.nodes[0] * sizes.nodes[1] * sizes.nodes[2]) * channels;
    if (offset < 0 || *count <= 0 || *count > (size - offset) / width) fail(path, "holds a texture outside its data");
    double *values = malloc(sizeof(double) * (size_t)*count);
    if (!values) fail(path, "is too large");
    for (long k = 0; k < *count; ++k) {
        const unsigned char *at = (const unsigned char *)bytes + offset + k * width;
        uint32_t word = width == 2 ? (uint32_t)(at[0] | at[1] << 8)
                                   : at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
        float single;
        memcpy(&single, &word, sizeof single);
        values[k] = width == 2 ? half((uint16_t)word) : single;
    }
    free(sizes.nodes);
    return values;
}

/* Header and data of an export of a kind. */
static char *open_export(const char *path, const char *kind, char **bytes, long *size)
{
    long length;
    char *text = contents(path, &length), name[512], wanted[32];
    snprintf(wanted, sizeof wanted, "\"%s\"", kind);
    if (strncmp(behind(path, text, "format"), "\"skyshine-gpu\"", 14) || strncmp(behind(path, text, "format_version"), "\"1.", 3)
        || strncmp(behind(path, text, "kind"), wanted, strlen(wanted)))
        fail(path, "is no skyshine-gpu 1.x file of the kind that is wanted");
    const char *slash = strrchr(path, '/'), *file = behind(path, text, "data") + 1;
    int folder = slash ? (int)(slash - path + 1) : 0;
    snprintf(name, sizeof name, "%.*s%.*s", folder, path, (int)strcspn(file, "\""), file);
    *bytes = contents(name, size);
    if (*size != (long)strtod(behind(path, text, "bytes"), NULL)) fail(name, "has not the size that its header says");
    return text;
}

static struct cell locate(struct axis axis, double value)
{
    struct cell cell = {0, 0, 0.0};
    if (axis.count < 2) return cell;
    value = fmin(fmax(value, axis.nodes[0]), axis.nodes[axis.count - 1]);
    while (cell.lower < axis.count - 2 && axis.nodes[cell.lower + 1] <= value) ++cell.lower;
    cell.upper = cell.lower + 1;
    cell.weight = (value - axis.nodes[cell.lower]) / (axis.nodes[cell.upper] - axis.nodes[cell.lower]);
    return cell;
}

static void read_air(struct frame *frame, const char *path)
{
    static const char *const terms[] = {"emission", "thermal_path", "path", "sky", "direct"};
    char *bytes;
    long size, count, rows = 0;
    char *text = open_export(path, "atmosphere", &bytes, &size);
    const char *numbers = behind(path, text, "numbers"), *axes = behind(path, numbers, "axes") + 1;
    frame->components = (int)strtod(behind(path, numbers, "components"), NULL);
    if (frame->components % 4 || frame->components < 4 || frame->components > COMPONENTS) fail(path, "has components that no export has");
    frame->first = list(path, axes);
    axes = strchr(axes, ']') + 2;
    frame->second = list(path, axes);
    axes = strchr(axes, ']') + 2;
    if (list(path, axes).count != 1) fail(path, "is not the export of one frame");
    frame->material = list(path, behind(path, numbers, "material"));
    frame->temperature = list(path, behind(path, numbers, "emission_temperature"));
    frame->angle = list(path, behind(path, numbers, "angle"));
    frame->light = 1 + list(path, behind(path, numbers, "harmonic")).count;
    double altitude = list(path, behind(path, numbers, "altitude_km")).nodes[0];
    struct axis roots = list(path, behind(path, numbers, "height_root")), radii = list(path, behind(path, numbers, "effective_radius"));
    if (roots.count < 1 || radii.count != roots.count) fail(path, "holds an axis that does not fit another");
    frame->height = fmax(altitude - strtod(behind(path, numbers, "ground_altitude_km"), NULL), 0.0);
    frame->scale = strtod(behind(path, numbers, "scale_height_km"), NULL);
    struct cell at = locate(roots, cbrt(frame->height));
    frame->rho = radii.nodes[at.lower] * (1 - at.weight) + radii.nodes[at.upper] * at.weight;
    long places = (long)frame->first.count * frame->second.count;
    frame->air = malloc(sizeof(double) * (size_t)(places * frame->components));
    if (!frame->air) fail(path, "is too large");
    for (int group = 0; group < frame->components / 4; ++group) {
        char name[16];
        snprintf(name, sizeof name, "air%d", group);
        double *values = texels(path, text, bytes, size, name, &count);
        if (count != places * 4) fail(path, "holds a texture that does not fit its axes");
        for (long k = 0; k < count; ++k) frame->air[k / 4 * frame->components + group * 4 + k % 4] = values[k];
        free(values);
    }
    frame->terms = NULL;
    for (int term = 0; term < 5; ++term) {
        double *values = texels(path, strstr(text, "\"textures\""), bytes, size, terms[term], &count);
        frame->terms = realloc(frame->terms, sizeof(double) * (size_t)(rows + count));
        if (!frame->terms) fail(path, "is too large");
        memcpy(frame->terms + rows, values, sizeof(double) * (size_t)count);
        rows += count;
        free(values);
    }
    long materials = frame->material.count;
    if (rows != frame->components * (materials * (frame->temperature.count + frame->light + 1) + 1 + frame->angle.count))
        fail(path, "is not the export of one frame");
    free(bytes);
    free(text);
}

static void read_band(struct frame *frame, const char *path)
{
    char *bytes;
    long size, count;
    char *text = open_export(path, "band", &bytes, &size);
    const char *numbers = behind(path, text, "numbers");
    frame->first_temperature = strtod(behind(path, numbers, "first_temperature"), NULL);
    frame->temperature_step = strtod(behind(path, numbers, "temperature_step"), NULL);
    frame->blackbody.count = (int)strtod(behind(path, numbers, "temperatures"), NULL);
    frame->blackbody.nodes = texels(path, text, bytes, size, "blackbody", &count);
    if (count < frame->blackbody.count || frame->blackbody.count < 2) fail(path, "holds too few temperatures");
    frame->surfaces = texels(path, text, bytes, size, "materials", &count);
    if (count != 4 * frame->material.count) fail(path, "has other materials than the air");
    free(bytes);
    free(text);
}

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static double limited(double value) { return fmin(fmax(value, 0.0), 1.0); }
static double degrees(double angle) { return angle * 180.0 / acos(-1.0); }

/* Share of the way and direction of a line of sight. */
static void place(const struct frame *frame, double range, double sine, double *first, double *second)
{
    double height = frame->height, rho = frame->rho, scale = frame->scale, radius = rho + height;
    double rise = radius * sine, fall = height * (2 * rho + height), inside = rise * rise - fall;
    if (sine < 0 && inside >= 0) {
        double below = fall / (sqrt(inside) - rise), across = 2 * rho * height;
        *first = below > 0 ? fmin(range / below, 1.0) : 1.0;
        *second = across > 0 ? limited((below - height) * (below + height) / across) : 0.0;
        return;
    }
    double above = scale * (2 * radius + scale), way = above / (rise + sqrt(rise * rise + above)), level = sqrt(above);
    double lower = sin(asin(sine) / 2), drop = 2 * radius * lower * lower;
    *first = -expm1(-range / way);
    *second = sine < 0 ? 3 - sqrt(limited(drop / fmax(height, 1e-9))) : 3 + limited((level - way) / (level - scale));
}

static void components(const struct frame *frame, double range, const double *to_observer, double *air)
{
    double first, second;
    place(frame, range, fmin(fmax(-to_observer[2], -1.0), 1.0), &first, &second);
    struct cell across = locate(frame->first, first), down = locate(frame->second, second);
    for (int k = 0; k < frame->components; ++k) {
        const double *upper = frame->air + (long)down.lower * frame->first.count * frame->components + k;
        const double *lower = frame->air + (long)down.upper * frame->first.count * frame->components + k;
        long left = (long)across.lower * frame->components, right = (long)across.upper * frame->components;
        double top = upper[left] * (1 - across.weight) + upper[right] * across.weight;
        double bottom = lower[left] * (1 - across.weight) + lower[right] * across.weight;
        air[k] = top * (1 - down.weight) + bottom * down.weight;
    }
}

static double field(const struct frame *frame, long row, const double *air)
{
    double total = 0;
    for (int k = 0; k < frame->components; ++k) total += frame->terms[row * frame->components + k] * air[k];
    return total;
}

static double blackbody(const struct frame *frame, double temperature)
{
    double at = (temperature - frame->first_temperature) / frame->temperature_step;
    at = fmin(fmax(at, 0.0), frame->blackbody.count - 1);
    int lower = (int)fmin(floor(at), frame->blackbody.count - 2);
    double below = frame->blackbody.nodes[lower];
    return below + (frame->blackbody.nodes[lower + 1] - below) * (at - lower);
}

static double path_radiance(const struct frame *frame, const double *air, const double *source, const double *observer)
{
    long row = (long)frame->material.count * frame->temperature.count;
    double x = -observer[0], y = -observer[1], z = -observer[2];
    double a = y * source[2] - z * source[1], b = z * source[0] - x * source[2], c = x * source[1] - y * source[0];
    double angle = atan2(sqrt(a * a + b * b + c * c), x * source[0] + y * source[1] + z * source[2]);
    struct cell cell = locate(frame->angle, degrees(angle));
    double below = field(frame, row + 1 + cell.lower, air), above = field(frame, row + 1 + cell.upper, air);
    return fmax(field(frame, row, air), 0.0) + fmax(below * (1 - cell.weight) + above * cell.weight, 0.0);
}

/* A_l / pi times Y_lm of a unit normal, in the order of the codes: schemas/formats/atmq-1.md. */
static void harmonics(double x, double y, double z, double *to)
{
    double even = x * x - y * y;
    to[0] = 0.28209479177387814;
    to[1] = 0.32573500793527993 * z;
    to[2] = 0.32573500793527993 * x;
    to[3] = 0.15769578262626002 * (3 * z * z - 1) / 2;
    to[4] = 0.2731371076480198 * x * z;
    to[5] = 0.1365685538240099 * even;
    to[6] = -0.03526184897173477 * ((35 * z * z - 30) * z * z + 3) / 8;
    to[7] = -0.0557538786297741 * x * z * (7 * z * z - 3) / 2;
    to[8] = -0.039423945656565 * even * (7 * z * z - 1) / 2;
    to[9] = -0.14751089748166088 * x * z * (x * x - 3 * y * y) / 2;
    to[10] = -0.026076488977049006 * (even * even - 4 * x * x * y * y);
}

static double sky(const struct frame *frame, const double *air, long material, const double *normal, const double *source)
{
    long row = (long)frame->material.count * frame->temperature.count + 1 + frame->angle.count + material * frame->light;
    double facing[TERMS], upright[TERMS], across = hypot(source[0], source[1]), square = normal[2] * normal[2];
    double east = across > 0 ? source[0] / across : 0.0, north = across > 0 ? source[1] / across : 1.0;
    if (frame->light < 2) return fmax(field(frame, row, air), 0.0);
    double share = frame->light == 7 ? ((35 * square - 30) * square + 3) / 8
                                     : (((231 * square - 315) * square + 105) * square - 5) / 16;
    harmonics(normal[0] * east + normal[1] * north, normal[0] * north - normal[1] * east, normal[2], facing);
    harmonics(0, 0, 1, upright);
    double total = share * field(frame, row, air);
    for (int k = 1; k < frame->light; ++k) total += (facing[k - 1] - share * upright[k - 1]) * field(frame, row + k, air);
    return fmax(total, 0.0);
}

/* Radiance of a pixel of one material; its path radiance beside it. */
static double radiance(const struct frame *frame, long material, double temperature, double range, const double *normal,
                       const double *source, const double *observer, double *path)
{
    double air[COMPONENTS];
    components(frame, range, observer, air);
    struct cell cell = locate(frame->temperature, temperature);
    long row = material * frame->temperature.count;
    double share = field(frame, row + cell.lower, air) * (1 - cell.weight) + field(frame, row + cell.upper, air) * cell.weight;
    double total = share * blackbody(frame, temperature) + sky(frame, air, material, normal, source);
    double incidence = dot(normal, source);
    if (incidence > 0) {
        const double *own = frame->surfaces + 4 * material;
        long beams = (long)frame->material.count * (frame->temperature.count + frame->light) + 1 + frame->angle.count;
        double beam = fmax(field(frame, beams + material, air), 0.0);
        double between[3] = {source[0] + observer[0], source[1] + observer[1], source[2] + observer[2]};
        double size = sqrt(dot(between, between)), chi = size > 0 ? limited(dot(between, normal) / size) : 0.0;
        total += beam * (incidence * (1 - own[0]) + pow(chi, own[1]) * own[0] * own[2]);
    }
    *path = path_radiance(frame, air, source, observer);
    return total + *path;
}

int main(int count, char **arguments)
{
    struct frame frame = {0};
    double v[12], path;
    if (count != 3) fail(arguments[0], "usage: gpu AIR.gpu.json BAND.gpu.json < PIXELS");
    read_air(&frame, arguments[1]);
    read_band(&frame, arguments[2]);
    for (;;) {
        int read = 0;
        while (read < 12 && scanf("%lf", v + read) == 1) ++read;
        if (read == 0 && feof(stdin)) return 0;
        if (read < 12) fail("standard input", "a pixel must be twelve numbers");
        if (!(v[2] >= 0 && isfinite(v[2]))) fail("standard input", "a range must be a finite number from 0");
        long material = 0;
        while (material < frame.material.count && frame.material.nodes[material] != v[0]) ++material;
        if (material == frame.material.count) fail("standard input", "a material is not in the export");
        double total = radiance(&frame, material, v[1], v[2], v + 3, v + 6, v + 9, &path);
        struct cell cell = locate(frame.blackbody, total);
        printf("%.17g %.17g %.17g\n", total, path, frame.first_temperature + frame.temperature_step * (cell.lower + cell.weight));
    }
}
