/* lwIP's view of the compiler and the board. */
#pragma once
#include <stdint.h>
#include <stdlib.h>

#define LWIP_PLATFORM_DIAG(message)
#define LWIP_PLATFORM_ASSERT(message) abort()
#define LWIP_RAND() takt_random()

typedef int sys_prot_t;

uint32_t takt_random(void);
