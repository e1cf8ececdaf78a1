/* The tomato rig: three servos whose pulses are ramped, one link. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <string.h>

#include "link.h"
#include "pulses.h"
#include "ramp.h"
#include "uart.h"

/* Half microseconds: shoulder and elbow HD-6001HB, pan HS-311. */
static const uint16_t lowest[SERVOS] = {1600, 1600, 1800};
static const uint16_t highest[SERVOS] = {4400, 4400, 4200};
/* Half microseconds a millisecond, times 2^8: 60 degrees/s near the fruit, 200 elsewhere, at
 * 8.485 and 10 us/degree. */
static const uint16_t near[SERVOS] = {261, 261, 307};
static const uint16_t far[SERVOS] = {869, 869, 1024};

static struct link line;
static struct ramp ramps[SERVOS];
static uint8_t state = STATE_IDLE, fault, enabled, slow;
static uint16_t silence; /* ms since the last good frame, up to LINK_OFF_MS */
static uint16_t lost_ticks;
static uint32_t clock_ms;
static volatile uint8_t ticks;

ISR(TIMER2_COMP_vect)
{
    ticks++;
}

static uint8_t moving(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        if (!ramp_arrived(&ramps[i]))
            return 1;
    return 0;
}

/* Stays where it is: an arm that lets go would fall. */
static void hold(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        ramps[i].target = ramps[i].now;
}

static void pulses_off(void)
{
    hold();
    enabled = 0;
    for (uint8_t i = 0; i < SERVOS; i++)
        pulse_set(i, 0);
}

static void tick(void)
{
    clock_ms++;
    if (silence < LINK_OFF_MS) {
        silence++;
        if (silence == LINK_TIMEOUT_MS && moving()) {
            hold();
            state = STATE_FAULT;
            fault = FAULT_LINK_TIMEOUT;
        }
        if (silence == LINK_OFF_MS)
            pulses_off();
    }
    if (!enabled)
        return;
    for (uint8_t i = 0; i < SERVOS; i++) {
        ramp_tick(&ramps[i], slow ? near[i] : far[i]);
        pulse_set(i, ramps[i].now >> 8);
    }
    if (state != STATE_FAULT)
        state = moving() ? STATE_MOVING : STATE_IDLE;
}

static uint8_t servos(const struct msg_servos *request)
{
    const uint16_t wanted[SERVOS] = {request->shoulder, request->elbow, request->pan};
    if (state == STATE_FAULT)
        return CODE_WRONG_STATE;
    if (!(request->flags & FLAG_ENABLE)) {
        pulses_off();
        state = STATE_IDLE;
        return CODE_OK;
    }
    for (uint8_t i = 0; i < SERVOS; i++)
        if (wanted[i] < lowest[i] || wanted[i] > highest[i])
            return CODE_OUT_OF_LIMITS;
    for (uint8_t i = 0; i < SERVOS; i++) {
        ramps[i].target = (uint32_t)wanted[i] << 8;
        /* Where a servo without pulses stands nobody knows: the first pulse is the target. */
        if (!enabled)
            ramps[i].now = ramps[i].target;
    }
    slow = request->flags & FLAG_NEAR;
    enabled = 1;
    return CODE_OK;
}

uint8_t board_command(uint8_t type, const uint8_t *payload, uint8_t length)
{
    switch (type) {
    case MSG_SERVOS: {
        struct msg_servos request;
        if (length != sizeof request)
            return CODE_MALFORMED;
        memcpy(&request, payload, sizeof request);
        return servos(&request);
    }
    case MSG_STOP:
        if (length)
            return CODE_MALFORMED;
        hold();
        return CODE_OK;
    case MSG_CLEAR:
        if (length)
            return CODE_MALFORMED;
        if (state == STATE_FAULT)
            state = STATE_IDLE;
        fault = FAULT_NONE;
        return CODE_OK;
#ifdef TEST_BUILD
    case MSG_HANG:
        for (;;)
            ;
#endif
    default:
        return CODE_UNKNOWN;
    }
}

void board_report(struct msg_report *report)
{
    report->state = state;
    report->fault = fault;
    report->fault_axis = 0xFF;
    report->homed = (1 << SERVOS) - 1;
    report->busy = (moving() ? 0x80 : 0) | (enabled ? 0x40 : 0);
    report->lost_ticks = lost_ticks;
    for (uint8_t i = 0; i < SERVOS; i++)
        report->servo[i] = pulse_get(i);
    report->overruns = uart_overruns();
    report->clock = clock_ms;
}

static void serve(void)
{
    static uint8_t wire[FRAME_WIRE_BYTES];
    uint8_t byte;
    while (uart_read(&byte)) {
        uint8_t length = link_byte(&line, byte, wire);
        if (length) {
            silence = 0;
            uart_write(wire, length);
        }
    }
}

/* The cause of the reset, kept from the program's own start; see the Mega's main.c. */
static uint8_t flags __attribute__((section(".noinit")));
static void first(void) __attribute__((naked, used, section(".init3")));
static void first(void)
{
    flags = MCUCSR;
    MCUCSR = 0;
    wdt_disable();
}

int main(void)
{
    line.board = BOARD_MEGA8;
    line.reset = flags & 1 << WDRF   ? RESET_WATCHDOG
                 : flags & 1 << PORF ? RESET_POWER_ON
                 : flags & 1 << BORF ? RESET_BROWN_OUT
                                     : RESET_EXTERNAL;
    pulses_init();
    TCCR2 = 1 << WGM21 | 1 << CS22;
    OCR2 = F_CPU / 64 / 1000 - 1;
    TIMSK |= 1 << OCIE2;
    uart_init();
    if (line.reset == RESET_WATCHDOG) {
        state = STATE_FAULT;
        fault = FAULT_WATCHDOG;
    }
    wdt_enable(WDTO_250MS);
    set_sleep_mode(SLEEP_MODE_IDLE);
    sei();
    for (;;) {
        cli();
        uint8_t due = ticks;
        if (!due && !uart_waiting()) {
            /* Nothing can come between these two: sleep follows the next instruction. */
            sleep_enable();
            sei();
            sleep_cpu();
            sleep_disable();
            continue;
        }
        ticks = 0;
        sei();
        if (due) {
            lost_ticks += due - 1;
            wdt_reset();
            tick();
        }
        serve();
    }
}
