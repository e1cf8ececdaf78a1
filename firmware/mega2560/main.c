/* The strawberry rig: three slides, four servos, one link. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <string.h>

#include "axis.h"
#include "board.h"
#include "link.h"
#include "uart.h"

#define SERVO_LOWEST 1200 /* half microseconds */
#define SERVO_HIGHEST 4800
#define NO_AXIS 0xFF
#define ESTOP_BIT 8

static struct axis axes[AXES];
static struct link line;
static uint8_t state, fault, fault_axis = NO_AXIS, switches;
static uint16_t silence; /* ms since the last good frame, held at the time-out */
static uint16_t lost_ticks;
static uint32_t clock_ms;
static volatile uint8_t ticks;

ISR(TIMER0_COMPA_vect)
{
    ticks++;
}

static void inputs_init(void)
{
    /* Pull-ups: an open contact, or a broken wire, reads as pressed. */
    PORTC |= 7;
    PORTB |= 1 << PB0;
}

static uint8_t inputs(void)
{
    return (PINC & 7) | (PINB & 1 << PB0 ? ESTOP_BIT : 0);
}

static void clock_init(void)
{
    TCCR0A = 1 << WGM01;
    OCR0A = F_CPU / 64 / 1000 - 1;
    TCCR0B = 1 << CS01 | 1 << CS00;
    TIMSK0 = 1 << OCIE0A;
}

static uint8_t busy(void)
{
    uint8_t bits = 0;
    for (uint8_t i = 0; i < AXES; i++)
        if (axis_busy(&axes[i]))
            bits |= 1 << i;
    return bits;
}

static uint8_t homed(void)
{
    uint8_t bits = 0;
    for (uint8_t i = 0; i < AXES; i++)
        if (axes[i].homed)
            bits |= 1 << i;
    return bits;
}

static uint8_t stopped(void)
{
    return state == STATE_FAULT || state == STATE_ESTOP;
}

/* Latches: only CLEAR leads out again. */
static void stop_all(uint8_t into, uint8_t why, uint8_t axis)
{
    motors_off();
    for (uint8_t i = 0; i < AXES; i++)
        axis_off(&axes[i]);
    if (into == STATE_ESTOP || !stopped()) {
        state = into;
        fault = why;
        fault_axis = axis;
    }
}

static void follow_axes(void)
{
    if (stopped())
        return;
    uint8_t homing = 0;
    for (uint8_t i = 0; i < AXES; i++)
        homing |= axis_homing(&axes[i]);
    if (homing)
        state = STATE_HOMING;
    else if (busy())
        state = STATE_MOVING;
    else
        state = homed() == (1 << AXES) - 1 ? STATE_IDLE : STATE_NOT_HOMED;
}

static void tick(void)
{
    clock_ms++;
    switches = inputs();
    for (uint8_t i = 0; i < AXES; i++) {
        struct axis *axis = &axes[i];
        uint8_t was_busy = axis_busy(axis);
        axis_tick(axis, encoder_take(i), switches >> i & 1);
        if (axis->fault) {
            stop_all(STATE_FAULT, axis->fault, i);
            axis->fault = FAULT_NONE;
        }
        if (was_busy)
            motor_set(i, axis->output);
    }
    if (switches & ESTOP_BIT && state != STATE_ESTOP)
        stop_all(STATE_ESTOP, FAULT_ESTOP, NO_AXIS);
    if (silence < LINK_TIMEOUT_MS)
        silence++;
    else if (busy())
        stop_all(STATE_FAULT, FAULT_LINK_TIMEOUT, NO_AXIS);
    follow_axes();
}

static uint8_t move(const struct msg_move *request)
{
    if (request->axis >= AXES)
        return CODE_MALFORMED;
    if (state == STATE_HOMING)
        return CODE_WRONG_STATE;
    return axis_move(&axes[request->axis], request->target, request->speed);
}

static uint8_t home(uint8_t mask)
{
    if (!mask || mask >> AXES)
        return CODE_MALFORMED;
    for (uint8_t i = 0; i < AXES; i++)
        if (mask >> i & 1 && (axis_busy(&axes[i]) || !axes[i].configured))
            return axes[i].configured ? CODE_WRONG_STATE : CODE_NOT_CONFIGURED;
    for (uint8_t i = 0; i < AXES; i++)
        if (mask >> i & 1)
            axis_home(&axes[i]);
    return CODE_OK;
}

