#include "pulses.h"

#include <avr/interrupt.h>
#include <avr/io.h>

/* Timer 1 runs free at half microseconds; this chip has only two compare outputs, so that the
 * pins are set in the interrupt. A frame's pause takes up what the pulses leave. */
#define FRAME 40000
#define PINS (1 << PB1 | 1 << PB2 | 1 << PB3)

static volatile uint16_t pulse[SERVOS];

void pulses_init(void)
{
    PORTB &= ~PINS;
    DDRB |= PINS;
    TCCR1B = 1 << CS11;
    OCR1A = FRAME;
    TIMSK |= 1 << OCIE1A;
}

ISR(TIMER1_COMPA_vect)
{
    /* What was made ready the last time: all edges come equally late. */
    static uint8_t pin;
    static uint16_t length = FRAME;
    PORTB = (PORTB & ~PINS) | pin;
    OCR1A += length;

    static uint8_t slot;
    static uint16_t used;
    while (slot < SERVOS && !pulse[slot])
        slot++;
    if (slot < SERVOS) {
        pin = 1 << PB1 << slot;
        length = pulse[slot];
        used += length;
        slot++;
    } else {
        pin = 0;
        length = FRAME - used;
        used = 0;
        slot = 0;
    }
}

void pulse_set(uint8_t index, uint16_t ticks)
{
    cli();
    pulse[index] = ticks;
    sei();
}

uint16_t pulse_get(uint8_t index)
{
    return pulse[index];
}
