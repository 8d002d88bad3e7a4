/* Thermal radiation of each segment at the observer, for numbers of one precision: see `thermal.c`. */

/* Radiance (K, P) of segments whose source function is linear between the levels, air without particles.
 *
 * `emission` (N, padded P) is the source function at the levels; `depth` (K, P) the segments' optical depth; `scratch`
 * has room for three rows of padded P numbers. */
SKYSHINE_EXPORT void SKYSHINE_NAME(OF(emitted))(
    const Rays *rays, int64_t points, const double *altitude, const REAL *emission, const REAL *depth, REAL *scratch,
    REAL *radiance
) {
    int64_t stride = padded(points);
    REAL *total = scratch, *row = total + stride, *sent = row + stride;
    for (int64_t line = 0; line < rays->lines; line++) {
        for (int64_t p = 0; p < stride; p++) total[p] = row[p] = 0;
        for (int64_t k = rays->first[line]; k + 1 < line_end(rays, line); k++) {
            int64_t layer = rays->layer[k];
            double air = rays->lower[k] + rays->upper[k];
            REAL share = (REAL)(air > 0 ? rays->upper[k] / air : 0.5);
            REAL climb = (REAL)(0.5 * (rays->altitude[k + 1] - rays->altitude[k]) / (altitude[layer + 1] - altitude[layer]));
            const REAL *below = emission + layer * stride, *above = below + stride;
            for (int64_t p = 0; p < points; p++) row[p] = depth[k * points + p];
            for (int64_t p = 0; p < stride; p += ACROSS) {
                VECTOR near, far, low = OF(load)(below + p), difference = OF(load)(above + p) - low;
                VECTOR before = OF(load)(total + p), optical = OF(load)(row + p);
                OF(source_weights)(optical, &near, &far);
                VECTOR middle = low + difference * share; /* a source is never negative */
                VECTOR half = OF(smaller)(OF(larger)(difference * climb, -middle), middle);
                OF(store)(sent + p, (near * (middle - half) + far * (middle + half)) * OF(exp)(-before));
                OF(store)(total + p, before + optical);
            }
            for (int64_t p = 0; p < points; p++) radiance[k * points + p] = sent[p];
        }
    }
}

/* Radiance (K, P) of segments among particles.
 *
 * Tables of the field (`thermal_source.ThermalField`), in rows of padded P numbers: `scaled` (N, P) extinction in units
 * of air, `source` (Q, B, P), `straight` (N, X, P). `depth` (K, P) is the segments' optical depth; `scratch` has room for
 * eight rows, `functions` for B numbers. */
SKYSHINE_EXPORT void SKYSHINE_NAME(OF(thermal))(
    const Rays *rays, const Layers *layers, const REAL *scaled, const REAL *source, const REAL *straight, const REAL *depth,
    double *functions, REAL *scratch, REAL *radiance
) {
    int64_t points = layers->points, stride = padded(points), count = functions_of(layers);
    REAL *total = scratch, *row = total + stride, *optical = row + stride, *through = optical + stride;
    REAL *sum = through + stride, *weight = sum + stride; /* three rows */
    for (int64_t line = 0; line < rays->lines; line++) {
        for (int64_t p = 0; p < stride; p++) total[p] = row[p] = 0;
        for (int64_t k = rays->first[line]; k + 1 < line_end(rays, line); k++) {
            int64_t layer = rays->layer[k], first;
            double nearer, farther, of_direction[8], height = layers->altitude[layer + 1] - layers->altitude[layer];
            REAL lower = (REAL)(rays->lower[k] / UNIT_OF_AIR), upper = (REAL)(rays->upper[k] / UNIT_OF_AIR);
            const REAL *below = scaled + layer * stride, *above = below + stride;
            for (int64_t p = 0; p < points; p++) row[p] = depth[k * points + p];
            for (int64_t p = 0; p < stride; p += ACROSS) {
                OF(store)(through + p, OF(exp)(-OF(load)(total + p)));
                OF(store)(total + p, OF(load)(total + p) + OF(load)(row + p));
                OF(store)(sum + p, OF(all)(0));
            }
            OF(column)(lower, upper, below, above, stride, optical);
            inside_layer(layers, rays, k, &nearer, &farther);
            legendre(layers->moments, layers->azimuthal, rays->rise[k], functions);
            if (layers->parts.count[layer] > 1) {
                int64_t number = pieces_of(layers, layer, nearer, farther, &first);
                for (int64_t pair = first; pair < first + number; pair++) {
                    Piece piece;
                    piece_of(layers, layer, nearer, farther, pair, &piece);
                    OF(piece_weights)(&piece, optical, through, stride, weight);
                    for (int i = 0; i < 3; i++) {
                        const REAL *table = source + piece.place[i] * count * stride;
                        OF(add_rows)(count, table, stride, functions, weight + i * stride, stride, sum);
                    }
                }
            } else {
                REAL climb = (REAL)(0.5 * (rays->altitude[k + 1] - rays->altitude[k]) / height);
                const REAL *table = source + layer * count * stride;
                OF(end_weights)(upper, above, optical, climb, through, stride, weight, weight + stride);
                OF(add_rows)(count, table, stride, functions, weight, stride, sum);
                OF(add_rows)(count, table + count * stride, stride, functions, weight + stride, stride, sum);
            }
            OF(straight_share)(row, optical, through, stride, weight);
            first = direction_weights(layers, rays->rise[k], of_direction);
            for (int end = 0; end < 2; end++) {
                double factor[8], share = end ? farther : 1 - farther;
                for (int64_t i = 0; i < layers->direction.width; i++) factor[i] = share * of_direction[i];
                const REAL *table = straight + ((layer + end) * layers->directions + first) * stride;
                OF(add_rows)(layers->direction.width, table, stride, factor, weight, stride, sum);
            }
            for (int64_t p = 0; p < points; p++) radiance[k * points + p] = sum[p];
        }
    }
}
