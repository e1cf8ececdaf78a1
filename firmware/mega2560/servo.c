#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"

/* 50 Hz of half microseconds. */
#define TOP 39999
#define RUNNING(timer) (1 << WGM##timer##3 | 1 << WGM##timer##2 | 1 << CS##timer##1)

static volatile uint16_t pulse[SERVOS];

void servos_init(void)
{
    DDRL |= 1 << PL3 | 1 << PL4 | 1 << PL5;
    DDRB |= 1 << PB5;
    ICR5 = ICR1 = TOP;
    TCCR5A = 1 << WGM51;
    TCCR1A = 1 << WGM11;
    TCCR5B = RUNNING(5);
    TCCR1B = RUNNING(1);
    TIMSK5 = 1 << TOIE5;
    TIMSK1 = 1 << TOIE1;
}

/* A compare register is written at the start of a period and only when it changes, low byte
 * included: see motor.c. */
#define REFRESH(index, reg, control, bit)                                                          \
    if (pulse[index] && reg != pulse[index] - 1) {                                                 \
        uint16_t wanted = pulse[index] - 1;                                                        \
        reg = wanted ^ 1;                                                                          \
        reg = wanted;                                                                              \
        control |= bit;                                                                            \
    }

ISR(TIMER5_OVF_vect)
{
    REFRESH(0, OCR5A, TCCR5A, 1 << COM5A1)
    REFRESH(1, OCR5B, TCCR5A, 1 << COM5B1)
    REFRESH(2, OCR5C, TCCR5A, 1 << COM5C1)
}

ISR(TIMER1_OVF_vect)
{
    REFRESH(3, OCR1A, TCCR1A, 1 << COM1A1)
}

void servo_set(uint8_t index, uint16_t ticks)
{
    cli();
    pulse[index] = ticks;
    sei();
}

uint16_t servo_pulse(uint8_t index)
{
    return pulse[index];
}
