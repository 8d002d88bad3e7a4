/* What light of a source along lines of sight is computed from; rows of spectral points have padded P numbers, of the few
 * points of the forward peak padded Q. */
#ifndef SKYSHINE_SCATTERING_H
#define SKYSHINE_SCATTERING_H

#include "precision.h"
#include "source_paths.h"

/* `forward_peak.ForwardPeak`. */
typedef struct {
    SourcePaths paths;            /* of Q points, through scattering in the peak alone */
    const float *few, *every;     /* N x Q, N x P: scattering in the peak, in units of air */
    const float *change;          /* N x angles x depths x Q (not padded) */
    int64_t angles, depths;
    const double *angle;          /* degree */
    double least_depth, log_step; /* of the depths */
    double none, whole;           /* depths below which the change is none, above which it is whole */
    double farthest;              /* cosine of the last angle */
    const int64_t *spread;        /* P: the first of two points of the few between which each lies */
    const float *spread_next;     /* P: weight of the second */
} Peak;

typedef struct {
    int64_t classes, angles;       /* C, A */
    const float *scaled, *rayleigh; /* N x P, in units of air */
    const float *particles;        /* N x P, or NULL without any */
    const double *particle_sum;    /* N: scattering by particles, summed over the points */
    const float *phase_share;      /* C x P */
    const float *phase;            /* A x N x C */
    double angle_step, anisotropy; /* rad; of molecular scattering */
    SourcePaths paths;
    Peak peak;                     /* its `few` is NULL where particles have no forward peak */
    int64_t elevations, smooth;    /* U; the first from which cubics run, of their arc sines */
    const double *sine, *typical;  /* U */
    double fall, start, end;       /* `typical_light`: rate [degree^-1] and degrees */
    Cubics elevation;
    const float *source;           /* Q x U x B x P */
    const float *straight;         /* N x U x X x M x P, or NULL */
} Scattering;

enum { OF_BAND, OF_LINES, OF_SEGMENTS };

#endif
