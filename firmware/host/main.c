/* host: the pure parts of the firmware on this machine.
 *
 * host test           runs the tests, prints how many checks held
 * host frames         reads bytes from a line, prints what the reader makes of them
 * host encode T S HEX prints a frame's bytes on the line
 */
#include <string.h>

#include "check.h"
#include "frame.h"

unsigned long checks;

static int frames(void)
{
    struct frame_reader reader = {0};
    int byte;
    while ((byte = getchar()) != EOF) {
        switch (frame_read(&reader, (uint8_t)byte)) {
        case FRAME_GOOD:
            for (int i = 0; i < reader.length; i++)
                printf("%02x", reader.data[i]);
            putchar('\n');
            break;
        case FRAME_BAD_CRC:
            puts("crc");
            break;
        case FRAME_MALFORMED:
            puts("malformed");
            break;
        default:
            break;
        }
    }
    return 0;
}

static int encode(const char *type, const char *sequence, const char *hex)
{
    uint8_t payload[LINK_PAYLOAD_MAX], wire[FRAME_WIRE_BYTES], length = 0;
    unsigned byte;
    for (; length < sizeof payload && sscanf(hex, "%2x", &byte) == 1; hex += 2)
        payload[length++] = (uint8_t)byte;
    length = frame_write(wire, (uint8_t)atoi(type), (uint8_t)atoi(sequence), payload, length);
    for (int i = 0; i < length; i++)
        printf("%02x", wire[i]);
    putchar('\n');
    return 0;
}

int main(int count, char **words)
{
    if (count > 1 && !strcmp(words[1], "frames"))
        return frames();
    if (count > 4 && !strcmp(words[1], "encode"))
        return encode(words[2], words[3], words[4]);
    if (count < 2 || strcmp(words[1], "test")) {
        fputs("usage: host test | frames | encode TYPE SEQUENCE HEX\n", stderr);
        return 2;
    }
    test_frames();
    test_link();
    test_quadrature();
    test_profile();
    test_pid();
    test_axis();
    test_ramp();
    printf("%lu checks held\n", checks);
    return 0;
}
