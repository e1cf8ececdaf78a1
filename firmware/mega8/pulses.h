/* Three servo pulses one after the other, in a frame of 20 ms: PB1 shoulder, PB2 elbow, PB3 pan. */
#ifndef AGRIK_PULSES_H
#define AGRIK_PULSES_H

#include <stdint.h>

#define SERVOS 3

void pulses_init(void);
/* Half microseconds, 0 for no pulse; from the next frame on. */
void pulse_set(uint8_t index, uint16_t ticks);
uint16_t pulse_get(uint8_t index);

#endif
