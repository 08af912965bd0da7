/* Replays vectors.bin, $n_ticks ticks of robot $number in the simulated world of seed $seed, and counts
 * those in which the controller says the same, bit for bit. */
#include <stdio.h>

#include "controller.h"

typedef struct {
    controller_readings_t readings;
    int32_t n;
    controller_received_t received[CONTROLLER_SLOTS];
    float wheels[2];
    int32_t is_speaking;
    int32_t has_payload; /* somebody listened in the simulator */
    controller_payload_t payload;
} vector_t;

_Static_assert(sizeof(vector_t) == CONTROLLER_VECTOR_SIZE, "vectors are laid out as C does");

enum { NUMBER = $number, SEED = $seed, N_TICKS = $n_ticks };

static controller_t controller;

static int is_equal(const vector_t *vector, const controller_command_t *command) {
    return memcmp(vector->wheels, command->wheels, sizeof vector->wheels) == 0 &&
           vector->is_speaking == command->is_speaking &&
           (!vector->has_payload ||
            memcmp(&vector->payload, &command->payload, sizeof vector->payload) == 0);
}

int main(void) {
    FILE *file = fopen("vectors.bin", "rb");
    vector_t vector;
    controller_command_t command;
    int n_ticks = 0, n_equal = 0;
    if (!file) {
        printf("vectors.bin: cannot be read; run the example in its folder\n");
        return 1;
    }
    if (controller_init(&controller, NUMBER, SEED)) return 1;
    while (fread(&vector, sizeof vector, 1, file) == 1) {
        n_ticks++;
        if (controller_tick(&controller, &vector.readings, vector.received, vector.n, &command) == 0)
            n_equal += is_equal(&vector, &command);
    }
    if (n_ticks != N_TICKS)
        printf("vectors.bin: holds %d ticks of %d; export the controller again\n", n_ticks, N_TICKS);
    printf("%d of %d equal\n", n_equal, N_TICKS);
    return n_ticks != N_TICKS || n_equal < N_TICKS;
}
