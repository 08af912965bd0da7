/* Run ticks on a Cortex-M4 with semihosting: memory.bin goes in, out.bin comes out. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "sizes.h" /* N_ARRAYS, SIZES, TICKS, and ARRAYS, the pointers p[0], ..., p[N_ARRAYS - 1] */

__asm(".data\n.balign 64\nmemory: .incbin \"memory.bin\"\nmemory_end:\n.text\n");
extern unsigned char memory[], memory_end[];
extern int swarm_run();

int main(void) {
    static const size_t sizes[N_ARRAYS] = {SIZES};
    unsigned char *p[N_ARRAYS], *at = memory;
    int64_t nothing = 0, ticks = TICKS;
    void *error = 0;
    for (int k = 0; k < N_ARRAYS; k++) {
        p[k] = at;
        at += sizes[k];
    }
    swarm_run(&nothing, &error, ARRAYS, ticks);
    FILE *out = fopen("out.bin", "wb");
    fwrite(memory, 1, memory_end - memory, out);
    fclose(out);
    return 0;
}