static uint8_t servo(const struct msg_servo *request)
{
    if (request->index >= SERVOS)
        return CODE_MALFORMED;
    if (request->ticks < SERVO_LOWEST || request->ticks > SERVO_HIGHEST)
        return CODE_OUT_OF_LIMITS;
    servo_set(request->index, request->ticks);
    return CODE_OK;
}

static uint8_t clear(void)
{
    if (inputs() & ESTOP_BIT)
        return CODE_WRONG_STATE;
    if (stopped()) {
        state = STATE_NOT_HOMED;
        fault = FAULT_NONE;
        fault_axis = NO_AXIS;
    }
    return CODE_OK;
}

uint8_t board_command(uint8_t type, const uint8_t *payload, uint8_t length)
{
    union {
        struct msg_move move;
        struct msg_servo servo;
        struct msg_configure configure;
    } request;
    uint8_t wanted = 0, code = CODE_UNKNOWN;
    switch (type) {
    case MSG_MOVE: wanted = sizeof request.move; break;
    case MSG_SERVO: wanted = sizeof request.servo; break;
    case MSG_CONFIGURE: wanted = sizeof request.configure; break;
    case MSG_HOME: wanted = sizeof(struct msg_home); break;
    case MSG_STOP:
    case MSG_CLEAR:
#ifdef TEST_BUILD
    case MSG_HANG:
#endif
        break;
    default: return CODE_UNKNOWN;
    }
    if (length != wanted)
        return CODE_MALFORMED;
    if (wanted > 1)
        memcpy(&request, payload, wanted);
    if (stopped() && (type == MSG_MOVE || type == MSG_SERVO || type == MSG_HOME))
        return CODE_WRONG_STATE;
    switch (type) {
    case MSG_MOVE: code = move(&request.move); break;
    case MSG_SERVO: code = servo(&request.servo); break;
    case MSG_HOME: code = home(payload[0]); break;
    case MSG_CONFIGURE:
        if (request.configure.axis >= AXES)
            return CODE_MALFORMED;
        code = axis_configure(&axes[request.configure.axis], &request.configure);
        break;
    case MSG_STOP:
        for (uint8_t i = 0; i < AXES; i++)
            axis_stop(&axes[i]);
        code = CODE_OK;
        break;
    case MSG_CLEAR: code = clear(); break;
#ifdef TEST_BUILD
    case MSG_HANG:
        for (;;)
            ;
#endif
    }
    follow_axes();
    return code;
}

void board_report(struct msg_report *report)
{
    report->state = state;
    report->fault = fault;
    report->fault_axis = fault_axis;
    report->switches = switches;
    report->homed = homed();
    report->busy = busy();
    report->lost_ticks = lost_ticks;
    for (uint8_t i = 0; i < AXES; i++) {
        report->position[i] = axes[i].position;
        report->output[i] = axes[i].output;
    }
    for (uint8_t i = 0; i < SERVOS; i++)
        report->servo[i] = servo_pulse(i);
    report->overruns = uart_overruns();
    report->skips = encoder_skips();
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

/* Before anything else: after a reset by the watchdog, it runs on with its shortest time. The
 * cause waits in a register that nothing clears. */
static void first(void) __attribute__((naked, used, section(".init3")));
static void first(void)
{
    GPIOR0 = MCUSR;
    MCUSR = 0;
    wdt_disable();
}

int main(void)
{
    uint8_t flags = GPIOR0;
    uint8_t cause = flags & 1 << WDRF   ? RESET_WATCHDOG
                    : flags & 1 << PORF ? RESET_POWER_ON
                    : flags & 1 << BORF ? RESET_BROWN_OUT
                                        : RESET_EXTERNAL;
    line.board = BOARD_MEGA2560;
    line.reset = cause;
    inputs_init();
    motors_init();
    servos_init();
    encoders_init();
    clock_init();
    uart_init();
    if (cause == RESET_WATCHDOG)
        stop_all(STATE_FAULT, FAULT_WATCHDOG, NO_AXIS);
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
