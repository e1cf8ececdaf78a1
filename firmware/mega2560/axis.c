#include "axis.h"

#define SETTLE_TICKS 20
#define SETTLE_LONGEST 2000
/* A slide that the motor pushes with more than half its force and that moves less than
 * STALL_COUNTS in 4 ticks stands. */
#define STALL_OUTPUT (PID_MAX / 2)
#define STALL_COUNTS 2
#define STALL_TICKS 100
/* So long without moving, and a lag beyond the limit is a stall. */
#define STALL_SUSPECT 8
/* Contacts bounce. */
#define PRESSED_TICKS 3

static uint32_t acceleration(const struct axis *axis)
{
    return (uint32_t)axis->config.acceleration * 16;
}

static void begin(struct axis *axis, uint8_t phase, int32_t target, uint16_t speed)
{
    if (axis->phase == AXIS_OFF) {
        profile_set(&axis->profile, axis->position);
        axis->pid.integral = 0;
        axis->pushing = 0;
    }
    profile_start(&axis->profile, target, speed, acceleration(axis));
    axis->phase = phase;
    axis->settled = axis->waited = 0;
}

static void fail(struct axis *axis, uint8_t fault)
{
    axis->fault = fault;
    axis_off(axis);
}

uint8_t axis_configure(struct axis *axis, const struct msg_configure *config)
{
    if (axis_busy(axis))
        return CODE_WRONG_STATE;
    if (config->lower > config->upper || !config->acceleration || !config->fast ||
        !config->slow || !config->following || !config->settle)
        return CODE_MALFORMED;
    axis->config = *config;
    axis->gains = (struct gains){config->kp, config->ki, config->kd, config->kv, config->friction};
    axis->configured = 1;
    return CODE_OK;
}

uint8_t axis_move(struct axis *axis, int32_t target, uint16_t speed)
{
    if (!axis->configured)
        return CODE_NOT_CONFIGURED;
    if (!axis->homed)
        return CODE_NOT_HOMED;
    if (axis_busy(axis))
        return CODE_WRONG_STATE;
    if (!speed)
        return CODE_MALFORMED;
    if (target < axis->config.lower || target > axis->config.upper)
        return CODE_OUT_OF_LIMITS;
    begin(axis, AXIS_MOVE, target, speed);
    return CODE_OK;
}

uint8_t axis_home(struct axis *axis)
{
    if (!axis->configured)
        return CODE_NOT_CONFIGURED;
    if (axis_busy(axis))
        return CODE_WRONG_STATE;
    axis->homed = 0;
    axis->origin = axis->position;
    begin(axis, AXIS_BACK_OFF, axis->position, axis->config.fast);
    return CODE_OK;
}

void axis_stop(struct axis *axis)
{
    if (!axis_busy(axis))
        return;
    axis->phase = AXIS_MOVE;
    profile_brake(&axis->profile);
}

void axis_off(struct axis *axis)
{
    axis->phase = AXIS_OFF;
    axis->output = 0;
    profile_set(&axis->profile, axis->position);
}

static int32_t travel(const struct axis *axis)
{
    int32_t length = axis->config.upper - axis->config.lower;
    return length + length / 8 + 4 * (int32_t)axis->config.clearance;
}

