/* Steps of a quadrature encoder: `quadrature_steps[before << 2 | now]`, B in bit 1, A in bit 0.
 * A leads B when the axis moves up. */
#ifndef AGRIK_QUADRATURE_H
#define AGRIK_QUADRATURE_H

#include <stdint.h>

/* Both channels at once: an edge was missed, and with it the direction. */
#define QUADRATURE_SKIP 2

static const int8_t quadrature_steps[16] = {
    0, 1, -1, QUADRATURE_SKIP,
    -1, 0, QUADRATURE_SKIP, 1,
    1, QUADRATURE_SKIP, 0, -1,
    QUADRATURE_SKIP, -1, 1, 0,
};

#endif
