#include "rig.h"

#include <math.h>
#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_core.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FREQUENCY 16000000
#define STEP 128        /* 8 us, while something moves */
#define REST_STEP 1600  /* 100 us */
#define SERVO_STEP 16000
/* At twice the speed and UBRR 16; simavr counts a parity bit. */
#define BYTE_CYCLES (17 * 8 * 11)
#define RUN_LIMIT 64

static const char slide_port = 'H', switch_port = 'C', stop_port = 'B';
static const int slide_pins[SLIDES] = {3, 4, 5};
static const struct { char port; int pin; } encoder_pins[SLIDES] = {{'D', 0}, {'D', 2}, {'E', 4}};
static const struct { char port; int pin; } servo_pins[2][SERVOS] = {
    {{'B', 1}, {'B', 2}, {'B', 3}, {0, 0}},
    {{'L', 3}, {'L', 4}, {'L', 5}, {'B', 5}},
};

static struct rig *the_rig; /* simavr's callback for a run has no argument of ours */

static avr_irq_t *pin(struct rig *rig, char port, int number)
{
    return avr_io_getirq(rig->avr, AVR_IOCTL_IOPORT_GETIRQ(port), number);
}

static void drive(struct rig *rig, char port, int number, int level)
{
    avr_raise_irq(pin(rig, port, number), level);
}

/* ---- what the board does ------------------------------------------------------------------- */

static void on_motor_pin(struct avr_irq_t *irq, uint32_t value, void *param)
{
    struct rig *rig = param;
    for (int i = 0; i < SLIDES; i++) {
        if (irq->irq != (uint32_t)slide_pins[i])
            continue;
        int high = value & 1;
        if (high && !rig->high[i]) {
            rig->high_since[i] = rig->avr->cycle;
            if (rig->next_step > rig->avr->cycle + STEP) {
                rig->stepped = rig->avr->cycle;
                rig->next_step = rig->avr->cycle + STEP;
            }
        } else if (!high && rig->high[i]) {
            rig->high_cycles[i] += rig->avr->cycle - rig->high_since[i];
            rig->last_drive[i] = rig->avr->cycle;
        }
        rig->high[i] = high;
    }
}

static void on_servo_pin(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    servo_edge(param, the_rig->avr->cycle, value & 1, CYCLES_PER_US);
}

static void on_byte(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    struct rig *rig = param;
    uint64_t start = rig->avr->cycle > rig->last_out ? rig->avr->cycle : rig->last_out;
    rig->last_out = start + BYTE_CYCLES;
    if (rig->cable == 0.0)
        return;
    rig->out[rig->out_head % sizeof rig->out] = value;
    rig->out_due[rig->out_head % sizeof rig->out] = rig->last_out;
    rig->out_head++;
}

/* ---- what the plant does ------------------------------------------------------------------- */

/* Switches and stop change seldom; simavr would put its own pull-ups over them at each write to
 * their ports, so that they are told as a port's outer pull as well. */
static void drive_inputs(struct rig *rig)
{
    int bits = 0;
    for (int i = 0; i < SLIDES; i++)
        bits |= slide_pressed(&rig->slides[i]) << i;
    bits |= (rig->estop != 0.0) << 3;
    if (bits == rig->inputs)
        return;
    rig->inputs = bits;
    avr_ioport_external_t switches = {.name = switch_port, .mask = 7, .value = bits & 7};
    avr_ioport_external_t stop = {.name = stop_port, .mask = 1, .value = bits >> 3 & 1};
    avr_ioctl(rig->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(switch_port), &switches);
    avr_ioctl(rig->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(stop_port), &stop);
    for (int i = 0; i < SLIDES; i++)
        drive(rig, switch_port, i, bits >> i & 1);
    drive(rig, stop_port, 0, bits >> 3 & 1);
}

static void drive_encoder(struct rig *rig, int i)
{
    unsigned now = slide_channels(&rig->slides[i]), changed = now ^ rig->channels[i];
    rig->channels[i] = now;
    for (int channel = 0; channel < 2; channel++)
        if (changed >> channel & 1)
            drive(rig, encoder_pins[i].port, encoder_pins[i].pin + channel, now >> channel & 1);
}

