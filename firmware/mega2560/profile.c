#include "profile.h"

#define FRACTION_BITS 24

static uint32_t root_rounded_up(uint64_t square)
{
    uint32_t low = 0, high = UINT32_C(1) << 24;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if ((uint64_t)middle * middle < square)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static uint32_t divided_up(uint64_t dividend, uint32_t divisor)
{
    return (uint32_t)((dividend + divisor - 1) / divisor);
}

void profile_set(struct profile *profile, int32_t position)
{
    profile->position = profile->target = position;
    profile->fraction = 0;
    profile->speed = 0;
    profile->phase = PROFILE_DONE;
}

void profile_start(struct profile *profile, int32_t target, uint16_t speed, uint32_t acceleration)
{
    int32_t way = target - profile->position;
    uint32_t distance = way < 0 ? -(uint32_t)way : (uint32_t)way;
    profile_set(profile, profile->position);
    if (!distance)
        return;
    /* n ticks of rise, m until the fall begins, n of fall: the speeds a, 2a .. na, na .. na,
     * (n-1)a .. 0 add up to a n m. Rounding n and m up keeps speed and acceleration below what
     * was asked, and a is what makes the sum the distance. */
    uint32_t n = divided_up((uint64_t)speed * 1000, acceleration);
    uint32_t m = divided_up((uint64_t)distance * 1000, speed);
    if (m < n)
        n = m = root_rounded_up(divided_up((uint64_t)distance * 1000000, acceleration));
    int32_t step = (int32_t)(((uint64_t)distance << FRACTION_BITS) / ((uint64_t)n * m));
    profile->target = target;
    profile->step = way < 0 ? -step : step;
    profile->rise = profile->left = n;
    profile->cruise = m - n;
    profile->phase = PROFILE_RISE;
}

void profile_brake(struct profile *profile)
{
    if (profile->phase == PROFILE_DONE)
        return;
    if (profile->step && (profile->step < 0) == (profile->speed > 0))
        profile->step = -profile->step;
    profile->phase = PROFILE_BRAKE;
}

static void advance(struct profile *profile)
{
    int32_t sum = (int32_t)profile->fraction + (profile->speed & ((INT32_C(1) << FRACTION_BITS) - 1));
    profile->position += (profile->speed >> FRACTION_BITS) + (sum >> FRACTION_BITS);
    profile->fraction = (uint32_t)sum & ((UINT32_C(1) << FRACTION_BITS) - 1);
}

void profile_tick(struct profile *profile)
{
    switch (profile->phase) {
    case PROFILE_RISE:
        profile->speed += profile->step;
        break;
    case PROFILE_FALL:
        profile->speed -= profile->step;
        break;
    case PROFILE_BRAKE: {
        int32_t next = profile->speed - profile->step;
        if (profile->step == 0 || (next > 0) != (profile->speed > 0) || next == 0) {
            profile_set(profile, profile->position);
            return;
        }
        profile->speed = next;
        advance(profile);
        return;
    }
    case PROFILE_DONE:
        return;
    default:
        break;
    }
    advance(profile);
    if (--profile->left)
        return;
    if (profile->phase == PROFILE_RISE) {
        profile->phase = profile->cruise ? PROFILE_CRUISE : PROFILE_FALL;
        profile->left = profile->cruise ? profile->cruise : profile->rise;
    } else if (profile->phase == PROFILE_CRUISE) {
        profile->phase = PROFILE_FALL;
        profile->left = profile->rise;
    } else {
        profile_set(profile, profile->target);
    }
}
