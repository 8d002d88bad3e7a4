/* Functions of single numbers, in double precision. */
#ifndef SKYSHINE_SCALAR_H
#define SKYSHINE_SCALAR_H

#include <stdint.h>
#include "lanes.h"

#define PI 3.14159265358979323846

INLINE double clipped(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/* Arc sine: its series to |x| = 1/2, asin(x) = pi/2 - 2 asin(sqrt((1 - x) / 2)) beyond; within 3e-16. */
INLINE VectorD arc_sine_d(VectorD x) {
    /* (2k)! / (4^k (k!)^2 (2k + 1)) */
    static const double coefficient[24] = {
        1.0, 0.16666666666666666, 0.075, 0.044642857142857144,
        0.030381944444444444, 0.022372159090909092, 0.017352764423076924, 0.01396484375,
        0.011551800896139705, 0.009761609529194078, 0.008390335809616815, 0.0073125258735988454,
        0.006447210311889649, 0.005740037670841924, 0.005153309682319905, 0.004660143486915096,
        0.004240907093679363, 0.003880964558837669, 0.0035692053938259347, 0.003297059503473485,
        0.0030578216492580306, 0.002846178401108942, 0.00265787063820729, 0.0024894486782468836};
    VectorD size = select_d(x < all_d(0), -x, x);
    BitsD beyond = size > all_d(0.5);
    VectorD square = select_d(beyond, 0.5 * (1 - size), size * size), fourth = square * square;
    VectorD even = all_d(0), odd = all_d(0);
    for (int k = 22; k >= 0; k -= 2) {
        even = even * fourth + coefficient[k];
        odd = odd * fourth + coefficient[k + 1];
    }
    VectorD sum = even + odd * square;
    VectorD angle = select_d(beyond, 0.5 * PI - 2 * root_d(square) * sum, size * sum);
    return select_d(x < all_d(0), -angle, angle);
}

/* Natural logarithm of positive, normal numbers: x = 2^n m, m from sqrt(1/2) to sqrt(2), and the series of
 * 2 artanh((m - 1) / (m + 1)). The last sum keeps what is not a number. */
INLINE VectorD logarithm_d(VectorD x) {
    const double magic = 6755399441055744.0; /* 1.5 2^52 */
    BitsD bits = (BitsD)x, exponent = (bits >> 52) - 1023;
    VectorD m = (VectorD)((bits & 0x000fffffffffffffLL) | 0x3ff0000000000000LL);
    BitsD large = m > all_d(1.4142135623730951);
    m = select_d(large, 0.5 * m, m);
    VectorD power = (VectorD)(exponent - large + (BitsD)all_d(magic)) - magic;
    VectorD f = (m - 1) / (m + 1), square = f * f, sum = all_d(0);
    for (int k = 21; k >= 1; k -= 2) sum = sum * square + 1.0 / k;
    return power * 0.69314718055994530942 + 2 * f * sum + (x - x);
}

/* Sine and cosine of angles below 1e9 degree; within 2e-16. Rounded by the sum, the number of the nearest quarter turn is
 * in the lowest bits. Taylor's series of both to r^15 and r^16, |r| <= pi / 4. */
INLINE void sine_and_cosine_d(VectorD degrees, VectorD *sine, VectorD *cosine) {
    const double magic = 6755399441055744.0; /* 1.5 2^52 */
    VectorD shifted = degrees * (1 / 90.0) + magic, turn = shifted - magic;
    BitsD quadrant = (BitsD)shifted;
    VectorD r = (degrees - 90.0 * turn) * (PI / 180), square = r * r;
    VectorD s = square * (-1 / 1307674368000.0) + 1 / 6227020800.0;
    s = s * square - 1 / 39916800.0;
    s = s * square + 1 / 362880.0;
    s = s * square - 1 / 5040.0;
    s = s * square + 1 / 120.0;
    s = s * square - 1 / 6.0;
    s = (s * square) * r + r;
    VectorD c = square * (1 / 20922789888000.0) - 1 / 87178291200.0;
    c = c * square + 1 / 479001600.0;
    c = c * square - 1 / 3628800.0;
    c = c * square + 1 / 40320.0;
    c = c * square - 1 / 720.0;
    c = c * square + 1 / 24.0;
    c = c * square - 0.5;
    c = c * square + 1.0;
    BitsD odd = -(quadrant & 1);
    VectorD straight = select_d(odd, c, s), across = select_d(odd, s, c);
    *sine = (VectorD)((BitsD)straight ^ ((quadrant & 2) << 62));
    *cosine = (VectorD)((BitsD)across ^ (((quadrant + 1) & 2) << 62));
}

/* exp(-t) and 1 - exp(-t) of t from 0 on, the latter by Taylor's series below 0.35. */
INLINE void attenuation_d(VectorD t, VectorD *through, VectorD *absorbed) {
    static const double factorial[] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800, 39916800, 479001600};
    VectorD part = all_d(-1 / factorial[12]);
    for (int n = 11; n > 0; n--) part = part * t + (n % 2 ? 1.0 : -1.0) / factorial[n];
    *through = exp_d(-t);
    *absorbed = select_d(t < all_d(0.35), part * t, 1.0 - *through);
}

