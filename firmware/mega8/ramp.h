/* A pulse that goes to its target at a limited rate. Half microseconds, times 2^8. */
#ifndef AGRIK_RAMP_H
#define AGRIK_RAMP_H

#include <stdint.h>

struct ramp {
    uint32_t now;
    uint32_t target;
};

static inline uint8_t ramp_arrived(const struct ramp *ramp)
{
    return ramp->now == ramp->target;
}

/* Every millisecond; `rate` is half microseconds a millisecond, times 2^8. */
static inline void ramp_tick(struct ramp *ramp, uint16_t rate)
{
    if (ramp->now < ramp->target)
        ramp->now = ramp->target - ramp->now > rate ? ramp->now + rate : ramp->target;
    else
        ramp->now = ramp->now - ramp->target > rate ? ramp->now - rate : ramp->target;
}

#endif
