/* The Mega 2560's registers, one file a subject: encoder.c, motor.c, servo.c, inputs in main.c.
 *
 * | signal              | pins                                     | header          |
 * |---------------------|------------------------------------------|-----------------|
 * | encoders A, B       | INT0-5: PD0,1  PD2,3  PE4,5              | D21,20 19,18 2,3 |
 * | motor PWM           | OC4A-C: PH3-5, 20 kHz                    | D6,7,8          |
 * | motor direction     | PA0-2, low is up                         | D22-24          |
 * | limit switches      | PC0-2, opening contacts to ground        | D37-35          |
 * | emergency stop      | PB0, an opening contact to ground        | D53             |
 * | servos 0-2          | OC5A-C: PL3-5                            | D46,45,44       |
 * | gripper             | OC1A: PB5                                | D11             |
 */
#ifndef AGRIK_BOARD_H
#define AGRIK_BOARD_H

#include <stdint.h>

#define AXES 3
#define SERVOS 4

void encoders_init(void);
/* Counts of an axis since the last call. */
int16_t encoder_take(uint8_t axis);
/* Steps that cannot be, up to 255. */
uint8_t encoder_skips(void);

void motors_init(void);
/* -PID_MAX to PID_MAX, from the next period of the PWM on. */
void motor_set(uint8_t axis, int16_t output);
/* All without current, now. */
void motors_off(void);

void servos_init(void);
/* A pulse in half microseconds, from the next period on. */
void servo_set(uint8_t index, uint16_t ticks);
uint16_t servo_pulse(uint8_t index);

#endif
