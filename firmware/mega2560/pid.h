/* Position control of a motor: PID on the lag, with the commanded speed fed forward. */
#ifndef AGRIK_PID_H
#define AGRIK_PID_H

#include <stdint.h>

/* Largest output: just short of always on, which a 1 cycle longer pulse would be. */
#define PID_MAX 798

/* As `configure` of messages.toml has them. */
struct gains {
    uint16_t kp, ki, kd, kv, friction;
};

struct pid {
    int32_t integral; /* PWM times 2^16 */
};

/* Returns the output, -PID_MAX to PID_MAX. `lag` in counts; `speed` commanded, counts a tick
 * times 2^24; `moved`: counts in the last 4 ticks. */
int16_t pid_tick(struct pid *pid, const struct gains *gains, int32_t lag, int32_t speed,
                 int16_t moved);

#endif
