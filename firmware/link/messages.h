/* Made by tools/make_messages.py of firmware/messages.toml: change that, not this. */
#ifndef AGRIK_MESSAGES_H
#define AGRIK_MESSAGES_H

#include <stdint.h>

#define LINK_VERSION 1UL
#define LINK_BAUD 115200UL
#define LINK_PAYLOAD_MAX 44UL
#define LINK_TIMEOUT_MS 500UL
#define LINK_OFF_MS 5000UL
#define LINK_WATCHDOG_MS 250UL

enum { BOARD_MEGA2560 = 1, BOARD_MEGA8 = 2 };

enum { STATE_NOT_HOMED = 0, STATE_IDLE = 1, STATE_HOMING = 2, STATE_MOVING = 3, STATE_FAULT = 4, STATE_ESTOP = 5 };

enum { FAULT_NONE = 0, FAULT_LINK_TIMEOUT = 1, FAULT_STALL = 2, FAULT_FOLLOWING = 3, FAULT_LIMIT_SWITCH = 4, FAULT_SWITCH_NOT_FOUND = 5, FAULT_SWITCH_STUCK = 6, FAULT_ESTOP = 7, FAULT_WATCHDOG = 8, FAULT_ENCODER = 9 };

enum { CODE_OK = 0, CODE_UNKNOWN = 1, CODE_MALFORMED = 2, CODE_WRONG_STATE = 3, CODE_OUT_OF_LIMITS = 4, CODE_NOT_HOMED = 5, CODE_NOT_CONFIGURED = 6 };

enum { RESET_POWER_ON = 0, RESET_EXTERNAL = 1, RESET_BROWN_OUT = 2, RESET_WATCHDOG = 3 };

enum { FLAG_ENABLE = 1, FLAG_NEAR = 2 };

enum {
    MSG_HELLO = 0x00,
    MSG_PING = 0x01,
    MSG_STATUS = 0x02,
    MSG_MOVE = 0x10,
    MSG_SERVO = 0x11,
    MSG_STOP = 0x12,
    MSG_HOME = 0x13,
    MSG_CLEAR = 0x14,
    MSG_CONFIGURE = 0x15,
    MSG_HANG = 0x20,
    MSG_SERVOS = 0x21,
    MSG_IDENTITY = 0x80,
    MSG_PONG = 0x81,
    MSG_REPORT = 0x82,
    MSG_ACK = 0x90,
};

struct __attribute__((packed)) msg_move {
    uint8_t axis;
    int32_t target;
    uint16_t speed;
};

struct __attribute__((packed)) msg_servo {
    uint8_t index;
    uint16_t ticks;
};

struct __attribute__((packed)) msg_home {
    uint8_t mask;
};

struct __attribute__((packed)) msg_configure {
    uint8_t axis;
    int32_t lower;
    int32_t upper;
    uint16_t acceleration;
    uint16_t fast;
    uint16_t slow;
    uint16_t clearance;
    uint16_t following;
    uint16_t settle;
    uint16_t kp;
    uint16_t ki;
    uint16_t kd;
    uint16_t kv;
    uint16_t friction;
};

struct __attribute__((packed)) msg_servos {
    uint8_t flags;
    uint16_t shoulder;
    uint16_t elbow;
    uint16_t pan;
};

struct __attribute__((packed)) msg_identity {
    uint8_t version;
    uint8_t board;
    char build[8];
    uint8_t reset;
};

struct __attribute__((packed)) msg_report {
    uint8_t state;
    uint8_t fault;
    uint8_t fault_axis;
    uint8_t switches;
    uint8_t homed;
    uint8_t busy;
    uint16_t lost_ticks;
    int32_t position[3];
    int16_t output[3];
    uint16_t servo[4];
    uint16_t crc_errors;
    uint16_t frame_errors;
    uint8_t overruns;
    uint8_t skips;
    uint32_t clock;
};

struct __attribute__((packed)) msg_ack {
    uint8_t code;
};

#endif
