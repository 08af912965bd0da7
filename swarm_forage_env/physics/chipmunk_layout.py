"""Memory layout of a space in Chipmunk, the C library that pymunk wraps.

From chipmunk_private.h and cpBBTree.c of Chipmunk 7 and of Munk2D, its successor in pymunk 7.
Fields that are never read are declared for their size.
"""

from cffi import FFI

LAYOUT = FFI()
LAYOUT.cdef("""
typedef struct { struct Pair *previous; struct Node *leaf; struct Pair *next; } Thread;

typedef struct Pair { Thread a, b; unsigned id; } Pair;  /* two leaves whose boxes overlap */

typedef struct Node {
    void *shape;  /* of a leaf */
    double box[4];  /* of all that is below it [m] */
    struct Node *parent;
    union {
        struct { struct Node *first, *second; };
        struct { unsigned stamp; Pair *pairs; };  /* of a leaf */
    };
} Node;

typedef struct Tree {
    void *functions[2];
    struct Tree *tree_of_walls, *tree_of_robots;
    void *velocity_of, *leaves;
    Node *root;
    void *pools[3];
    unsigned stamp;
} Tree;

typedef struct {
    int iterations;
    double gravity[2], damping, thresholds_of_sleep[2], collision_slop, collision_bias;
    unsigned collision_persistence;
    void *user_data;
    unsigned stamp;
    double last_step;
    void *bodies[4];
    size_t n_shapes_ever;
    Tree *walls, *robots;
    void *constraints;
    int *n_touching;  /* what the list of contacts begins with */
} Space;

typedef struct {
    void *functions[2];
    double mass[2], moment[2], centre[2], position[2], velocity[2], force[2];
    double angle, spin, torque, transform[6];
    void *user_data;
    double push[3];
    Space *space;
} Body;
""")
