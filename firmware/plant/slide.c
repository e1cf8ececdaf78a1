#include "slide.h"

void slide_init(struct slide *slide)
{
    *slide = (struct slide){
        .top_speed = 372.5,
        .time_constant = 0.04,
        .friction = 0.12,
        .play = 1.0,
        .pitch = 1.0,
        .counts_per_mm = 107.37,
        .switch_at = -8.0,
        .low = -14.0,
        .high = 1000.0,
    };
}

static int64_t whole_counts(const struct slide *slide)
{
    double counts = slide->motor * slide->counts_per_mm;
    int64_t whole = (int64_t)counts;
    return whole - (whole > counts);
}

static void pull_belt(struct slide *slide)
{
    double before = slide->belt;
    if (slide->motor - slide->belt > slide->play)
        slide->belt = slide->motor - slide->play;
    else if (slide->motor < slide->belt)
        slide->belt = slide->motor;
    slide->carriage += (slide->belt - before) * slide->pitch * (1.0 - slide->slip);
}

void slide_step(struct slide *slide, double seconds, double voltage)
{
    double stall = slide->top_speed / slide->time_constant; /* mm/s^2 */
    double push = (voltage + slide->weight) * stall - slide->speed / slide->time_constant;
    double friction = slide->friction * stall;
    double speed = slide->speed;
    if (speed == 0.0) {
        if (push > friction)
            speed = (push - friction) * seconds;
        else if (push < -friction)
            speed = (push + friction) * seconds;
    } else {
        speed += (push + (speed > 0.0 ? -friction : friction)) * seconds;
        /* Friction stops, it does not turn round. */
        if (speed * slide->speed < 0.0)
            speed = 0.0;
    }
    int ended = (slide->carriage <= slide->low && speed < 0.0) ||
                (slide->carriage >= slide->high && speed > 0.0);
    slide->speed = slide->jammed != 0.0 || ended ? 0.0 : speed;
    slide->motor += slide->speed * seconds;
    pull_belt(slide);
}

unsigned slide_channels(struct slide *slide)
{
    static const unsigned gray[4] = {0, 1, 3, 2};
    int64_t now = whole_counts(slide);
    slide->count += (now > slide->count) - (now < slide->count);
    return gray[slide->count & 3];
}

int slide_pressed(const struct slide *slide)
{
    if (slide->stuck != 0.0)
        return slide->stuck > 0.0;
    return slide->carriage <= slide->switch_at;
}

int slide_moves(const struct slide *slide)
{
    return slide->speed != 0.0 || whole_counts(slide) != slide->count;
}
