/* Replays vectors.bin on an emulated Cortex-M4, and prints the instructions of a tick: mean and most.
 * QEMU counts one for 2^5 ns (-icount shift=5), and its SysTick one for 40 ns. */
#define main example
#include "example.c"
#undef main

#define SYSTICK ((volatile uint32_t *)0xE000E010)
#define INSTRUCTIONS(ticks) ((unsigned long)((ticks) * 40 / 32))
enum { CONTROL, RELOAD, NOW };

int main(void) {
    FILE *file = fopen("vectors.bin", "rb");
    vector_t vector;
    controller_command_t command;
    uint64_t sum = 0, most = 0, n = 0;
    if (!file || controller_init(&controller, NUMBER, SEED)) return 1;
    SYSTICK[RELOAD] = 0xFFFFFF;
    SYSTICK[CONTROL] = 5; /* on, by the clock of the processor */
    for (; fread(&vector, sizeof vector, 1, file) == 1; n++) {
        SYSTICK[NOW] = 0;
        uint32_t before = SYSTICK[NOW];
        controller_tick(&controller, &vector.readings, vector.received, vector.n, &command);
        uint32_t cost = (before - SYSTICK[NOW]) & 0xFFFFFF;
        sum += cost;
        most = cost > most ? cost : most;
    }
    printf("%lu %lu\n", INSTRUCTIONS(sum / n), INSTRUCTIONS(most));
    return 0;
}
