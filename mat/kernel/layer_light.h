/* Weights of a field of scattered light in the light of segments, for numbers of one precision: included once for each,
 * with REAL, VECTOR, ACROSS (numbers in a vector), OF (a function's name in that precision). The rows of all arguments
 * have padded P numbers. */

/* 1 - exp(-t). */
INLINE VECTOR OF(absorbed)(VECTOR t) {
    VECTOR near, far;
    OF(source_weights)(t, &near, &far);
    return near + far;
}

/* What sources 1, u and u^2 send out of the near end, with u from 0 there to 1 at an optical depth t. */
INLINE void OF(power_weights)(VECTOR t, VECTOR *weight) {
    static const REAL factorial[] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800, 39916800};
    VECTOR near, far, series = OF(all)(0);
    OF(source_weights)(t, &near, &far);
    for (int n = SERIES; n >= 0; n--) series = series * t + (n % 2 ? -1 : 1) / (factorial[n] * (n + 3));
    weight[0] = near + far;
    weight[1] = far;
    weight[2] = OF(select)(t < OF(all)((REAL)0.35), series * t, 2 * far / OF(larger)(t, OF(all)((REAL)0.1)) - OF(exp)(-t));
}

/* Optical depth of a segment, from a table (N, P) at the levels of its layer. */
INLINE void OF(column)(REAL lower, REAL upper, const REAL *below, const REAL *above, int64_t stride, REAL *depth) {
    for (int64_t p = 0; p < stride; p += ACROSS)
        OF(store)(depth + p, lower * OF(load)(below + p) + upper * OF(load)(above + p));
}

/* Weights of the source function at the lower and at the upper level of a segment's layer, which is not cut: the mean
 * counts each level by its extinction, the slope is limited so that no weight is negative. `scaled` (P,) is the segment's
 * scaled optical depth, of which `upper` times `above` counts with the upper level; `climb` is half its rise over the
 * layer's height; `through` (P,) the transmittance from its near end to the observer. */
INLINE void OF(end_weights)(
    REAL upper, const REAL *above, const REAL *scaled, REAL climb, const REAL *through, int64_t stride, REAL *at_lower,
    REAL *at_upper
) {
    for (int64_t p = 0; p < stride; p += ACROSS) {
        VECTOR near, far, depth = OF(load)(scaled + p), transmittance = OF(load)(through + p);
        OF(source_weights)(depth, &near, &far);
        VECTOR share = upper * OF(load)(above + p) / OF(larger)(depth, OF(all)((REAL)1e-37));
        VECTOR sum = near + far;
        VECTOR high = OF(smaller)(OF(larger)(sum * share + (far - near) * climb, OF(all)(0)), sum);
        OF(store)(at_lower + p, (sum - high) * transmittance);
        OF(store)(at_upper + p, high * transmittance);
    }
}

/* Weights (3, P) of the three known values of a piece of a segment in a cut layer. */
INLINE void OF(piece_weights)(
    const Piece *piece, const REAL *scaled, const REAL *through, int64_t stride, REAL *weight
) {
    for (int64_t p = 0; p < stride; p += ACROSS) {
        VECTOR power[3], depth = OF(load)(scaled + p);
        OF(power_weights)((REAL)piece->share * depth, power);
        VECTOR before = OF(exp)(-(REAL)piece->before * depth) * OF(load)(through + p);
        for (int i = 0; i < 3; i++) {
            const double *c = piece->coefficient[i];
            VECTOR sum = (REAL)c[0] * power[0] + (REAL)c[1] * power[1] + (REAL)c[2] * power[2];
            OF(store)(weight + i * stride + p, sum * before);
        }
    }
}

/* Share (P,) of the light at the far end of a segment that reaches the observer scattered straight forward. */
INLINE void OF(straight_share)(
    const REAL *depth, const REAL *scaled, const REAL *through, int64_t stride, REAL *share
) {
    for (int64_t p = 0; p < stride; p += ACROSS) {
        VECTOR left = OF(load)(scaled + p), lost = OF(larger)(OF(load)(depth + p) - left, OF(all)(0));
        OF(store)(share + p, OF(exp)(-left) * OF(absorbed)(lost) * OF(load)(through + p));
    }
}

/* Adds to a sum (P,) the rows of a table times factors, in all times a weight (P,). */
INLINE void OF(add_rows)(
    int64_t rows, const REAL *table, int64_t step, const double *factor, const REAL *weight, int64_t stride, REAL *sum
) {
    for (int64_t p = 0; p < stride; p += ACROSS) {
        VECTOR light = OF(all)(0);
        for (int64_t row = 0; row < rows; row++) light += (REAL)factor[row] * OF(load)(table + row * step + p);
        OF(store)(sum + p, OF(load)(sum + p) + light * OF(load)(weight + p));
    }
}
