/* A board in simavr, wired to its plant. Time is counted in the board's cycles. */
#ifndef AGRIK_RIG_H
#define AGRIK_RIG_H

#include <simavr/sim_avr.h>
#include <stdint.h>

#include "servo.h"
#include "slide.h"

#define SLIDES 3
#define SERVOS 4
#define CYCLES_PER_US 16.0

struct rig {
    avr_t *avr;
    int strawberry; /* or tomato */
    struct slide slides[SLIDES];
    struct servo servos[SERVOS];
    double estop, cable;
    double droop[2]; /* tomato: degrees that shoulder and elbow yield, arm stretched out level */
    /* pins */
    uint64_t high_since[SLIDES], high_cycles[SLIDES], last_drive[SLIDES];
    int high[SLIDES], driven[SLIDES];
    unsigned channels[SLIDES];
    int inputs;
    /* clockwork */
    uint64_t stepped, next_step, next_servo, slept, resets;
    /* the line */
    uint8_t in[4096], out[4096];
    uint64_t out_due[4096];
    unsigned in_head, in_tail, out_head, out_tail;
    uint64_t next_in, last_out, taken, given;
};

/* Loads the program; ends the process with a message where that cannot be. */
void rig_init(struct rig *rig, const char *board, const char *elf);

/* Runs to a cycle; with `stop`, no further than the end of a frame on the line. Returns 0 if
 * the board's program has ended, which it never should. */
int rig_run(struct rig *rig, uint64_t until, int stop);

void rig_send(struct rig *rig, uint8_t byte);
/* Takes a byte that has arrived; -1 if there is none. */
int rig_take(struct rig *rig);

#endif
