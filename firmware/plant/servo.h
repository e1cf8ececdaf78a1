/* A hobby servo: it sees a pulse when that ends, turns at a limited rate until it is within its
 * dead band, trembles, and yields under load. Degrees and microseconds. */
#ifndef AGRIK_SERVO_H
#define AGRIK_SERVO_H

#include <stdint.h>

struct servo {
    double zero_us, us_per_degree;
    double rate;      /* degrees/s */
    double dead_band; /* us to either side */
    double noise;     /* degrees, standard deviation */
    double load;      /* degrees that it yields, set from outside */
    double low, high; /* degrees, its stops */
    double pulse;     /* us, the last one seen; 0 for none so far */
    double angle;     /* without noise and load */
    double shown;     /* with both */
    double pulses;    /* seen so far */
    uint64_t rise, seen; /* cycles */
    uint64_t random;
};

void servo_init(struct servo *servo, uint64_t seed);
void servo_edge(struct servo *servo, uint64_t cycle, int level, double cycles_per_us);
void servo_step(struct servo *servo, double seconds);

#endif