/* Logarithm of 1 - x, x below 1: that of the rounded difference, times what rounding took from x. */
INLINE VectorD log_of_rest_d(VectorD x) {
    VectorD rest = 1.0 - x, taken = 1.0 - rest;
    BitsD none = taken == all_d(0);
    return select_d(none, -x, logarithm_d(rest) * (x / select_d(none, all_d(1), taken)));
}

/* Cube root of numbers from 0 on: that by logarithms, and a step of Newton. */
INLINE VectorD cube_root_d(VectorD x) {
    VectorD bounded = larger_d(x, all_d(1e-300)), root = exp_d(logarithm_d(bounded) * (1 / 3.0));
    root = root - (root - bounded / (root * root)) * (1 / 3.0);
    return select_d(x > all_d(0), root, x);
}

INLINE VectorD floor_d(VectorD x) {
    const double magic = 6755399441055744.0;
    VectorD whole = (x + magic) - magic;
    whole = select_d(whole > x, whole - 1.0, whole);
    BitsD large = (x >= all_d(2251799813685248.0)) | (x <= all_d(-2251799813685248.0)); /* 2^51: whole already */
    return select_d(large, x, whole);
}

INLINE double arc_sine(double x) { return arc_sine_d(all_d(x))[0]; }
INLINE double logarithm(double x) { return logarithm_d(all_d(x))[0]; }
INLINE double exponential(double x) { return exp_d(all_d(x))[0]; }
INLINE double log_of_rest(double x) { return log_of_rest_d(all_d(x))[0]; }
INLINE double cube_root(double x) { return cube_root_d(all_d(x))[0]; }
INLINE double floor_of(double x) { return floor_d(all_d(x))[0]; }
INLINE double sine_and_cosine(double degrees, double *cosine) {
    VectorD s, c;
    sine_and_cosine_d(all_d(degrees), &s, &c);
    *cosine = c[0];
    return s[0];
}
INLINE double larger(double a, double b) { return a < b ? b : a; }
INLINE double smaller(double a, double b) { return a > b ? b : a; }
INLINE int is_finite(double x) { return x - x == 0; }
#define NOT_A_NUMBER __builtin_nan("")
#define INFINITE __builtin_inf()

/* The last of `count` increasing numbers that is not above x; 0 where all are. */
INLINE int64_t last_below(const double *numbers, int64_t count, double x) {
    int64_t low = 0, high = count;
    while (high - low > 1) {
        int64_t middle = (low + high) / 2;
        if (numbers[middle] <= x)
            low = middle;
        else
            high = middle;
    }
    return low;
}

#endif
