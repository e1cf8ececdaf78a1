#include "servo.h"

void servo_init(struct servo *servo, uint64_t seed)
{
    *servo = (struct servo){
        .zero_us = 1500.0,
        .us_per_degree = 10.0,
        .rate = 60.0 / 0.21,
        .dead_band = 4.0,
        .low = -95.0,
        .high = 95.0,
        .random = seed * 2 + 1,
    };
}

void servo_edge(struct servo *servo, uint64_t cycle, int level, double cycles_per_us)
{
    if (level) {
        servo->rise = cycle;
        return;
    }
    if (!servo->rise)
        return;
    double width = (double)(cycle - servo->rise) / cycles_per_us;
    servo->rise = 0;
    /* Shorter or longer ones are no command. */
    if (width < 400.0 || width > 2600.0)
        return;
    servo->pulse = width;
    servo->seen = cycle;
    servo->pulses++;
}

/* Near enough to normal, of mean 0 and deviation 1: the sum of twelve uniform numbers. */
static double normal(struct servo *servo)
{
    double sum = -6.0;
    for (int i = 0; i < 12; i++) {
        servo->random = servo->random * 6364136223846793005u + 1442695040888963407u;
        sum += (double)(servo->random >> 33) / 2147483648.0;
    }
    return sum;
}

void servo_step(struct servo *servo, double seconds)
{
    if (servo->pulse != 0.0) {
        double target = (servo->pulse - servo->zero_us) / servo->us_per_degree;
        double dead = servo->dead_band / (servo->us_per_degree < 0 ? -servo->us_per_degree
                                                                   : servo->us_per_degree);
        double most = servo->rate * seconds, off = target - servo->angle;
        if (off > dead)
            servo->angle += off - dead < most ? off - dead : most;
        else if (off < -dead)
            servo->angle -= -off - dead < most ? -off - dead : most;
        if (servo->angle < servo->low)
            servo->angle = servo->low;
        if (servo->angle > servo->high)
            servo->angle = servo->high;
    }
    servo->shown = servo->angle - servo->load;
    if (servo->noise != 0.0)
        servo->shown += servo->noise * normal(servo);
}
