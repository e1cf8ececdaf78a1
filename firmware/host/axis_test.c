#include <string.h>

#include "axis.h"
#include "check.h"
#include "quadrature.h"
#include "ramp.h"
#include "slide.h"

void test_quadrature(void)
{
    static const uint8_t up[] = {0, 1, 3, 2};
    for (int i = 0; i < 4; i++) {
        uint8_t now = up[i], next = up[(i + 1) & 3], across = up[(i + 2) & 3];
        CHECK(quadrature_steps[now << 2 | next] == 1);
        CHECK(quadrature_steps[next << 2 | now] == -1);
        CHECK(quadrature_steps[now << 2 | now] == 0);
        CHECK(quadrature_steps[now << 2 | across] == QUADRATURE_SKIP);
    }
}

static uint32_t random_state = 7;

static uint32_t draw(uint32_t below)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)(random_state >> 4) * below) >> 28);
}

void test_profile(void)
{
    for (int round = 0; round < 3000; round++) {
        struct profile profile;
        int32_t from = (int32_t)draw(200000) - 100000, to = (int32_t)draw(200000) - 100000;
        if (round % 3 == 0)
            to = from + (int32_t)draw(9) - 4; /* short ways */
        uint16_t speed = (uint16_t)(50 + draw(65000));
        uint32_t acceleration = 1000 + draw(900000);
        profile_set(&profile, from);
        profile_start(&profile, to, speed, acceleration);
        double distance = to > from ? to - from : from - to, ticks = 0, last = 0;
        double most = speed * 1.000001 / 1000, change = acceleration * 1.000001 / 1e6;
        while (profile.phase != PROFILE_DONE) {
            double before = profile.position + profile.fraction / 16777216.0;
            profile_tick(&profile);
            double now = profile.position + profile.fraction / 16777216.0, step = now - before;
            CHECK(to > from ? step > -1e-3 : step < 1e-3);
            CHECK(step <= most + 0.1 && step >= -most - 0.1); /* the last tick rounds */
            double bend = step - last;
            if (profile.phase != PROFILE_DONE)
                CHECK(bend <= change + 1e-6 && bend >= -change - 1e-6);
            last = step;
            CHECK(++ticks < 1e7);
        }
        CHECK(profile.position == to && profile.speed == 0);
        /* No slower than the trapezoid that the rounding up of its pieces allows. */
        CHECK(ticks <= distance * 1000 / speed + speed * 1000.0 / acceleration + 4 ||
              distance * 1e6 / acceleration < (speed * 1000.0 / acceleration + 1) *
                                                  (speed * 1000.0 / acceleration + 1));
    }
    /* Braking ends without a jump and without turning round. */
    for (int at = 1; at < 900; at += 7) {
        struct profile profile;
        profile_set(&profile, 0);
        profile_start(&profile, -20000, 21474, 85896);
        for (int i = 0; i < at; i++)
            profile_tick(&profile);
        int32_t before = profile.position;
        profile_brake(&profile);
        for (int i = 0; i < 260; i++) {
            CHECK(profile.speed <= 0);
            profile_tick(&profile);
        }
        CHECK(profile.phase == PROFILE_DONE && profile.target == profile.position);
        CHECK(profile.position <= before && before - profile.position < 2800);
    }
}

void test_pid(void)
{
    struct gains gains = {716, 1831, 1341, 319, 95};
    struct pid pid = {0};
    CHECK(pid_tick(&pid, &gains, 0, 0, 0) == 0);
    CHECK(pid_tick(&pid, &gains, 2000000, 0, 0) == PID_MAX);
    CHECK(pid_tick(&pid, &gains, -2000000, 0, 0) == -PID_MAX);
    /* What the motor could not give has not piled up. */
    CHECK(pid.integral == 0);
    for (int i = 0; i < 10000; i++)
        pid_tick(&pid, &gains, 10, 0, 0);
    CHECK(pid.integral <= (int32_t)PID_MAX << 16);
    /* The largest numbers of a calibration do not overflow. */
    struct gains largest = {65535, 65535, 65535, 65535, 65535};
    for (int32_t lag = -70000; lag <= 70000; lag += 777)
        for (int32_t speed = -1; speed <= 1; speed++) {
            int16_t output = pid_tick(&pid, &largest, lag, speed * 1090519040, (int16_t)lag);
            CHECK(output <= PID_MAX && output >= -PID_MAX);
        }
}

/* ---- an axis on a simulated slide -------------------------------------------------------------- */

struct bench {
    struct axis axis;
    struct slide slide;
    int64_t count;
};

static void bench_init(struct bench *bench)
{
    memset(bench, 0, sizeof *bench);
    slide_init(&bench->slide);
    bench->slide.carriage = 25.0;
    struct msg_configure config = {
        .lower = 0, .upper = 60000, .acceleration = 5368, .fast = 6442, .slow = 1074,
        .clearance = 859, .following = 537, .settle = 21,
        .kp = 715, .ki = 1831, .kd = 1341, .kv = 319, .friction = 95};
    CHECK(axis_configure(&bench->axis, &config) == CODE_OK);
}

static void bench_tick(struct bench *bench)
{
    for (int i = 0; i < 40; i++) {
        slide_step(&bench->slide, 25e-6, bench->axis.output / 800.0);
        slide_channels(&bench->slide);
    }
    int64_t count = bench->slide.count;
    axis_tick(&bench->axis, (int16_t)(count - bench->count), (uint8_t)slide_pressed(&bench->slide));
    bench->count = count;
}

