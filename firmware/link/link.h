/* Requests and replies over frames: what both boards have in common.
 *
 * A command (types 0x10 to 0x7F) that comes twice with the same sequence number and content is
 * a retry: it is answered from memory and not carried out again. HELLO forgets that memory.
 */
#ifndef AGRIK_LINK_H
#define AGRIK_LINK_H

#include <stdint.h>

#include "frame.h"

struct link {
    struct frame_reader reader;
    uint8_t board;
    uint8_t reset;
    uint8_t remembers;
    uint8_t sequence; /* of the last command, its CRC and the code it was answered with */
    uint16_t crc;
    uint8_t code;
    uint16_t crc_errors;
    uint16_t frame_errors;
};

/* What a board does; both are called from `link_byte`. */
uint8_t board_command(uint8_t type, const uint8_t *payload, uint8_t length);
void board_report(struct msg_report *report);

/* Takes a byte from the line. After a good request the reply is in `wire`; returns its length,
 * or 0 if there is none. */
uint8_t link_byte(struct link *link, uint8_t byte, uint8_t *wire);

#endif
