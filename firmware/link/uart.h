/* The serial port: interrupts on one side, rings on the other. */
#ifndef AGRIK_UART_H
#define AGRIK_UART_H

#include <stdint.h>

void uart_init(void);

/* Takes a received byte into `byte`; returns 0 if there is none. */
uint8_t uart_read(uint8_t *byte);
uint8_t uart_waiting(void);

/* Sends all of it or, if the ring has no room, nothing: the host asks again. */
void uart_write(const uint8_t *data, uint8_t length);

/* Bytes lost since the reset, up to 255. */
uint8_t uart_overruns(void);

#endif
