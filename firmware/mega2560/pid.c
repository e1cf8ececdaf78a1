#include "pid.h"

static int32_t clamped(int32_t value, int32_t limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

int16_t pid_tick(struct pid *pid, const struct gains *gains, int32_t lag, int32_t speed,
                 int16_t moved)
{
    /* Shifts by whole bytes: this processor moves one bit at a time, and divides far slower. */
    int16_t error = (int16_t)clamped(lag, 0x7FFF);
    int16_t wanted = (int16_t)((int16_t)(speed >> 16) >> 4); /* times 2^4 */
    int16_t behind = (int16_t)(wanted - (int16_t)clamped(moved, 4000) * 4);
    int32_t output = ((int32_t)gains->kp * error) >> 8;
    output += ((int32_t)gains->kv * wanted) >> 8;
    output += ((int32_t)gains->kd * behind) >> 8;
    if (speed)
        output += speed > 0 ? gains->friction : -(int32_t)gains->friction;
    output += pid->integral >> 16;
    int16_t limited = (int16_t)clamped(output, PID_MAX);
    /* What the motor cannot give must not pile up. */
    if (limited == output)
        pid->integral = clamped(pid->integral + (int32_t)gains->ki * (int16_t)clamped(error, 1000),
                                (int32_t)PID_MAX << 16);
    return limited;
}
