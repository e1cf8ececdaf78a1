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
    static uint8_t slot;
    static uint16_t used;
    PORTB &= ~PINS;
    while (slot < SERVOS && !pulse[slot])
        slot++;
    if (slot < SERVOS) {
        uint16_t length = pulse[slot];
        PORTB |= 1 << PB1 << slot;
        OCR1A += length;
        used += length;
        slot++;
    } else {
        OCR1A += FRAME - used;
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
