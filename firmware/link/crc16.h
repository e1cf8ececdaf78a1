/* CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, nothing reflected. */
#ifndef AGRIK_CRC16_H
#define AGRIK_CRC16_H

#include <stdint.h>

#define CRC16_START 0xFFFFU

#ifdef __AVR__
#include <util/crc16.h>
#define crc16_update _crc_xmodem_update
#else
static inline uint16_t crc16_update(uint16_t crc, uint8_t byte)
{
    crc ^= (uint16_t)((uint16_t)byte << 8);
    for (int i = 0; i < 8; i++)
        crc = (uint16_t)(crc & 0x8000 ? (crc << 1) ^ 0x1021 : crc << 1);
    return crc;
}
#endif

#endif
