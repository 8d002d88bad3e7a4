/* Vectors of LANES single-precision numbers, and of as many bytes of double precision; functions of each lane.
 *
 * The same bytes come from any number of lanes: nothing contracts a product and a sum, each lane is computed alone, and
 * sums over spectral points run in eight parts (`Eight`) that are added in one order.
 */
#ifndef SKYSHINE_LANES_H
#define SKYSHINE_LANES_H

#include <stdint.h>

#ifndef LANES
#define LANES 4
#endif
#define DOUBLES (LANES / 2)
#define INLINE static inline __attribute__((always_inline, unused))

/* As memory holds them: aligned to their numbers alone. */
typedef float VectorF __attribute__((vector_size(4 * LANES), aligned(4), may_alias));
typedef int32_t BitsF __attribute__((vector_size(4 * LANES), aligned(4), may_alias));
typedef double VectorD __attribute__((vector_size(4 * LANES), aligned(8), may_alias));
typedef int64_t BitsD __attribute__((vector_size(4 * LANES), aligned(8), may_alias));
/* As many single-precision numbers as a vector has of double precision. */
typedef float HalfF __attribute__((vector_size(2 * LANES), aligned(4), may_alias));

/* Spectral points are stored in rows of a multiple of eight. */
INLINE int64_t padded(int64_t points) { return (points + 7) / 8 * 8; }

INLINE VectorF all_f(float value) { return value - (VectorF){0}; }
INLINE VectorD all_d(double value) { return value - (VectorD){0}; }
INLINE VectorF load_f(const float *at) { return *(const VectorF *)at; }
INLINE VectorD load_d(const double *at) { return *(const VectorD *)at; }
INLINE VectorD load_fd(const float *at) { return __builtin_convertvector(*(const HalfF *)at, VectorD); }
INLINE void store_f(float *at, VectorF value) { *(VectorF *)at = value; }
INLINE void store_d(double *at, VectorD value) { *(VectorD *)at = value; }

INLINE VectorF select_f(BitsF where, VectorF yes, VectorF no) {
    return (VectorF)(((BitsF)yes & where) | ((BitsF)no & ~where));
}
INLINE VectorD select_d(BitsD where, VectorD yes, VectorD no) {
    return (VectorD)(((BitsD)yes & where) | ((BitsD)no & ~where));
}
/* Of the first argument and a bound: what is not a number stays so. */
INLINE VectorF larger_f(VectorF a, VectorF b) { return select_f(a < b, b, a); }
INLINE VectorD larger_d(VectorD a, VectorD b) { return select_d(a < b, b, a); }
INLINE VectorF smaller_f(VectorF a, VectorF b) { return select_f(a > b, b, a); }
INLINE VectorD smaller_d(VectorD a, VectorD b) { return select_d(a > b, b, a); }

INLINE VectorD root_d(VectorD x) {
    VectorD root;
    for (int i = 0; i < DOUBLES; i++) root[i] = __builtin_sqrt(x[i]);
    return root;
}

INLINE VectorF root_f(VectorF x) {
    VectorF root;
    for (int i = 0; i < LANES; i++) root[i] = __builtin_sqrtf(x[i]);
    return root;
}

/* exp(x) = 2^n exp(r), |r| <= ln(2) / 2, Taylor's series of exp(r): 6e-9 and 5e-18 are left out. 0 below 2^-126 and
 * 2^-1022; numbers beyond 2^127 and 2^1023 are those. ln(2) is subtracted in two parts, of which n times the first is
 * exact. */
INLINE VectorF exp_f(VectorF x) {
    const float magic = 12582912.0f; /* 1.5 2^23: added and subtracted, it rounds to a whole number */
    VectorF bounded = smaller_f(larger_f(x, all_f(-87.3f)), all_f(88.0f));
    VectorF shifted = bounded * 1.44269504f + magic;
    BitsF power = (BitsF)shifted - (BitsF)all_f(magic);
    VectorF whole = shifted - magic;
    VectorF r = (bounded - whole * 0.693359375f) - whole * -2.12194440e-4f;
    VectorF sum = r * (1 / 5040.0f) + 1 / 720.0f;
    sum = sum * r + 1 / 120.0f;
    sum = sum * r + 1 / 24.0f;
    sum = sum * r + 1 / 6.0f;
    sum = sum * r + 0.5f;
    sum = sum * r + 1.0f;
    sum = sum * r + 1.0f;
    VectorF scale = (VectorF)((power + 127) << 23);
    return select_f(x < all_f(-87.3f), all_f(0), sum * scale);
}