static int step_slides(struct rig *rig, uint64_t cycles)
{
    int moves = 0;
    uint8_t down = rig->avr->data[0x22], outputs = rig->avr->data[0x101]; /* PORTA, DDRH */
    double seconds = (double)cycles / FREQUENCY;
    for (int i = 0; i < SLIDES; i++) {
        uint64_t on = rig->high_cycles[i];
        rig->high_cycles[i] = 0;
        if (rig->high[i]) {
            on += rig->avr->cycle - rig->high_since[i];
            rig->high_since[i] = rig->last_drive[i] = rig->avr->cycle;
        }
        double voltage = outputs >> slide_pins[i] & 1 ? (double)on / (double)cycles : 0.0;
        if (voltage > 1.0)
            voltage = 1.0;
        rig->driven[i] = on != 0;
        slide_step(&rig->slides[i], seconds, down >> i & 1 ? -voltage : voltage);
        drive_encoder(rig, i);
        moves |= rig->driven[i] || slide_moves(&rig->slides[i]);
    }
    return moves;
}

static void step_servos(struct rig *rig)
{
    if (!rig->strawberry) {
        double up = rig->servos[0].angle * M_PI / 180.0, bend = rig->servos[1].angle * M_PI / 180.0;
        rig->servos[0].load = rig->droop[0] * cos(up);
        rig->servos[1].load = rig->droop[1] * cos(up + bend);
    }
    for (int i = 0; i < SERVOS; i++)
        servo_step(&rig->servos[i], (double)SERVO_STEP / FREQUENCY);
}

static void step(struct rig *rig)
{
    uint64_t now = rig->avr->cycle;
    int moves = 0;
    if (rig->strawberry) {
        moves = step_slides(rig, now - rig->stepped);
        drive_inputs(rig);
    }
    rig->stepped = now;
    rig->next_step = now + (moves ? STEP : REST_STEP);
    if (now >= rig->next_servo) {
        step_servos(rig);
        rig->next_servo += SERVO_STEP;
    }
    while (rig->in_tail != rig->in_head && now >= rig->next_in) {
        if (rig->cable != 0.0)
            avr_raise_irq(avr_io_getirq(rig->avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT),
                          rig->in[rig->in_tail % sizeof rig->in]);
        rig->in_tail++;
        rig->taken++;
        rig->next_in = now + BYTE_CYCLES;
    }
    if (rig->in_tail != rig->in_head && rig->next_step > rig->next_in)
        rig->next_step = rig->next_in;
}

/* ---- the board's clockwork ----------------------------------------------------------------- */

/* What simavr does not keep through a reset of the board: its inputs' levels, and that an input
 * at rest is no endless interrupt. Its pins let go. */
static void after_reset(struct rig *rig)
{
    avr_t *avr = rig->avr;
    avr->run_cycle_limit = RUN_LIMIT;
    uint32_t plain = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &plain);
    for (int i = 0; i < 8; i++)
        avr_extint_set_strict_lvl_trig(avr, i, 0);
    for (int i = 0; i < SERVOS; i++) {
        if (servo_pins[rig->strawberry][i].port)
            drive(rig, servo_pins[rig->strawberry][i].port, servo_pins[rig->strawberry][i].pin, 0);
        rig->servos[i].rise = 0;
    }
    if (!rig->strawberry)
        return;
    for (int i = 0; i < SLIDES; i++) {
        drive(rig, slide_port, slide_pins[i], 0);
        rig->channels[i] = slide_channels(&rig->slides[i]);
        for (int channel = 0; channel < 2; channel++) {
            int level = rig->channels[i] >> channel & 1;
            /* Only a change is passed on. */
            drive(rig, encoder_pins[i].port, encoder_pins[i].pin + channel, !level);
            drive(rig, encoder_pins[i].port, encoder_pins[i].pin + channel, level);
        }
        drive(rig, switch_port, i, !slide_pressed(&rig->slides[i]));
    }
    drive(rig, stop_port, 0, rig->estop == 0.0);
    rig->inputs = -1;
    drive_inputs(rig);
}

