#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "pid.h"

/* 20 kHz: TOP + 1 periods of the clock. PID_MAX is below TOP, where a comparison would never
 * come. */
#define TOP 799
/* Below this the motor would only hum; and a pulse must outlast the interrupt that sets it. */
#define SHORTEST 16

#define PWM_PINS (1 << PH3 | 1 << PH4 | 1 << PH5)
#define RUNNING (1 << WGM43 | 1 << WGM42 | 1 << CS40)

static const uint8_t connect[AXES] = {1 << COM4A1, 1 << COM4B1, 1 << COM4C1};
static const uint8_t pins[AXES] = {1 << PH3, 1 << PH4, 1 << PH5};
static volatile uint16_t duty[AXES];
static volatile uint8_t down; /* a bit an axis */

void motors_init(void)
{
    PORTH &= ~PWM_PINS;
    DDRH |= PWM_PINS;
    DDRA |= 7;
    ICR4 = TOP;
    TCCR4A = 1 << WGM41;
}

/* The low byte of a compare register is what some simulators act on: it has to change. */
#define COMPARE(reg, value)                                                                        \
    do {                                                                                           \
        uint16_t wanted = (value);                                                                 \
        reg = wanted ^ 1;                                                                          \
        reg = wanted;                                                                              \
    } while (0)

/* At the start of a period, so that no pulse is half old, half new. */
ISR(TIMER4_OVF_vect)
{
    TIMSK4 = 0;
    PORTA = (PORTA & ~7) | down;
    uint8_t off = 0, on = 0;
    for (uint8_t axis = 0; axis < AXES; axis++) {
        if (duty[axis])
            on |= connect[axis];
        else if (TCCR4A & connect[axis])
            off |= pins[axis];
    }
    if (duty[0])
        COMPARE(OCR4A, duty[0]);
    if (duty[1])
        COMPARE(OCR4B, duty[1]);
    if (duty[2])
        COMPARE(OCR4C, duty[2]);
    TCCR4A = 1 << WGM41 | on;
    if (off)
        PORTH &= ~off;
    if (!on)
        TCCR4B = 0;
}

void motor_set(uint8_t axis, int16_t output)
{
    uint16_t size = output < 0 ? -output : output;
    uint8_t bit = 1 << axis;
    if (size < SHORTEST)
        size = 0;
    if (size > PID_MAX)
        size = PID_MAX;
    cli();
    duty[axis] = size;
    if (output < 0)
        down |= bit;
    else
        down &= ~bit;
    if (size && !TCCR4B) {
        TCNT4 = 0;
        TCCR4B = RUNNING;
    }
    if (TCCR4B) {
        TIFR4 = 1 << TOV4;
        TIMSK4 = 1 << TOIE4;
    }
    sei();
}

void motors_off(void)
{
    cli();
    TIMSK4 = 0;
    TCCR4A = 1 << WGM41;
    TCCR4B = 0;
    PORTH &= ~PWM_PINS;
    for (uint8_t axis = 0; axis < AXES; axis++)
        duty[axis] = 0;
    sei();
}
