/* The functions of `pixels.h` that are compiled for several vectors: those of this processor. */
#include "export.h"
#include "pixels.h"

int skyshine_lanes(void);

#if defined(__x86_64__)
#define CALL(name, arguments) (skyshine_lanes() == 8 ? name##_8 arguments : name##_4 arguments)
#define BOTH(result, name, parameters) \
    result name##_4 parameters; \
    result name##_8 parameters;
#else
#define CALL(name, arguments) name##_4 arguments
#define BOTH(result, name, parameters) result name##_4 parameters;
#endif

#define FUNCTION(result, name, parameters, arguments) \
    BOTH(result, name, parameters) \
    SKYSHINE_EXPORT result name parameters { return CALL(name, arguments); }

BOTH(size_t, skyshine_pixel_scratch, (const SkyTables *tables))
BOTH(size_t, skyshine_quantity_scratch, (const SkyTables *tables))
BOTH(size_t, skyshine_shade_scratch, (const SkyTables *tables))

SKYSHINE_EXPORT size_t skyshine_scratch_size(const SkyTables *tables) {
    size_t pixel = CALL(skyshine_pixel_scratch, (tables)), quantity = CALL(skyshine_quantity_scratch, (tables));
    return pixel > quantity ? pixel : quantity; /* that of shade is a part of the former */
}

FUNCTION(int32_t, skyshine_absorbed,
         (const SkyTables *tables, size_t count, const SkyFaces *faces, const SkySurroundings *around, int32_t each, double *absorbed,
          void *scratch, SkyFailure *failure),
         (tables, count, faces, around, each, absorbed, scratch, failure))
FUNCTION(int32_t, skyshine_heated,
         (const SkyTables *tables, size_t count, const SkyFaces *faces, const double *absorbed, size_t steps, const double *hours,
          size_t times, double *temperature, void *scratch, SkyFailure *failure),
         (tables, count, faces, absorbed, steps, hours, times, temperature, scratch, failure))
FUNCTION(int32_t, skyshine_changes,
         (const SkyTables *tables, size_t count, const SkyFaces *faces, const double *absorbed, const double *temperature,
          const double *highest, double *moved, void *scratch, SkyFailure *failure),
         (tables, count, faces, absorbed, temperature, highest, moved, scratch, failure))
FUNCTION(int32_t, skyshine_quantity,
         (const SkyTables *tables, int32_t quantity, int32_t by_wavelength, size_t count, const SkyPlaces *places, double *values,
          void *scratch, SkyFailure *failure),
         (tables, quantity, by_wavelength, count, places, values, scratch, failure))
FUNCTION(int32_t, skyshine_ambient,
         (const SkyTables *tables, int32_t by_wavelength, size_t count, const SkyPlaces *places, const double *slope, const double *azimuth,
          const double *ground_temperature, double *values, void *scratch, SkyFailure *failure),
         (tables, by_wavelength, count, places, slope, azimuth, ground_temperature, values, scratch, failure))
FUNCTION(int32_t, skyshine_pixel_terms,
         (const SkyTables *tables, size_t count, size_t materials, size_t lines, const SkyPixels *pixels, const SkyTerms *terms,
          void *scratch, SkyFailure *failure),
         (tables, count, materials, lines, pixels, terms, scratch, failure))
