"""A swarm in one file: the scenario `es1`, the engine `kinematic`, the controller `ssgikf`.

    python examples/tiny_forage.py 6000      # ticks of 0.1 s; prints the round trips

Robots drift from where they believe to be, and imitate those that stood on an area more recently:
social odometry (TR: Gutierrez et al. 2009). Begin with `tick`, at the end. The core goes through
the same poses, bit for bit; what it has in full, with all that is switched off here:

    start, scoring   swarm_forage_env/foraging/scoring.py
    tick, contacts   swarm_forage_env/epuck/tick.py, swarm_forage_env/epuck/surroundings.py
    sensors, radio   swarm_forage_env/epuck/sensors.py
    area memory      baselines/estimators/area_memory.py
    exchange         baselines/estimators/message_exchange.py, baselines/weighting/sgikf.py
    steering         baselines/motion/subsumption.py

Arrays have an element, or a row of two areas (nest, prey), for each of N robots. Points are complex
numbers, x + iy [m]. What crosses the border of sensors, radio or beliefs has 32 bits (f32).
"""

import sys

import numpy as np

from swarm_forage_env import find_scenario
from swarm_forage_env.arrays import Array
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.equations.elementary import atan2, cos_sin, hypot, log
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.random_streams import NoiseSource as Noise
from swarm_forage_env.random_streams import streams

ES1, SSGIKF = find_scenario("es1"), find_controller("ssgikf")
BODY, SENSORS, RADIO, TASK, DT = ES1.robot, ES1.sensors, ES1.radio, ES1.task, ES1.tick
SOCIAL, MOTION, N, SLOTS = SSGIKF.estimator, SSGIKF.motion, TASK.n_robots, RADIO.slots
NEST, PREY, NONE, ROBOTS, AREAS = 0, 1, -1, np.arange(N), np.arange(2)
WALLS = 0.5 * np.array([ES1.arena.length, ES1.arena.width])
BRIGHTNESS = np.array([0.0, 0.5, 1.0])  # of nest, prey and the rest: black, grey, white
ANGLES = np.radians([-17.0, -50.0, -90.0, -150.0, 150.0, 90.0, 50.0, 17.0])[:, None]  # infrared
# NumPy may round sines and products of complex numbers otherwise on each machine.
times, ratio = np.vectorize(lambda a, b: a * b), np.vectorize(lambda a, n: a / n)
unit = np.vectorize(lambda angle: complex(*cos_sin(angle)))
length = np.vectorize(lambda way: hypot(way.real, way.imag))
phase = np.vectorize(lambda way: atan2(way.imag, way.real))
wrapped, logarithm = np.vectorize(wrap), np.vectorize(log)  # the same angles in [-pi, pi)
f32 = np.vectorize(lambda number: float(np.float32(number)), otypes=[float])
RAYS = unit(ANGLES)


def to_arc(left: Array, right: Array) -> tuple[Array, Array]:
    """Distance and turn for the paths of both wheels. TR, Eq. 3 and 4."""
    return 0.5 * (right + left), (right - left) / BODY.axle


def advance(at: Array, heading: Array, drho: Array, dtheta: Array) -> None:
    """Move poses by a distance and a turn. TR, Eq. 7."""
    at += drho * unit(heading + 0.5 * dtheta)
    heading[:] = wrapped(heading + dtheta)


def response(d: Array | float) -> Array:
    """What an infrared sensor reads at a distance from the rim [m]. ARGoS3-epuck."""
    return (d <= 0.05) * np.clip((298.701 * d - 36.8961) * d + 1.08212, 0.0, 1.0)


def area_at(points: Array) -> Array:
    """The area that holds each point."""
    in_nest, in_prey = (length(points - complex(*c)) <= TASK.area_radius for c in ES1.areas)
    return np.where(in_nest, NEST, np.where(in_prey, PREY, NONE))


