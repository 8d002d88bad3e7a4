/* Thermal radiation along lines of sight, in single and in double precision. */
#include "export.h"
#include "precision.h"

#define REAL float
#define VECTOR VectorF
#define ACROSS LANES
#define OF(name) name##_f
#include "thermal.h"
#undef REAL
#undef VECTOR
#undef ACROSS
#undef OF

#define REAL double
#define VECTOR VectorD
#define ACROSS DOUBLES
#define OF(name) name##_d
#include "thermal.h"