static int bench_run(struct bench *bench, int longest)
{
    int ticks = 0;
    while (axis_busy(&bench->axis) && ticks < longest) {
        bench_tick(bench);
        ticks++;
    }
    return ticks;
}

void test_axis(void)
{
    struct bench bench;
    struct axis *axis = &bench.axis;
    memset(&bench, 0, sizeof bench);
    CHECK(axis_move(axis, 10, 1000) == CODE_NOT_CONFIGURED);
    CHECK(axis_home(axis) == CODE_NOT_CONFIGURED);
    bench_init(&bench);
    struct msg_configure wrong = axis->config;
    wrong.acceleration = 0;
    CHECK(axis_configure(axis, &wrong) == CODE_MALFORMED);
    CHECK(axis_move(axis, 10, 1000) == CODE_NOT_HOMED);

    CHECK(axis_home(axis) == CODE_OK);
    CHECK(axis_home(axis) == CODE_WRONG_STATE && axis_configure(axis, &wrong) == CODE_WRONG_STATE);
    bench_run(&bench, 20000);
    CHECK(axis->homed && !axis->fault && !slide_pressed(&bench.slide));
    CHECK(bench.slide.carriage > -2.0 && bench.slide.carriage < 1.0);
    CHECK(axis->position > -22 && axis->position < 22);

    CHECK(axis_move(axis, 60001, 21474) == CODE_OUT_OF_LIMITS);
    CHECK(axis_move(axis, -1, 21474) == CODE_OUT_OF_LIMITS);
    CHECK(axis_move(axis, 10737, 0) == CODE_MALFORMED);
    CHECK(axis_move(axis, 10737, 21474) == CODE_OK);
    CHECK(axis_move(axis, 20, 21474) == CODE_WRONG_STATE);
    int ticks = bench_run(&bench, 3000);
    CHECK(ticks < 900 && !axis->fault);
    CHECK(axis->position > 10737 - 22 && axis->position < 10737 + 22);

    /* Stopped on the way it stands, homed still. */
    CHECK(axis_move(axis, 50000, 21474) == CODE_OK);
    for (int i = 0; i < 600; i++)
        bench_tick(&bench);
    axis_stop(axis);
    bench_run(&bench, 1000);
    CHECK(axis->homed && !axis->fault && axis->position < 30000);

    /* Jammed on the way: a stall, within a tenth of a second. */
    CHECK(axis_move(axis, 50000, 21474) == CODE_OK);
    for (int i = 0; i < 400; i++)
        bench_tick(&bench);
    bench.slide.jammed = 1;
    CHECK(bench_run(&bench, 1000) < 100);
    CHECK(axis->fault == FAULT_STALL && axis->output == 0);
    bench.slide.jammed = 0;
    axis->fault = 0;

    /* Jammed from the start. */
    bench.slide.jammed = 1;
    CHECK(axis_move(axis, 100, 21474) == CODE_OK);
    CHECK(bench_run(&bench, 4000) < 400 && axis->fault == FAULT_STALL);
    bench.slide.jammed = 0;
    axis->fault = 0;

    /* A switch that is pressed during a move. */
    CHECK(axis_move(axis, 100, 21474) == CODE_OK);
    for (int i = 0; i < 100; i++)
        bench_tick(&bench);
    bench.slide.stuck = 1;
    CHECK(bench_run(&bench, 100) <= 3 && axis->fault == FAULT_LIMIT_SWITCH);
    axis->fault = 0;

    /* Homing with a switch that is always pressed, and with one that never is. */
    CHECK(axis_home(axis) == CODE_OK);
    bench_run(&bench, 20000);
    CHECK(axis->fault == FAULT_SWITCH_STUCK && !axis->homed);
    bench.slide.stuck = -1;
    axis->fault = 0;
    CHECK(axis_home(axis) == CODE_OK);
    bench_run(&bench, 20000);
    CHECK(axis->fault == FAULT_SWITCH_NOT_FOUND && !axis->homed);
    bench.slide.stuck = 0;
    axis->fault = 0;

    /* From the switch itself. */
    CHECK(axis_home(axis) == CODE_OK);
    bench_run(&bench, 20000);
    CHECK(axis->homed && !axis->fault);

    /* An encoder whose channels are exchanged. */
    CHECK(axis_move(axis, 30000, 21474) == CODE_OK);
    int64_t count = bench.count;
    for (int i = 0; i < 1000 && axis_busy(axis); i++) {
        slide_step(&bench.slide, 1e-3, axis->output / 800.0);
        for (int k = 0; k < 50; k++)
            slide_channels(&bench.slide);
        axis_tick(axis, (int16_t)(count - bench.slide.count), 0);
        count = bench.slide.count;
    }
    CHECK(axis->fault == FAULT_ENCODER);
}

void test_ramp(void)
{
    struct ramp ramp = {3000 << 8, 3000 << 8};
    CHECK(ramp_arrived(&ramp));
    ramp.target = 3100 << 8;
    int ticks = 0;
    for (; !ramp_arrived(&ramp); ticks++) {
        uint32_t before = ramp.now;
        ramp_tick(&ramp, 261);
        CHECK(ramp.now > before && ramp.now - before <= 261);
    }
    CHECK(ticks == 99);
    ramp.target = 2990 << 8;
    while (!ramp_arrived(&ramp))
        ramp_tick(&ramp, 261);
    CHECK(ramp.now == 2990 << 8);
}
