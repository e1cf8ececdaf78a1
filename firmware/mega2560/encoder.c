#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "quadrature.h"

/* 16 bits, which the control tick extends: a longer counter costs a third more in each of up
 * to 120,000 interrupts a second. */
static volatile int16_t counts[AXES];
static uint8_t before[AXES];
static volatile uint8_t skips;

static inline uint8_t channels(uint8_t axis)
{
    return axis == 0 ? PIND & 3 : axis == 1 ? (PIND >> 2) & 3 : (PINE >> 4) & 3;
}

static inline __attribute__((always_inline)) void edge(uint8_t axis)
{
    uint8_t now = channels(axis);
    int8_t step = quadrature_steps[(uint8_t)(before[axis] << 2) | now];
    before[axis] = now;
    if (step == QUADRATURE_SKIP) {
        if (skips < 255)
            skips++;
        return;
    }
    counts[axis] += step;
}

ISR(INT0_vect) { edge(0); }
ISR(INT1_vect) { edge(0); }
ISR(INT2_vect) { edge(1); }
ISR(INT3_vect) { edge(1); }
ISR(INT4_vect) { edge(2); }
ISR(INT5_vect) { edge(2); }

void encoders_init(void)
{
    /* Every edge of all six; the encoders bring pull-ups of their own. */
    EICRA = 0x55;
    EICRB = 0x05;
    for (uint8_t axis = 0; axis < AXES; axis++)
        before[axis] = channels(axis);
    EIFR = 0x3F;
    EIMSK = 0x3F;
}

int16_t encoder_take(uint8_t axis)
{
    static int16_t taken[AXES];
    cli();
    int16_t now = counts[axis];
    sei();
    int16_t moved = now - taken[axis];
    taken[axis] = now;
    return moved;
}

uint8_t encoder_skips(void)
{
    return skips;
}