/* simavr's own loop, but that it sleeps no further than the plant's next step and counts. */
static void run(avr_t *avr)
{
    struct rig *rig = the_rig;
    avr_flashaddr_t pc = avr->pc;
    if (avr->state == cpu_Running)
        pc = avr_run_one(avr);
    avr_cycle_count_t sleep = avr_cycle_timer_process(avr);
    avr->pc = pc;
    if (avr->state == cpu_Sleeping) {
        if (!avr->sreg[S_I]) {
            avr->state = cpu_Done;
            return;
        }
        uint64_t most = rig->next_step > avr->cycle ? rig->next_step - avr->cycle - 1 : 0;
        if (sleep > most)
            sleep = most;
        avr->cycle += 1 + sleep;
        rig->slept += 1 + sleep;
    }
    if (avr->interrupt_state)
        avr_service_interrupts(avr);
}

int rig_run(struct rig *rig, uint64_t until, int stop)
{
    avr_t *avr = rig->avr;
    while (avr->cycle < until) {
        avr->run(avr);
        if (avr->run_cycle_limit != RUN_LIMIT) {
            rig->resets++;
            after_reset(rig);
        }
        if (avr->state != cpu_Running && avr->state != cpu_Sleeping)
            return 0;
        if (avr->cycle >= rig->next_step)
            step(rig);
        if (stop && rig->out_tail != rig->out_head) {
            unsigned at = (rig->out_head - 1) % sizeof rig->out;
            if (rig->out[at] == 0 && avr->cycle >= rig->out_due[at])
                break;
        }
    }
    return 1;
}

void rig_send(struct rig *rig, uint8_t byte)
{
    if (rig->in_tail == rig->in_head && rig->next_in < rig->avr->cycle + BYTE_CYCLES)
        rig->next_in = rig->avr->cycle + BYTE_CYCLES;
    rig->in[rig->in_head++ % sizeof rig->in] = byte;
    if (rig->next_step > rig->next_in) {
        rig->next_step = rig->next_in;
    }
}

int rig_take(struct rig *rig)
{
    if (rig->out_tail == rig->out_head ||
        rig->avr->cycle < rig->out_due[rig->out_tail % sizeof rig->out])
        return -1;
    rig->given++;
    return rig->out[rig->out_tail++ % sizeof rig->out];
}

void rig_init(struct rig *rig, const char *board, const char *elf)
{
    memset(rig, 0, sizeof *rig);
    the_rig = rig;
    rig->strawberry = !strcmp(board, "atmega2560");
    rig->cable = 1.0;
    rig->inputs = -1;
    for (int i = 0; i < SLIDES; i++)
        slide_init(&rig->slides[i]);
    for (int i = 0; i < SERVOS; i++)
        servo_init(&rig->servos[i], 1 + i);
    elf_firmware_t firmware = {0};
    if (elf_read_firmware(elf, &firmware) != 0) {
        fprintf(stderr, "simulator: %s is no program for a board\n", elf);
        exit(2);
    }
    avr_t *avr = rig->avr = avr_make_mcu_by_name(board);
    if (!avr) {
        fprintf(stderr, "simulator: no board %s\n", board);
        exit(2);
    }
    avr_init(avr);
    avr->log = 0;
    avr_load_firmware(avr, &firmware);
    avr->frequency = FREQUENCY;
    avr->run = run;
    for (int i = 0; i < SERVOS; i++)
        if (servo_pins[rig->strawberry][i].port)
            avr_irq_register_notify(pin(rig, servo_pins[rig->strawberry][i].port,
                                        servo_pins[rig->strawberry][i].pin),
                                    on_servo_pin, &rig->servos[i]);
    if (rig->strawberry)
        for (int i = 0; i < SLIDES; i++)
            avr_irq_register_notify(pin(rig, slide_port, slide_pins[i]), on_motor_pin, rig);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT),
                            on_byte, rig);
    after_reset(rig);
}
