/* simulator BOARD ELF [--pty]: a rig that other programs drive by lines on standard input.
 *
 * run CYCLES STOP HEX  put bytes on the line and let time pass; with STOP 1 no further than to
 *                      the end of a frame. Answer: cycle, bytes that came, totals in and out.
 * set NAME VALUE       a number of the plant, such as slide0.jammed, servo2.noise, estop, cable
 * state                all of them that say where the rig is
 * trace FILE US        a row of CSV every so many microseconds; `trace - 0` ends it
 *
 * Otherwise time stands still, so that a run is the same bits every time. With --pty the line is
 * a pseudoterminal, whose name is printed first, and time passes as on the wall. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "rig.h"

static struct rig rig;
static FILE *trace;
static uint64_t trace_every, trace_next;

struct number {
    const char *name;
    size_t at;
};

static const struct number slide_numbers[] = {
#define NUMBER(field) {#field, offsetof(struct slide, field)}
    NUMBER(top_speed), NUMBER(time_constant), NUMBER(friction), NUMBER(weight),
    NUMBER(play), NUMBER(pitch), NUMBER(slip), NUMBER(counts_per_mm),
    NUMBER(switch_at), NUMBER(low), NUMBER(high), NUMBER(jammed), NUMBER(stuck),
    NUMBER(carriage),
#undef NUMBER
};

static const struct number servo_numbers[] = {
#define NUMBER(field) {#field, offsetof(struct servo, field)}
    NUMBER(zero_us), NUMBER(us_per_degree), NUMBER(rate), NUMBER(dead_band),
    NUMBER(noise), NUMBER(low), NUMBER(high), NUMBER(angle),
#undef NUMBER
};

static double *find(void *object, const struct number *numbers, size_t count, const char *name)
{
    for (size_t i = 0; i < count; i++)
        if (!strcmp(numbers[i].name, name))
            return (double *)((char *)object + numbers[i].at);
    return NULL;
}

static double *number(const char *name)
{
    unsigned index;
    char field[32];
#define COUNT(array) (sizeof array / sizeof *array)
    if (sscanf(name, "slide%1u.%31s", &index, field) == 2 && index < SLIDES)
        return find(&rig.slides[index], slide_numbers, COUNT(slide_numbers), field);
    if (sscanf(name, "servo%1u.%31s", &index, field) == 2 && index < SERVOS)
        return find(&rig.servos[index], servo_numbers, COUNT(servo_numbers), field);
    if (!strcmp(name, "estop"))
        return &rig.estop;
    if (!strcmp(name, "cable"))
        return &rig.cable;
    if (!strcmp(name, "droop0"))
        return &rig.droop[0];
    if (!strcmp(name, "droop1"))
        return &rig.droop[1];
    return NULL;
}

static void print_state(void)
{
    printf("cycle=%llu slept=%llu resets=%llu", (unsigned long long)rig.avr->cycle,
           (unsigned long long)rig.slept, (unsigned long long)rig.resets);
    for (int i = 0; i < SLIDES; i++)
        printf(" carriage%d=%.17g motor%d=%.17g speed%d=%.17g count%d=%lld driven%d=%d "
               "last_drive%d=%llu pressed%d=%d",
               i, rig.slides[i].carriage, i, rig.slides[i].motor, i, rig.slides[i].speed, i,
               (long long)rig.slides[i].count, i, rig.driven[i], i,
               (unsigned long long)rig.last_drive[i], i, slide_pressed(&rig.slides[i]));
    for (int i = 0; i < SERVOS; i++)
        printf(" angle%d=%.17g pulse%d=%.17g pulses%d=%.0f seen%d=%llu", i, rig.servos[i].shown, i,
               rig.servos[i].pulse, i, rig.servos[i].pulses, i,
               (unsigned long long)rig.servos[i].seen);
    putchar('\n');
}

static void trace_row(void)
{
    fprintf(trace, "%.6f", (double)rig.avr->cycle / 16e6);
    for (int i = 0; i < SLIDES; i++)
        fprintf(trace, ",%lld,%.4f", (long long)rig.slides[i].count, rig.slides[i].carriage);
    for (int i = 0; i < SERVOS; i++)
        fprintf(trace, ",%.3f", rig.servos[i].shown);
    fputc('\n', trace);
}

static void start_trace(const char *file, double every_us)
{
    if (trace)
        fclose(trace);
    trace = strcmp(file, "-") ? fopen(file, "w") : NULL;
    if (strcmp(file, "-") && !trace) {
        printf("error cannot write %s: %s\n", file, strerror(errno));
        return;
    }
    if (trace) {
        fputs("time_s", trace);
        for (int i = 0; i < SLIDES; i++)
            fprintf(trace, ",count%d,carriage%d_mm", i, i);
        for (int i = 0; i < SERVOS; i++)
            fprintf(trace, ",servo%d_deg", i);
        fputc('\n', trace);
        trace_every = (uint64_t)(every_us * CYCLES_PER_US);
        trace_next = rig.avr->cycle;
    }
    puts("ok");
}

/* Runs in pieces where a trace wants its rows. */
static int pass(uint64_t until, int stop)
{
    if (!trace)
        return rig_run(&rig, until, stop);
    while (rig.avr->cycle < until) {
        if (rig.avr->cycle >= trace_next) {
            trace_row();
            trace_next += trace_every;
        }
        uint64_t to = until < trace_next ? until : trace_next;
        if (!rig_run(&rig, to, stop))
            return 0;
        if (rig.avr->cycle < to)
            return 1;
    }
    return 1;
}

