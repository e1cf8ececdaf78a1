/* Assertions of the host's tests: counted, and ended with the place of the first that fails. */
#ifndef AGRIK_CHECK_H
#define AGRIK_CHECK_H

#include <stdio.h>
#include <stdlib.h>

extern unsigned long checks;

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        checks++;                                                                                  \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                        \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

void test_frames(void);
void test_link(void);
void test_quadrature(void);
void test_profile(void);
void test_pid(void);
void test_axis(void);
void test_ramp(void);

#endif
