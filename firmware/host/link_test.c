#include <string.h>

#include "check.h"
#include "crc16.h"
#include "link.h"

/* ---- a board that counts what it is told ---------------------------------------------------- */

static unsigned carried_out;
static uint8_t last_type, last_length, answer;

uint8_t board_command(uint8_t type, const uint8_t *payload, uint8_t length)
{
    (void)payload;
    carried_out++;
    last_type = type;
    last_length = length;
    return answer;
}

void board_report(struct msg_report *report)
{
    report->clock = 12345;
}

static uint32_t random_state = 1;

static uint32_t draw(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8;
}

static int feed(struct frame_reader *reader, const uint8_t *wire, int length, int *bad)
{
    int good = 0;
    for (int i = 0; i < length; i++) {
        enum frame_event event = frame_read(reader, wire[i]);
        good += event == FRAME_GOOD;
        *bad += event == FRAME_BAD_CRC || event == FRAME_MALFORMED;
    }
    return good;
}

void test_frames(void)
{
    uint16_t crc = CRC16_START;
    for (const char *c = "123456789"; *c; c++)
        crc = crc16_update(crc, (uint8_t)*c);
    CHECK(crc == 0x29B1); /* the published check value of CRC-16/CCITT-FALSE */

    uint8_t payload[LINK_PAYLOAD_MAX], wire[FRAME_WIRE_BYTES];
    int bad = 0;
    for (int round = 0; round < 3000; round++) {
        struct frame_reader reader = {0};
        uint8_t length = (uint8_t)(draw() % (LINK_PAYLOAD_MAX + 1));
        for (int i = 0; i < length; i++)
            payload[i] = (uint8_t)(draw() % 3 ? draw() : 0); /* many zeros */
        uint8_t type = (uint8_t)draw(), sequence = (uint8_t)draw();
        uint8_t count = frame_write(wire, type, sequence, payload, length);
        CHECK(count <= FRAME_WIRE_BYTES && count == length + 6);
        CHECK(memchr(wire, 0, count) == wire + count - 1);
        CHECK(feed(&reader, wire, count, &bad) == 1);
        CHECK(reader.length == length + FRAME_HEAD);
        CHECK(reader.data[0] == type && reader.data[1] == sequence);
        CHECK(!memcmp(reader.data + FRAME_HEAD, payload, length));
    }
    CHECK(bad == 0);

    /* Every flipped bit and every dropped byte of a MOVE; the frame behind it is read again. */
    struct msg_move move = {1, -70000, 21474};
    uint8_t next[FRAME_WIRE_BYTES];
    uint8_t count = frame_write(wire, MSG_MOVE, 7, (uint8_t *)&move, sizeof move);
    uint8_t more = frame_write(next, MSG_PING, 8, NULL, 0);
    for (int bit = 0; bit < 8 * count; bit++) {
        struct frame_reader reader = {0};
        uint8_t flipped[FRAME_WIRE_BYTES];
        memcpy(flipped, wire, count);
        flipped[bit / 8] ^= (uint8_t)(1 << bit % 8);
        CHECK(feed(&reader, flipped, count, &bad) == 0);
        /* A flipped delimiter joins two frames into one; the one behind is whole again. */
        feed(&reader, next, more, &bad);
        CHECK(feed(&reader, next, more, &bad) == 1);
    }
    for (int drop = 0; drop < count; drop++) {
        struct frame_reader reader = {0};
        CHECK(feed(&reader, wire, drop, &bad) == 0);
        CHECK(feed(&reader, wire + drop + 1, count - drop - 1, &bad) == 0);
        feed(&reader, next, more, &bad);
        CHECK(feed(&reader, next, more, &bad) == 1);
    }

    /* Endless noise without a delimiter, and many delimiters. */
    struct frame_reader reader = {0};
    uint8_t noise = 0xAB, zero = 0;
    for (int i = 0; i < 5000; i++)
        CHECK(feed(&reader, &noise, 1, &bad) == 0);
    for (int i = 0; i < 10; i++)
        CHECK(feed(&reader, &zero, 1, &bad) == 0);
    CHECK(feed(&reader, wire, count, &bad) == 1);
}