static void exchange(uint64_t cycles, int stop, const char *hex)
{
    unsigned byte;
    for (; sscanf(hex, "%2x", &byte) == 1; hex += 2)
        rig_send(&rig, byte);
    if (!pass(rig.avr->cycle + cycles, stop)) {
        puts("error the board's program ended");
        return;
    }
    printf("%llu ", (unsigned long long)rig.avr->cycle);
    int next = rig_take(&rig);
    if (next < 0)
        putchar('-');
    for (; next >= 0; next = rig_take(&rig))
        printf("%02x", next);
    printf(" %llu %llu\n", (unsigned long long)rig.taken, (unsigned long long)rig.given);
}

/* Returns 0 at the end of the input. */
static int serve_line(void)
{
    static char line[16384], name[1024], hex[16384];
    unsigned long long cycles;
    int stop;
    double value;
    if (!fgets(line, sizeof line, stdin))
        return 0;
    hex[0] = 0;
    if (sscanf(line, "run %llu %d %16383s", &cycles, &stop, hex) >= 2)
        exchange(cycles, stop, hex);
    else if (sscanf(line, "set %1023s %lf", name, &value) == 2) {
        double *place = number(name);
        if (place)
            *place = value;
        puts(place ? "ok" : "error no such number");
    } else if (!strncmp(line, "state", 5))
        print_state();
    else if (sscanf(line, "trace %1023s %lf", name, &value) == 2)
        start_trace(name, value);
    else
        puts("error no such command");
    fflush(stdout);
    return 1;
}

static double wall(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int serve_pty(void)
{
    int ours, theirs;
    char name[256];
    struct termios raw;
    if (openpty(&ours, &theirs, name, NULL, NULL) || tcgetattr(theirs, &raw)) {
        perror("simulator: no pseudoterminal");
        return 2;
    }
    cfmakeraw(&raw);
    tcsetattr(theirs, TCSANOW, &raw);
    fcntl(ours, F_SETFL, O_NONBLOCK);
    /* Our hold on the other end: whoever closes it does not end the line. */
    printf("%s\n", name);
    fflush(stdout);
    double begin = wall();
    uint64_t first = rig.avr->cycle;
    for (;;) {
        struct pollfd waits[] = {{.fd = 0, .events = POLLIN}};
        if (poll(waits, 1, 0) > 0 && !serve_line())
            return 0;
        uint8_t bytes[256];
        ssize_t got = read(ours, bytes, sizeof bytes);
        for (ssize_t i = 0; i < got; i++)
            rig_send(&rig, bytes[i]);
        if (!pass(rig.avr->cycle + 16000, 0))
            return 1;
        for (int next = rig_take(&rig); next >= 0; next = rig_take(&rig)) {
            uint8_t byte = (uint8_t)next;
            if (write(ours, &byte, 1) < 0 && errno != EAGAIN)
                return 1;
        }
        double ahead = (double)(rig.avr->cycle - first) / 16e6 - (wall() - begin);
        if (ahead > 0.001)
            usleep((useconds_t)(1e6 * ahead));
    }
}

int main(int count, char **words)
{
    if (count < 3) {
        fputs("usage: simulator BOARD ELF [--pty]\n", stderr);
        return 2;
    }
    /* simavr talks while it loads; standard output is for answers alone. */
    int answers = dup(1), nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, 1);
    rig_init(&rig, words[1], words[2]);
    fflush(stdout);
    dup2(answers, 1);
    if (count > 3 && !strcmp(words[3], "--pty"))
        return serve_pty();
    while (serve_line())
        ;
    return 0;
}