/* Where homing is and where it goes next; `arrived` if the slide stands at its target. */
static void home(struct axis *axis, uint8_t pressed, uint8_t arrived)
{
    int32_t clearance = axis->config.clearance;
    switch (axis->phase) {
    case AXIS_BACK_OFF:
        if (!pressed && arrived)
            begin(axis, AXIS_SEEK, axis->position - travel(axis), axis->config.fast);
        else if (pressed && arrived) {
            if (axis->position - axis->origin >= 3 * clearance)
                fail(axis, FAULT_SWITCH_STUCK);
            else
                begin(axis, AXIS_BACK_OFF, axis->position + 2 * clearance, axis->config.fast);
        }
        break;
    case AXIS_SEEK:
        if (pressed && axis->profile.phase != PROFILE_BRAKE && axis->profile.phase != PROFILE_DONE)
            profile_brake(&axis->profile);
        else if (arrived && !pressed)
            fail(axis, FAULT_SWITCH_NOT_FOUND);
        else if (arrived)
            begin(axis, AXIS_RETREAT, axis->position + 2 * clearance, axis->config.fast);
        break;
    case AXIS_RETREAT:
        if (arrived && pressed)
            fail(axis, FAULT_SWITCH_STUCK);
        else if (arrived)
            begin(axis, AXIS_APPROACH, axis->position - 4 * clearance, axis->config.slow);
        break;
    case AXIS_APPROACH:
        if (pressed && axis->profile.phase != PROFILE_BRAKE && axis->profile.phase != PROFILE_DONE) {
            axis->origin = axis->position;
            profile_brake(&axis->profile);
        } else if (arrived && !pressed)
            fail(axis, FAULT_SWITCH_NOT_FOUND);
        else if (arrived)
            begin(axis, AXIS_LEAVE, axis->origin + clearance, axis->config.fast);
        break;
    case AXIS_LEAVE:
        if (!arrived)
            break;
        if (pressed) {
            fail(axis, FAULT_SWITCH_STUCK);
            break;
        }
        axis->position -= axis->origin + clearance;
        axis->homed = 1;
        axis_off(axis);
        break;
    default:
        break;
    }
}

static uint8_t settled(struct axis *axis, int32_t lag, int16_t moved)
{
    if (axis->profile.phase != PROFILE_DONE) {
        axis->settled = axis->waited = 0;
        return 0;
    }
    uint8_t near = lag <= (int32_t)axis->config.settle && -lag <= (int32_t)axis->config.settle &&
                   moved <= STALL_COUNTS && moved >= -STALL_COUNTS;
    axis->settled = near ? axis->settled + 1 : 0;
    if (axis->waited < UINT16_MAX)
        axis->waited++;
    return axis->settled >= SETTLE_TICKS;
}

void axis_tick(struct axis *axis, int16_t counts, uint8_t pressed)
{
    axis->position += counts;
    axis->last[axis->at] = counts;
    axis->at = (axis->at + 1) & 3;
    axis->pressed = !pressed ? 0 : axis->pressed < PRESSED_TICKS ? axis->pressed + 1 : axis->pressed;
    if (!axis_busy(axis))
        return;
    int16_t moved = (int16_t)(axis->last[0] + axis->last[1] + axis->last[2] + axis->last[3]);

    profile_tick(&axis->profile);
    int32_t lag = axis->profile.position - axis->position;
    axis->output = pid_tick(&axis->pid, &axis->gains, lag, axis->profile.speed, moved);

    uint8_t pushed = axis->output > STALL_OUTPUT || axis->output < -STALL_OUTPUT;
    uint8_t stands = moved < STALL_COUNTS && moved > -STALL_COUNTS;
    axis->pushing = pushed && stands ? axis->pushing + 1 : 0;
    uint8_t homing = axis_homing(axis);
    if (lag > (int32_t)axis->config.following || -lag > (int32_t)axis->config.following) {
        uint8_t against = (axis->output > 0) == (moved < 0) && moved;
        if (axis->pushing >= STALL_SUSPECT)
            fail(axis, homing ? FAULT_SWITCH_NOT_FOUND : FAULT_STALL);
        else
            fail(axis, against ? FAULT_ENCODER : FAULT_FOLLOWING);
        return;
    }
    if (axis->pushing >= STALL_TICKS) {
        fail(axis, homing ? FAULT_SWITCH_NOT_FOUND : FAULT_STALL);
        return;
    }
    uint8_t down = axis->pressed >= PRESSED_TICKS;
    uint8_t arrived = settled(axis, lag, moved);
    if (homing) {
        home(axis, down, arrived);
    } else if (down && axis->homed) {
        fail(axis, FAULT_LIMIT_SWITCH);
    } else if (arrived) {
        axis_off(axis);
    }
    if (axis_busy(axis) && axis->waited >= SETTLE_LONGEST)
        fail(axis, FAULT_STALL);
}
