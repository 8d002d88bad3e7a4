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
 * 2 artanh((m - 1) / (m + 1)). */
INLINE VectorD logarithm_d(VectorD x) {
    const double magic = 6755399441055744.0; /* 1.5 2^52 */
    BitsD bits = (BitsD)x, exponent = (bits >> 52) - 1023;
    VectorD m = (VectorD)((bits & 0x000fffffffffffffLL) | 0x3ff0000000000000LL);
    BitsD large = m > all_d(1.4142135623730951);
    m = select_d(large, 0.5 * m, m);
    VectorD power = (VectorD)(exponent - large + (BitsD)all_d(magic)) - magic;
    VectorD f = (m - 1) / (m + 1), square = f * f, sum = all_d(0);
    for (int k = 21; k >= 1; k -= 2) sum = sum * square + 1.0 / k;
    return power * 0.69314718055994530942 + 2 * f * sum;
}

INLINE double arc_sine(double x) { return arc_sine_d(all_d(x))[0]; }
INLINE double logarithm(double x) { return logarithm_d(all_d(x))[0]; }
INLINE double exponential(double x) { return exp_d(all_d(x))[0]; }

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
