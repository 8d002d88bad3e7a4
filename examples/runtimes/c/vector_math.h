/* Elementary functions without branches, which compilers turn into vector instructions; errors below 1e-15 of the result,
 * of sine and cosine below 1e-15. */
#ifndef SKYSHINE_VECTOR_MATH_H
#define SKYSHINE_VECTOR_MATH_H

#include <stdint.h>
#include <string.h>

#if defined __GNUC__
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

/* Added to a number below 2^51 and subtracted again, it rounds; meanwhile the integer stands in the lowest bits. */
#define ROUNDING 6755399441055744.0

INLINE uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

INLINE double number_of(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* e^x for x from -708 to 708, limited to them. */
INLINE double exponential(double x)
{
    x = x < -708.0 ? -708.0 : x;
    x = x > 708.0 ? 708.0 : x;
    const double shifted = x * 1.4426950408889634 + ROUNDING, count = shifted - ROUNDING;
    const double r = (x - count * 0.693147180369123816490) - count * 1.90821492927058770002e-10;
    double sum = 1.0 / 479001600;
    sum = sum * r + 1.0 / 39916800;
    sum = sum * r + 1.0 / 3628800;
    sum = sum * r + 1.0 / 362880;
    sum = sum * r + 1.0 / 40320;
    sum = sum * r + 1.0 / 5040;
    sum = sum * r + 1.0 / 720;
    sum = sum * r + 1.0 / 120;
    sum = sum * r + 1.0 / 24;
    sum = sum * r + 1.0 / 6;
    sum = sum * r + 0.5;
    sum = sum * r + 1.0;
    sum = sum * r + 1.0;
    return sum * number_of((bits_of(shifted) + 1023) << 52);
}

/* Natural logarithm of a positive normal number up to 1. */
INLINE double logarithm(double x)
{
    const uint64_t bits = bits_of(x), shifted = bits + 0x00095F619980C433ull; /* the mantissa then begins at sqrt(1/2) */
    /* The exponent of a number up to 1 is at most 1023: as an integer below 2^52 it fits the bits of a double. */
    const double count = number_of((shifted >> 52) | 0x4330000000000000ull) - 4503599627371519.0;
    const double m = number_of(bits - (((shifted >> 52) - 1023) << 52));
    const double s = (m - 1.0) / (m + 1.0), square = s * s;
    double sum = 2.0 / 19;
    sum = sum * square + 2.0 / 17;
    sum = sum * square + 2.0 / 15;
    sum = sum * square + 2.0 / 13;
    sum = sum * square + 2.0 / 11;
    sum = sum * square + 2.0 / 9;
    sum = sum * square + 2.0 / 7;
    sum = sum * square + 2.0 / 5;
    sum = sum * square + 2.0 / 3;
    sum = sum * square + 2.0;
    return count * 0.6931471805599453 + s * sum;
}

/* Sine and cosine of an angle in degree, below 1e9 of them. */
INLINE void sine_and_cosine(double angle, double *sine, double *cosine)
{
    const double shifted = angle * (1.0 / 90.0) + ROUNDING, turn = shifted - ROUNDING;
    const uint64_t quadrant = bits_of(shifted);
    const double r = (angle - 90.0 * turn) * 0.017453292519943295, square = r * r;
    double s = -1.0 / 1307674368000.0, c = 1.0 / 20922789888000.0;
    s = s * square + 1.0 / 6227020800.0;
    s = s * square - 1.0 / 39916800;
    s = s * square + 1.0 / 362880;
    s = s * square - 1.0 / 5040;
    s = s * square + 1.0 / 120;
    s = s * square - 1.0 / 6;
    s = (s * square) * r + r;
    c = c * square - 1.0 / 87178291200.0;
    c = c * square + 1.0 / 479001600;
    c = c * square - 1.0 / 3628800;
    c = c * square + 1.0 / 40320;
    c = c * square - 1.0 / 720;
    c = c * square + 1.0 / 24;
    c = c * square - 0.5;
    c = c * square + 1.0;
    const double straight = quadrant & 1 ? c : s, across = quadrant & 1 ? s : c;
    *sine = number_of(bits_of(straight) ^ ((quadrant & 2) << 62));
    *cosine = number_of(bits_of(across) ^ (((quadrant + 1) & 2) << 62));
}

#endif
