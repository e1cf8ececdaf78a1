#include "link.h"

#include <string.h>

#include "crc16.h"

#ifndef BUILD
#define BUILD "unknown"
#endif

static uint16_t checksum(const struct frame_reader *reader)
{
    /* Still in the reader, behind what it counts. */
    return reader->data[reader->length] | (uint16_t)reader->data[reader->length + 1] << 8;
}

static uint8_t command(struct link *link, uint8_t type, uint8_t sequence, const uint8_t *payload,
                       uint8_t length)
{
    uint16_t crc = checksum(&link->reader);
    if (link->remembers && link->sequence == sequence && link->crc == crc)
        return link->code;
    link->code = board_command(type, payload, length);
    link->sequence = sequence;
    link->crc = crc;
    link->remembers = 1;
    return link->code;
}

uint8_t link_byte(struct link *link, uint8_t byte, uint8_t *wire)
{
    switch (frame_read(&link->reader, byte)) {
    case FRAME_GOOD:
        break;
    case FRAME_BAD_CRC:
        link->crc_errors++;
        return 0;
    case FRAME_MALFORMED:
        link->frame_errors++;
        return 0;
    default:
        return 0;
    }
    uint8_t type = link->reader.data[0], sequence = link->reader.data[1];
    uint8_t length = link->reader.length - FRAME_HEAD;
    const uint8_t *payload = link->reader.data + FRAME_HEAD;

    if (type == MSG_PING)
        return frame_write(wire, MSG_PONG, sequence, payload, length);
    if (type == MSG_HELLO && length == 0) {
        struct msg_identity identity = {
            .version = LINK_VERSION, .board = link->board, .reset = link->reset};
        memcpy(identity.build, BUILD "        ", sizeof identity.build);
        link->remembers = 0;
        return frame_write(wire, MSG_IDENTITY, sequence, (uint8_t *)&identity, sizeof identity);
    }
    if (type == MSG_STATUS && length == 0) {
        struct msg_report report;
        memset(&report, 0, sizeof report);
        report.crc_errors = link->crc_errors;
        report.frame_errors = link->frame_errors;
        board_report(&report);
        return frame_write(wire, MSG_REPORT, sequence, (uint8_t *)&report, sizeof report);
    }
    /* An echo of our own replies, on a line with a loop, is no request. */
    if (type & 0x80)
        return 0;
    struct msg_ack ack = {type < 0x10 ? CODE_MALFORMED
                                      : command(link, type, sequence, payload, length)};
    return frame_write(wire, MSG_ACK, sequence, (uint8_t *)&ack, sizeof ack);
}