class World:
    """The robots: the truth, and what each believes in a frame of its own."""

    def __init__(self, seed: int) -> None:
        """Place each robot at random in a circle, where it overlaps none before it."""
        self.streams = {noise: streams([seed], N, noise) for noise in Noise}
        self.clock, self.at, self.believed_at = 0, *np.zeros((2, N), complex)
        self.paths = np.zeros((2, N))  # of the wheels in a tick [m]
        self.heading, self.believed_heading, self.turn, self.run = np.zeros((4, N))
        self.search = np.full(N, np.nan)  # path left to look for the goal where it should be [m]
        # The area to reach for a round trip, the one it was on, the goal; the robot it talks to.
        self.leg, self.came_from, self.goal, self.partner = np.full((4, N), NONE)
        self.round_trips, self.until, self.deaf_until = np.zeros((3, N), int)
        self.met_until = np.zeros((N, N), int)  # deaf to a partner of before
        # Of each area: whether it is known, was visited since the robot was last lost, is sent.
        self.is_on, self.is_goal, self.known, self.visited, self.sends = np.zeros((5, N, 2), bool)
        self.place, self.heard_sum = np.zeros((2, N, 2), complex)  # the centre; a sum over frames
        self.p, self.heard_p = np.zeros((2, N, 2))  # path since then [m]: its lack of confidence
        self.n_heard = np.zeros((N, 2), int)  # frames in the sum
        self.message = np.zeros((3, N, 2))  # distance, direction and p of each
        for i in ROBOTS:
            me, is_free = i == ROBOTS, False
            while not is_free:
                r = TASK.start_radius * np.sqrt(self.draw(Noise.PLACE, me))
                self.at[i] = (r * unit(np.pi * self.noise(Noise.PLACE, me)))[i]
                is_free = (length(self.at - self.at[i])[:i] >= 2.0 * BODY.radius).all()
            self.heading[i] = np.pi * self.noise(Noise.PLACE, me)[i]
        self.sense()

    def draw(self, noise: Noise, who: Array) -> Array:
        """Draw from [0, 1) for some robots, each from a stream of its own. SplitMix64."""
        self.streams[noise] = z = self.streams[noise] + who * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ z >> 30) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ z >> 27) * np.uint64(0x94D049BB133111EB)
        return ((z ^ z >> 31) >> 11) * 2.0**-53

    def noise(self, noise: Noise, who: Array) -> Array:
        """Draw from [-1, 1) for some robots; 0 for the others."""
        return np.where(who, 2.0 * self.draw(noise, who) - 1.0, 0.0)

    def noisy(self, readings: Array, most: float, noise: Noise) -> Array:
        """Readings of several sensors with a relative error; what reads nothing has none."""
        return [each * (1.0 + most * self.noise(noise, each != 0.0)) for each in readings]

    def steer(self) -> Array:
        """Talk, else avoid, else go to the goal, else wander: the wheels. TR, Section 5."""
        is_near = (self.infrared > response(MOTION.gap)) & (abs(ANGLES) <= MOTION.sector)
        near = phase(sum(np.where(is_near, self.infrared, 0.0) * RAYS))
        is_free = self.partner == NONE
        avoids = is_free & is_near.any(0)
        wanders = is_free & ~avoids & (self.goal == NONE)
        # Keep right of what is near, unless it is there.
        swerve = np.where(near < -np.pi / 6.0, MOTION.swerve, -MOTION.swerve)
        self.turn = np.where(avoids, wrapped(near + swerve), self.turn)
        # Wander straight on for a run of exponential length, then turn to a new direction.
        ends = wanders & (self.run <= 0.0)
        run = -MOTION.mean_run * logarithm(1.0 - self.draw(Noise.WANDER, ends))
        self.run = np.where(ends, run, self.run) - wanders * (BODY.cruise_speed * DT)
        self.turn = np.where(ends, np.pi * self.noise(Noise.WANDER, ends), self.turn)
        seen = times(self.place[ROBOTS, self.goal] - self.believed_at, unit(-self.believed_heading))
        seeks = (self.goal != NONE) & np.isnan(self.search)
        angle = np.where(
            avoids | wanders, self.turn, np.where(seeks, phase(np.complex64(seen)), 0.0)
        )
        forward = np.maximum(unit(angle).real, np.where(avoids, MOTION.creep, 0.0))
        turn = np.clip(angle / 0.5, -1.0, 1.0)
        wheels = np.array([forward - turn, forward + turn]) / np.maximum(1.0, forward + abs(turn))
        turned = 0.5 * (wheels[1] - wheels[0]) * (2.0 * BODY.cruise_speed * DT / BODY.axle)
        self.turn = np.where(is_free, wrapped(self.turn - turned), self.turn)
        return f32(wheels * is_free)

    def speak(self) -> None:
        """Merge what was heard, once an exchange is over, and compose the next message."""
        # Copy what was heard of an unknown area; blend that of the goal. TR, Eq. 14, 33 to 35.
        merges = (self.n_heard > 0) & (self.partner == NONE)[:, None]
        blends, copies = merges & self.known & self.is_goal, merges & ~self.known
        place, p_i = ratio(self.heard_sum, np.maximum(self.n_heard, 1)), f32(self.p[blends])
        g = f32(p_i / f32(p_i + self.heard_p[blends]))
        self.place[blends] = (1.0 - g) * self.place[blends] + g * place[blends]
        self.p[blends] *= 1.0 - g
        self.place[copies], self.p[copies] = place[copies], self.heard_p[copies]
        self.known |= copies
        self.heard_sum[merges], self.n_heard[merges] = 0.0, 0
        # Tell of areas it stood on; on its way, only of the one it comes from. TR, 4.1, 6.1.2.
        self.sends = self.visited & (~self.is_goal | ~self.known.all(1, keepdims=True))
        to = self.place - self.believed_at[:, None]
        turn = wrapped(phase(to) - self.believed_heading[:, None])
        self.message = f32([length(to), turn, self.p])

    def move(self, wheels: Array) -> None:
        """Turn the wheels, at shares of the cruise speed, and count the round trips."""
        self.paths = wheels * BODY.cruise_speed * DT
        advance(self.at, self.heading, *to_arc(*self.paths))
        is_near = length(self.at - self.at[:, None]) < RADIO.max_range + 0.02
        pairs, most, overlap = np.argwhere(np.tril(is_near, -1)), WALLS - BODY.radius, np.inf
        for passes in range(2000):  # move overlapping robots apart and inside the walls
            self.at = np.clip(self.at.view(float).reshape(N, 2), -most, most).view(complex)[:, 0]
            if overlap <= 1e-4:
                break
            overlap, share = 0.0, 0.5 if passes < 20 else 0.9
            for i, j in pairs:
                to = complex(self.at[j] - self.at[i])
                d = hypot(to.real, to.imag)
                own = max(2.0 * BODY.radius - d, 0.0)
                self.at[i] -= share * own * (to / d)
                self.at[j] += share * own * (to / d)
                overlap = max(overlap, own)
        # A round trip is nest, prey, nest. TR, Section 6.1.2.
        area = area_at(self.at + SENSORS.ground_ahead * unit(self.heading))
        self.round_trips += (area == NEST) & (self.leg == NEST)
        self.leg[(area == PREY) & (self.leg == PREY)] = NEST
        self.leg[area == NEST] = PREY

    def sense(self) -> tuple[Array, Array, Array]:
        """Distance and turn by the wheels' encoders, and three readings of the ground."""
        # Noisy paths of the wheels. ANTS, Section 4.1.
        error = SENSORS.wheel_noise * BODY.cruise_speed * DT
        paths = [u + error * self.noise(Noise.ENCODER, u != 0.0) for u in self.paths]
        # Brightness under the left, middle and right sensor. TR, Sections 5 and 6.1.
        offsets = [complex(SENSORS.ground_ahead, k * SENSORS.ground_spacing) for k in (1, 0, -1)]
        points = self.at + times(np.array(offsets)[:, None], unit(self.heading))
        ground = self.noisy(BRIGHTNESS[area_at(points)], SENSORS.ground_noise, Noise.GROUND)
        # How far infrared rays go to the walls and to other robots. TR, Section 6.1.
        u = times(unit(self.heading), RAYS)
        wall_x = (WALLS[0] - np.where(u.real > 0.0, self.at.real, -self.at.real)) / abs(u.real)
        wall_y = (WALLS[1] - np.where(u.imag > 0.0, self.at.imag, -self.at.imag)) / abs(u.imag)
        to = times(times(self.at[:, None] - self.at, unit(-self.heading)), np.conj(RAYS)[:, None])
        is_hit = (to.real > 0.0) & (abs(to.imag) < BODY.radius)
        half_chord = np.sqrt(np.maximum(BODY.radius * BODY.radius - to.imag * to.imag, 0.0))
        robot = np.where(is_hit, to.real - half_chord, np.inf).min(1)
        light = response(np.maximum(np.min([wall_x, wall_y, robot], 0) - BODY.radius, 0.0))
        light = self.noisy(light, SENSORS.proximity_noise, Noise.PROXIMITY)
        self.infrared = f32(np.minimum(light, 1.0))
        return *f32(to_arc(*paths)), f32(ground)

    def believe(self, drho: Array, dtheta: Array, ground: Array) -> None:
        """Update where the robot and the areas are, and where to go."""
        # Move the believed pose; confidence wanes with the path. TR, Eq. 7 and 13.
        advance(self.believed_at, self.believed_heading, drho, dtheta)
        self.p += (abs(drho) + 0.5 * abs(dtheta) * BODY.axle)[:, None]
        # Remember the centre of an area on entering it, if two of three ground sensors see it.
        seen = np.where(ground < 0.2, NEST, np.where(ground < 0.68, PREY, NONE))
        was_on, self.is_on = self.is_on, (seen[..., None] == AREAS).sum(0) >= 2
        robots, areas = np.nonzero(self.is_on & ~was_on)
        to_centre = (SENSORS.ground_ahead + TASK.area_radius) * unit(self.believed_heading)
        self.place[robots, areas] = (self.believed_at + to_centre)[robots]
        self.known[robots, areas] = self.visited[robots, areas] = True
        self.came_from[robots], self.search[robots] = areas, np.nan
        self.p[self.is_on] = 0.0
        # Forget both areas where the goal should be and is not. TR, Section 5.1.
        before, d = self.goal.copy(), length(self.place[ROBOTS, self.goal] - self.believed_at)
        begins = np.isnan(self.search) & (self.goal != NONE) & (d < SOCIAL.lost_within)
        self.search = np.where(begins, SOCIAL.overshoot, self.search - abs(drho))
        lost = self.search < 0.0
        self.known[lost] = self.visited[lost] = self.heard_sum[lost] = self.n_heard[lost] = 0
        self.goal[lost] = self.came_from[lost] = self.partner[lost] = NONE
        self.deaf_until[lost] = self.clock + round(SOCIAL.deaf_when_lost / DT)
        # From an area to the other; from nowhere to the nearer one known; else wander.
        d = np.where(self.known, length(self.place - self.believed_at[:, None]), np.inf)
        wish = np.where(self.goal == NONE, d.argmin(1), self.goal)
        wish = np.where(self.came_from == NONE, wish, np.where(self.came_from == NEST, PREY, NEST))
        self.goal = np.where(self.known[ROBOTS, wish], wish, NONE)
        self.is_goal = self.goal[:, None] == AREAS
        self.search[self.goal != before] = np.nan

    def hear(self) -> tuple[Array, Array, Array]:
        """Receive messages: the sender in each slot, its range and bearings, frames averaged."""
        # Some are lost, and of too many for the slots any are kept. TR, Section 6.1.
        share = (length(self.at - self.at[:, None]) - RADIO.near) / (RADIO.max_range - RADIO.near)
        lost = RADIO.loss_near + (RADIO.loss_far - RADIO.loss_near) * share
        reaches = (share <= 1.0) & self.sends.any(1) & (ROBOTS[:, None] != ROBOTS)
        senders, arrived = np.full((N, N), NONE), np.zeros(N, int)
        for j in ROBOTS:
            arrives = reaches[:, j] & (self.draw(Noise.LOSS, reaches[:, j]) >= lost[:, j])
            full = arrives & (arrived >= SLOTS)
            arrived += arrives
            slot = np.where(full, (self.draw(Noise.SLOT, full) * arrived).astype(int), arrived - 1)
            senders[slot[arrives], ROBOTS[arrives]] = j
        senders = senders[:SLOTS]
        frames = np.where(self.paths.any(0), 1, RADIO.frames)  # who stands averages several
        errors = np.zeros((3, SLOTS, N))
        for slot, which, frame in np.ndindex(SLOTS, 3, RADIO.frames):
            who = (senders[slot] != NONE) & (frame < frames)
            errors[which, slot] += self.noise(Noise.RADIO, who)
        to, most = self.at[senders] - self.at, RADIO.bearing_noise
        d = length(to) + RADIO.range_noise * errors[0] / frames
        gamma_i = wrapped(wrapped(phase(to) - self.heading) + most * errors[1] / frames)
        gamma_j = wrapped(wrapped(phase(-to) - self.heading[senders]) + most * errors[2] / frames)
        return senders, f32([d, gamma_i, gamma_j]), frames

    def exchange(self, senders: Array, beams: Array, frames: Array) -> None:
        """Stop for one neighbour for a while, and sum up what it tells. TR, Section 5.2."""
        is_useful = (self.sends[senders] & (~self.known | self.is_goal)).any(2)
        is_useful &= (senders != NONE) & (self.clock >= self.met_until[ROBOTS, senders])
        meets = (self.partner == NONE) & (self.clock >= self.deaf_until) & is_useful.any(0)
        self.partner = np.where(meets, senders[is_useful.argmax(0), ROBOTS], self.partner)
        self.until[meets] = self.clock + round(RADIO.exchange_time / DT)
        # Where the partner says that areas are, in the own frame. TR, Eq. 40.
        is_partner = (senders == self.partner) & (senders != NONE)
        d, gamma_i, gamma_j = beams[:, is_partner.argmax(0), ROBOTS][..., None]
        d_j, phi_j, p_j = self.message[:, self.partner]
        phi_i = f32(gamma_i + f32(phi_j - gamma_j)) - np.pi
        to, ahead = d * unit(gamma_i) + d_j * unit(phi_i), unit(self.believed_heading)[:, None]
        place = self.believed_at[:, None] + to.real * ahead + to.imag * (1j * ahead)
        is_heard = is_partner.any(0)[:, None] & self.sends[self.partner]
        self.heard_sum += is_heard * (frames[:, None] * place)
        self.n_heard += is_heard * frames[:, None]
        self.heard_p = np.where(is_heard, p_j, self.heard_p)
        # After that, listen to nobody for a while, and to this one for longer.
        ends = (self.partner != NONE) & (self.clock == self.until)
        self.met_until[ends, self.partner[ends]] = self.clock + round(SOCIAL.refractory / DT)
        self.deaf_until[ends] = self.clock + round(SOCIAL.pause / DT)
        self.partner[ends] = NONE


def tick(world: World) -> None:
    """One tick: decide, move, be scored, sense, believe, hear."""
    world.clock += 1
    wheels = world.steer()
    world.speak()
    world.move(wheels)
    world.believe(*world.sense())
    world.exchange(*world.hear())


if __name__ == "__main__":
    world = World(seed=0)
    for _ in range(int(sys.argv[1]) if len(sys.argv) > 1 else 6000):
        tick(world)
    print(world.round_trips.sum(), "round trips")