INLINE VectorD exp_d(VectorD x) {
    const double magic = 6755399441055744.0; /* 1.5 2^52 */
    VectorD bounded = smaller_d(larger_d(x, all_d(-708.0)), all_d(709.0));
    VectorD shifted = bounded * 1.4426950408889634 + magic;
    BitsD power = (BitsD)shifted - (BitsD)all_d(magic);
    VectorD whole = shifted - magic;
    VectorD r = (bounded - whole * 0.693147180369123816490) - whole * 1.90821492927058770002e-10;
    VectorD sum = r * (1 / 6227020800.0) + 1 / 479001600.0;
    sum = sum * r + 1 / 39916800.0;
    sum = sum * r + 1 / 3628800.0;
    sum = sum * r + 1 / 362880.0;
    sum = sum * r + 1 / 40320.0;
    sum = sum * r + 1 / 5040.0;
    sum = sum * r + 1 / 720.0;
    sum = sum * r + 1 / 120.0;
    sum = sum * r + 1 / 24.0;
    sum = sum * r + 1 / 6.0;
    sum = sum * r + 0.5;
    sum = sum * r + 1.0;
    sum = sum * r + 1.0;
    VectorD scale = (VectorD)((power + 1023) << 52);
    return select_d(x < all_d(-708.0), all_d(0), sum * scale);
}

/* Weights of a source linear in optical depth t, of its near and far end; their sum is 1 - exp(-t). Below `_SMALL` they
 * are summed as series, whose next terms are below the rounding. */
INLINE void source_weights_f(VectorF t, VectorF *near, VectorF *far) {
    VectorF absorbed = 1.0f - exp_f(-t);
    VectorF large = absorbed * (1.0f + 1.0f / larger_f(t, all_f(0.1f))) - 1.0f;
    /* far = sum over n of (-1)^(n+1) t^n n / (n+1)! */
    VectorF sum = t * (7 / 40320.0f) - 6 / 5040.0f;
    sum = sum * t + 5 / 720.0f;
    sum = sum * t - 4 / 120.0f;
    sum = sum * t + 3 / 24.0f;
    sum = sum * t - 2 / 6.0f;
    sum = sum * t + 0.5f;
    VectorF series = sum * t;
    VectorF part = t * (1 / 5040.0f) - 1 / 720.0f;
    part = part * t + 1 / 120.0f;
    part = part * t - 1 / 24.0f;
    part = part * t + 1 / 6.0f;
    part = part * t - 0.5f;
    part = part * t + 1.0f;
    BitsF small = t < all_f(0.35f);
    absorbed = select_f(small, part * t, absorbed);
    *far = select_f(small, series, large);
    *near = absorbed - *far;
}

INLINE void source_weights_d(VectorD t, VectorD *near, VectorD *far) {
    VectorD absorbed = 1.0 - exp_d(-t);
    VectorD large = absorbed * (1.0 + 1.0 / larger_d(t, all_d(0.1))) - 1.0;
    static const double factorial[] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800, 39916800, 479001600};
    VectorD sum = all_d(0), part = all_d(0);
    for (int n = 11; n > 0; n--) {
        double sign = n % 2 ? 1.0 : -1.0;
        sum = sum * t + sign * n / factorial[n + 1];
        part = part * t + sign / factorial[n];
    }
    BitsD small = t < all_d(0.35);
    absorbed = select_d(small, part * t, absorbed);
    *far = select_d(small, sum * t, large);
    *near = absorbed - *far;
}

/* A sum over spectral points, in eight parts. */
typedef struct {
    VectorF part[8 / LANES];
} Eight;

INLINE float total_of(const Eight *sum) {
    float of[8];
    for (int h = 0; h < 8 / LANES; h++) store_f(of + h * LANES, sum->part[h]);
    return ((of[0] + of[4]) + (of[1] + of[5])) + ((of[2] + of[6]) + (of[3] + of[7]));
}

#endif
