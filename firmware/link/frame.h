/* Frames on the line: COBS(type | sequence | payload | CRC-16) 0x00. */
#ifndef AGRIK_FRAME_H
#define AGRIK_FRAME_H

#include <stdint.h>

#include "messages.h"

#define FRAME_HEAD 2
#define FRAME_CRC 2
#define FRAME_BYTES (FRAME_HEAD + LINK_PAYLOAD_MAX + FRAME_CRC)
/* One code byte (a frame is shorter than 254) and the delimiter. */
#define FRAME_WIRE_BYTES (FRAME_BYTES + 2)

enum frame_event {
    FRAME_PENDING,   /* more bytes are needed */
    FRAME_GOOD,      /* `data` and `length` hold a frame, without its CRC */
    FRAME_BAD_CRC,
    FRAME_MALFORMED, /* too short, too long, or cut off within a COBS group */
};

struct frame_reader {
    uint8_t data[FRAME_BYTES];
    uint8_t length;
    uint8_t left; /* bytes of the present COBS group that are still to come */
    uint8_t begun;
    uint8_t zero; /* the group ends in a zero, if another one follows */
    uint8_t broken;
};

/* Takes a byte from the line. A good frame stays in the reader until the next byte. */
enum frame_event frame_read(struct frame_reader *reader, uint8_t byte);

/* Writes a frame into `wire`, which has room for FRAME_WIRE_BYTES; returns its length. */
uint8_t frame_write(uint8_t *wire, uint8_t type, uint8_t sequence, const uint8_t *payload,
                    uint8_t length);

#endif
