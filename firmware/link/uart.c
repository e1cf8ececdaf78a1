#include "uart.h"

#include <avr/interrupt.h>
#include <avr/io.h>

#include "messages.h"

#if defined(__AVR_ATmega8__)
#define UCSR0A UCSRA
#define UCSR0B UCSRB
#define UDR0 UDR
#define UBRR0H UBRRH
#define UBRR0L UBRRL
#define RXEN0 RXEN
#define TXEN0 TXEN
#define RXCIE0 RXCIE
#define UDRIE0 UDRIE
#define U2X0 U2X
#define DOR0 DOR
#define USART0_RX_vect USART_RXC_vect
#define USART0_UDRE_vect USART_UDRE_vect
#endif

/* Powers of two; a whole frame fits. */
#define RING 64
#define NEXT(at) (uint8_t)(((at) + 1) & (RING - 1))

static volatile uint8_t in_head, in_tail, out_head, out_tail, overruns;
static volatile uint8_t in[RING], out[RING];

void uart_init(void)
{
    /* Twice the speed: 115200 at 16 MHz is 2.1 % fast, as the usual USB converters are. The
     * format stays as it is at reset, 8N1. The low byte of the rate is written last. */
    UCSR0A = 1 << U2X0;
    UBRR0H = 0;
    UBRR0L = (F_CPU + LINK_BAUD * 4) / (LINK_BAUD * 8) - 1;
    UCSR0B = 1 << RXEN0 | 1 << TXEN0 | 1 << RXCIE0;
}

ISR(USART0_RX_vect)
{
    uint8_t lost = UCSR0A & (1 << DOR0);
    uint8_t byte = UDR0;
    uint8_t next = NEXT(in_head);
    if (lost && overruns < 255)
        overruns++;
    if (next == in_tail) {
        if (overruns < 255)
            overruns++;
        return;
    }
    in[in_head] = byte;
    in_head = next;
}

ISR(USART0_UDRE_vect)
{
    if (out_tail == out_head) {
        UCSR0B &= ~(1 << UDRIE0);
        return;
    }
    UDR0 = out[out_tail];
    out_tail = NEXT(out_tail);
}

uint8_t uart_waiting(void)
{
    return in_tail != in_head;
}

uint8_t uart_read(uint8_t *byte)
{
    if (!uart_waiting())
        return 0;
    *byte = in[in_tail];
    in_tail = NEXT(in_tail);
    return 1;
}

void uart_write(const uint8_t *data, uint8_t length)
{
    uint8_t head = out_head;
    if (length > (uint8_t)((out_tail - head - 1) & (RING - 1)))
        return;
    for (uint8_t i = 0; i < length; i++) {
        out[head] = data[i];
        head = NEXT(head);
    }
    out_head = head;
    cli();
    UCSR0B |= 1 << UDRIE0;
    sei();
}

uint8_t uart_overruns(void)
{
    return overruns;
}
