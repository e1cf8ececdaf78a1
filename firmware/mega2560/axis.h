/* One slide: homing, moves and their faults. Knows no registers, so that it also runs on a host. */
#ifndef AGRIK_AXIS_H
#define AGRIK_AXIS_H

#include <stdint.h>

#include "messages.h"
#include "pid.h"
#include "profile.h"

enum axis_phase {
    AXIS_OFF,      /* the motor has no current, friction holds the slide */
    AXIS_MOVE,     /* to a target */
    AXIS_BACK_OFF, /* homing: off the switch, if it is pressed at the start */
    AXIS_SEEK,     /* towards the switch, fast */
    AXIS_RETREAT,  /* off it again */
    AXIS_APPROACH, /* towards it, slowly */
    AXIS_LEAVE,    /* to home, off the switch */
};

struct axis {
    struct msg_configure config;
    struct gains gains;
    struct profile profile;
    struct pid pid;
    int32_t position; /* counts */
    int32_t origin;   /* homing: where the phase began, later where the switch is */
    int16_t last[4];  /* counts of the last ticks */
    int16_t output;
    uint16_t settled; /* ticks near the target */
    uint16_t waited;  /* ticks since the command arrived */
    uint16_t pushing; /* ticks of pushing without moving */
    uint8_t at;
    uint8_t pressed;  /* ticks in a row that the switch is pressed */
    uint8_t phase;
    uint8_t configured;
    uint8_t homed;
    uint8_t fault;
};

/* All return a code of messages.toml. */
uint8_t axis_configure(struct axis *axis, const struct msg_configure *config);
uint8_t axis_move(struct axis *axis, int32_t target, uint16_t speed);
uint8_t axis_home(struct axis *axis);

/* Slows down and stays where it ends. */
void axis_stop(struct axis *axis);

/* No current, now. */
void axis_off(struct axis *axis);

/* Every millisecond: `counts` moved since the last tick, and whether the switch is pressed. The
 * outcome is in `output`, `phase` and `fault`. */
void axis_tick(struct axis *axis, int16_t counts, uint8_t pressed);

static inline uint8_t axis_busy(const struct axis *axis)
{
    return axis->phase != AXIS_OFF;
}

static inline uint8_t axis_homing(const struct axis *axis)
{
    return axis->phase >= AXIS_BACK_OFF;
}

#endif
