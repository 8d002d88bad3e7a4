/* `layer_light.h` in single (_f) and double precision (_d). */
#ifndef SKYSHINE_PRECISION_H
#define SKYSHINE_PRECISION_H

#include "lanes.h"
#include "rays.h"

#define REAL float
#define VECTOR VectorF
#define ACROSS LANES
#define SERIES 7
#define OF(name) name##_f
#include "layer_light.h"
#undef REAL
#undef VECTOR
#undef ACROSS
#undef SERIES
#undef OF

#define REAL double
#define VECTOR VectorD
#define ACROSS DOUBLES
#define SERIES 11
#define OF(name) name##_d
#include "layer_light.h"
#undef REAL
#undef VECTOR
#undef ACROSS
#undef SERIES
#undef OF

#endif
