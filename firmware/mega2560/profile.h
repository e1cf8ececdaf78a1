/* Trapezoid of speed over time, in ticks of 1 ms; ends on its target to the count. */
#ifndef AGRIK_PROFILE_H
#define AGRIK_PROFILE_H

#include <stdint.h>

enum profile_phase { PROFILE_DONE, PROFILE_RISE, PROFILE_CRUISE, PROFILE_FALL, PROFILE_BRAKE };

/* Speeds are counts a tick times 2^24. */
struct profile {
    int32_t position; /* counts */
    uint32_t fraction; /* of a count, times 2^24 */
    int32_t speed;
    int32_t step; /* change of speed a tick */
    int32_t target;
    uint32_t rise;  /* ticks of rise, and of fall */
    uint32_t cruise;
    uint32_t left;  /* ticks of the present phase */
    uint8_t phase;
};

/* From rest at the present position to `target`. `speed` (counts/s) and `acceleration`
 * (counts/s^2) are above 0 and never exceeded. */
void profile_start(struct profile *profile, int32_t target, uint16_t speed, uint32_t acceleration);

/* Slows down as it rose; the target becomes where it stands then. */
void profile_brake(struct profile *profile);

void profile_tick(struct profile *profile);

/* Stands at `position`. */
void profile_set(struct profile *profile, int32_t position);

#endif