static uint8_t ask(struct link *link, uint8_t type, uint8_t sequence, const void *payload,
                   uint8_t length, struct frame_reader *reply)
{
    uint8_t wire[FRAME_WIRE_BYTES], back[FRAME_WIRE_BYTES];
    uint8_t count = frame_write(wire, type, sequence, payload, length), got = 0;
    for (int i = 0; i < count; i++) {
        uint8_t n = link_byte(link, wire[i], back);
        got = n ? n : got;
    }
    int bad = 0;
    memset(reply, 0, sizeof *reply);
    if (got)
        CHECK(feed(reply, back, got, &bad) == 1);
    return got;
}

void test_link(void)
{
    struct link link = {.board = BOARD_MEGA8, .reset = RESET_WATCHDOG};
    struct frame_reader reply;
    struct msg_move move = {0, 1000, 2000};

    CHECK(ask(&link, MSG_HELLO, 3, NULL, 0, &reply));
    struct msg_identity *identity = (struct msg_identity *)(reply.data + FRAME_HEAD);
    CHECK(reply.data[0] == MSG_IDENTITY && reply.data[1] == 3);
    CHECK(identity->version == LINK_VERSION && identity->board == BOARD_MEGA8);
    CHECK(identity->reset == RESET_WATCHDOG);

    CHECK(ask(&link, MSG_PING, 4, "abc", 3, &reply));
    CHECK(reply.length == 5 && !memcmp(reply.data + FRAME_HEAD, "abc", 3));
    CHECK(ask(&link, MSG_STATUS, 5, NULL, 0, &reply));
    CHECK(((struct msg_report *)(reply.data + FRAME_HEAD))->clock == 12345);
    CHECK(carried_out == 0);

    /* A retry is answered and not carried out; the answer is the first one. */
    answer = CODE_OUT_OF_LIMITS;
    for (int i = 0; i < 3; i++) {
        CHECK(ask(&link, MSG_MOVE, 6, &move, sizeof move, &reply));
        CHECK(reply.data[0] == MSG_ACK && reply.data[2] == CODE_OUT_OF_LIMITS);
        answer = CODE_OK;
    }
    CHECK(carried_out == 1 && last_type == MSG_MOVE && last_length == sizeof move);
    /* Queries between do not disturb that memory. */
    CHECK(ask(&link, MSG_PING, 7, NULL, 0, &reply));
    CHECK(ask(&link, MSG_MOVE, 6, &move, sizeof move, &reply) && carried_out == 1);
    /* The same number with another content is another command, and so is the next number. */
    move.target = 1001;
    CHECK(ask(&link, MSG_MOVE, 6, &move, sizeof move, &reply) && carried_out == 2);
    CHECK(ask(&link, MSG_MOVE, 7, &move, sizeof move, &reply) && carried_out == 3);
    /* A host that begins anew is not answered from the memory of another. */
    CHECK(ask(&link, MSG_HELLO, 7, NULL, 0, &reply));
    CHECK(ask(&link, MSG_MOVE, 7, &move, sizeof move, &reply) && carried_out == 4);

    /* Replies that come back are no requests; unknown queries are malformed. */
    CHECK(!ask(&link, MSG_ACK, 9, "", 1, &reply));
    CHECK(ask(&link, 0x05, 9, NULL, 0, &reply) && reply.data[2] == CODE_MALFORMED);
    CHECK(ask(&link, MSG_STATUS, 9, "x", 1, &reply) && reply.data[2] == CODE_MALFORMED);
    CHECK(carried_out == 4);

    /* 10,000 bursts of noise: nothing is carried out, and the next request is answered. */
    uint8_t wire[FRAME_WIRE_BYTES];
    for (int burst = 0; burst < 10000; burst++) {
        int length = 1 + (int)(draw() % 60);
        for (int i = 0; i < length; i++)
            CHECK(!link_byte(&link, (uint8_t)draw(), wire));
        link_byte(&link, 0, wire);
        CHECK(ask(&link, MSG_PING, (uint8_t)burst, NULL, 0, &reply));
        CHECK(reply.data[0] == MSG_PONG && reply.data[1] == (uint8_t)burst);
    }
    CHECK(carried_out == 4);
    CHECK(link.crc_errors + link.frame_errors > 9000);
}
