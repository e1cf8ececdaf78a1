/* A gear motor, its encoder, and a carriage on a toothed belt. Millimetres and seconds.
 *
 * Motor: first order in speed, with Coulomb friction. Between motor and carriage: play, a belt
 * whose pitch is not the nominal one, and slip. The encoder sits on the motor and sees none of
 * these. Nothing here calls the mathematical library, so that runs are bit-exact anywhere. */
#ifndef AGRIK_SLIDE_H
#define AGRIK_SLIDE_H

#include <stdint.h>

struct slide {
    /* what it is */
    double top_speed; /* of the motor without load at full voltage */
    double time_constant;
    double friction; /* share of the stall force */
    double weight;   /* the same; pulls upwards in the axis' own count */
    double play;
    double pitch;    /* true over nominal pitch of the belt */
    double slip;     /* share of the way that the belt loses */
    double counts_per_mm;
    double switch_at; /* pressed at and below this place of the carriage */
    double low, high; /* end stops */
    double jammed;
    double stuck; /* switch: 0 works, 1 always pressed, -1 never */
    /* where it is */
    double motor, speed, belt, carriage;
    int64_t count; /* that the encoder shows */
};

void slide_init(struct slide *slide);
/* `voltage`: share of the full one, with its sign. */
void slide_step(struct slide *slide, double seconds, double voltage);
/* Moves the encoder by at most one step towards the motor; returns its channels, A in bit 0. */
unsigned slide_channels(struct slide *slide);
int slide_pressed(const struct slide *slide);
int slide_moves(const struct slide *slide);

#endif
