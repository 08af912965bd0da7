/* $name in $scenario: the controller of one e-puck, as swarm-forage $version simulates it.
 *
 * Call controller_tick every $tick s: it takes in what was sensed and heard since the last call, and
 * says how the wheels are to turn until the next one and what to broadcast. Angles count
 * counterclockwise from straight ahead, in the frame of the robot's body. There is no heap. Of libc it
 * calls memcpy and memset, and where the processor has no double also floor, sqrt and the compiler's
 * sums and products, which must round as IEEE 754 says.
 * Include it in one file of C: each that does gets a copy of the numbers.
 */
#ifndef SWARM_FORAGE_CONTROLLER_H
#define SWARM_FORAGE_CONTROLLER_H
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
#define CONTROLLER_ALIGNAS alignas
#define CONTROLLER_ASSERT static_assert
extern "C" {
#else
#define CONTROLLER_ALIGNAS _Alignas
#define CONTROLLER_ASSERT _Static_assert
#endif

#include "controller_data.h" /* sizes and places in memory, and the numbers of the layers */

#define CONTROLLER_ROBOTS $n_robots  /* in the swarm; a robot's number is less */
#define CONTROLLER_SLOTS $slots   /* messages in a tick, at most */
#define CONTROLLER_CRUISE $cruise /* speed of a wheel that is told 1 [m/s] */

/* What the robot's own sensors say after a tick. */
typedef struct {
    float proximity[8]; /* infrared, 1 at contact and 0 beyond 5 cm, as the e-puck counts its sensors */
    float ground[3];    /* brightness under the left, middle and right sensor: black 0, white 1 */
    float odometry[2];  /* since the last tick: distance [m] and turn [rad], by the wheel encoders */
} controller_readings_t;

$payload

/* A message that reached the robot, and where its sender is. */
typedef struct {
    float range;        /* centre to centre [m] */
    float bearing;      /* of the sender, in the frame of this robot [rad] */
    float bearing_back; /* of this robot, in the frame of the sender [rad] */
    float n_averaged;   /* frames averaged into these three; 1 if one was measured */
    int32_t sender;     /* the number of the robot that sent it */
    controller_payload_t payload;
} controller_received_t;

/* What the robot does until the next tick. */
typedef struct {
    float wheels[2];      /* speed of the left and right wheel, as a share of CONTROLLER_CRUISE */
    int32_t is_speaking;  /* broadcast the payload, or be silent */
    controller_payload_t payload;
} controller_command_t;

/* All that a robot keeps. Nothing in it is to be written by hand. */
typedef struct {
    CONTROLLER_ALIGNAS(8) uint8_t robots[CONTROLLER_ROBOTS * CONTROLLER_ROBOT_SIZE];
    CONTROLLER_ALIGNAS(8) uint8_t minds[CONTROLLER_ROBOTS * CONTROLLER_MIND_SIZE];
    CONTROLLER_ALIGNAS(8) uint8_t memories[CONTROLLER_ROBOTS * CONTROLLER_MEMORY_SIZE];
${policy_fields}    int64_t number;
} controller_t;

int swarm_run(int64_t *result, void **error, void *robots, void *minds, void *memories,
              const void *nothing, const void *settings,${policy_taken}
              int64_t robot, int64_t operation, int64_t seed);

CONTROLLER_ASSERT(sizeof(controller_readings_t) == CONTROLLER_READINGS_SIZE,
                  "readings are laid out as C does");
CONTROLLER_ASSERT(sizeof(controller_payload_t) == CONTROLLER_PAYLOAD_SIZE,
                  "payloads are laid out as C does");

static inline size_t controller_size(void) { return sizeof(controller_t); }

static inline int controller_run(controller_t *self, int64_t operation, int64_t seed) {
    int64_t result = 0;
    void *error = 0;
    int failed = swarm_run(&result, &error, self->robots, self->minds, self->memories,
                           controller_settings, controller_settings,${policy_given}
                           self->number, operation, seed);
    return failed || result != 0;
}

/* Start the controller of the robot of this number, below CONTROLLER_ROBOTS; its random walk is the
 * one that the robot of that number has in the world of this seed. Returns 0, or 1 for a number that
 * is too large. */
static inline int controller_init(controller_t *self, int32_t number, int64_t seed) {
    if (number < 0 || number >= CONTROLLER_ROBOTS) return 1;
    memset(self, 0, sizeof *self);
    for (int k = 0; k < CONTROLLER_ROBOTS; k++) {
        memcpy(self->minds + k * CONTROLLER_MIND_SIZE, controller_first_mind, CONTROLLER_MIND_SIZE);
        memcpy(self->memories + k * CONTROLLER_MEMORY_SIZE, controller_first_memory,
               CONTROLLER_MEMORY_SIZE);
    }
    self->number = number;
    return controller_run(self, 1, seed);
}

/* One tick. Returns 0; 1 for more than CONTROLLER_SLOTS messages, a sender that is no other robot's
 * number, or a command or weight that cannot be used: the robot should then stand still. */
static inline int controller_tick(controller_t *self, const controller_readings_t *readings,
                                  const controller_received_t *received, int n_received,
                                  controller_command_t *command) {
    uint8_t *robot = self->robots + self->number * CONTROLLER_ROBOT_SIZE;
    uint8_t *heard = robot + CONTROLLER_HEARD;
    int32_t n = n_received;
    if (n < 0 || n > CONTROLLER_SLOTS) return 1;
    memcpy(robot + CONTROLLER_READINGS, readings, CONTROLLER_READINGS_SIZE);
    memset(heard, 0, CONTROLLER_HEARD_SIZE);
    memcpy(heard + CONTROLLER_HEARD_N, &n, sizeof n);
    for (int k = 0; k < n; k++) {
        const controller_received_t *each = received + k;
        const float is_valid = 1.0f;
        if (each->sender < 0 || each->sender >= CONTROLLER_ROBOTS || each->sender == self->number)
            return 1;
        memcpy(heard + CONTROLLER_HEARD_VALID + 4 * k, &is_valid, 4);
        memcpy(heard + CONTROLLER_HEARD_RANGE_BEARING + 12 * k, &each->range, 12);
        memcpy(heard + CONTROLLER_HEARD_AVERAGED + 4 * k, &each->n_averaged, 4);
        memcpy(heard + CONTROLLER_HEARD_SENDER + 4 * k, &each->sender, 4);
        memcpy(self->minds + each->sender * CONTROLLER_MIND_SIZE + CONTROLLER_MESSAGE,
               &each->payload, CONTROLLER_PAYLOAD_SIZE);
    }
${clear_message}    if (controller_run(self, 0, 0)) return 1;
    memcpy(command->wheels, robot + CONTROLLER_COMMAND_WHEELS, sizeof command->wheels);
    command->is_speaking = robot[CONTROLLER_COMMAND_SPEAKING] != 0;
    memcpy(&command->payload, self->minds + self->number * CONTROLLER_MIND_SIZE + CONTROLLER_MESSAGE,
           CONTROLLER_PAYLOAD_SIZE);
    return 0;
}

#ifdef __cplusplus
}
#endif
#endif
