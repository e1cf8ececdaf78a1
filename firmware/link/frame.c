#include "frame.h"

#include "crc16.h"

static void append(struct frame_reader *reader, uint8_t byte)
{
    if (reader->length < FRAME_BYTES)
        reader->data[reader->length++] = byte;
    else
        reader->broken = 1;
}

static enum frame_event finish(struct frame_reader *reader)
{
    /* Between frames there may be any number of delimiters. */
    if (!reader->begun)
        return FRAME_PENDING;
    if (reader->broken || reader->left || reader->length < FRAME_HEAD + FRAME_CRC)
        return FRAME_MALFORMED;
    uint8_t length = reader->length - FRAME_CRC;
    uint16_t crc = CRC16_START;
    for (uint8_t i = 0; i < length; i++)
        crc = crc16_update(crc, reader->data[i]);
    if (reader->data[length] != (uint8_t)crc || reader->data[length + 1] != (uint8_t)(crc >> 8))
        return FRAME_BAD_CRC;
    reader->length = length;
    return FRAME_GOOD;
}

enum frame_event frame_read(struct frame_reader *reader, uint8_t byte)
{
    if (byte == 0) {
        enum frame_event event = finish(reader);
        if (event != FRAME_GOOD)
            reader->length = 0;
        reader->left = reader->begun = reader->zero = reader->broken = 0;
        return event;
    }
    if (!reader->begun) {
        reader->begun = 1;
        reader->length = 0;
    }
    if (reader->left) {
        append(reader, byte);
        reader->left--;
        return FRAME_PENDING;
    }
    if (reader->zero)
        append(reader, 0);
    reader->left = byte - 1;
    reader->zero = byte != 0xFF;
    return FRAME_PENDING;
}

/* Where the next byte goes, and where the length of its COBS group will stand. */
struct writer {
    uint8_t *wire;
    uint8_t at;
    uint8_t code;
};

static void put(struct writer *writer, uint8_t byte)
{
    if (byte) {
        writer->wire[writer->at++] = byte;
        return;
    }
    writer->wire[writer->code] = writer->at - writer->code;
    writer->code = writer->at++;
}

uint8_t frame_write(uint8_t *wire, uint8_t type, uint8_t sequence, const uint8_t *payload,
                    uint8_t length)
{
    struct writer writer = {wire, 1, 0};
    uint16_t crc = crc16_update(crc16_update(CRC16_START, type), sequence);
    put(&writer, type);
    put(&writer, sequence);
    for (uint8_t i = 0; i < length; i++) {
        crc = crc16_update(crc, payload[i]);
        put(&writer, payload[i]);
    }
    put(&writer, (uint8_t)crc);
    put(&writer, (uint8_t)(crc >> 8));
    wire[writer.code] = writer.at - writer.code;
    wire[writer.at++] = 0;
    return writer.at;
}
