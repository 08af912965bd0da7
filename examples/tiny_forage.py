"""A swarm in one file: the scenario `es1`, the engine `kinematic`, the controller `ssgikf`.

    python examples/tiny_forage.py 6000      # ticks of 0.1 s; prints the round trips

Robots drift from where they believe to be, and imitate those that stood on an area more recently:
social odometry (TR: Gutierrez et al. 2009). Begin with `tick`, at the end. The core, 70 times
faster, goes through the same poses, bit for bit. What it has in full, with all that is switched
off in this scenario and this controller:

    chance           swarm_forage_env/equations/random_draws.py
    start, scoring   swarm_forage_env/foraging/scoring.py
    motion, tick     swarm_forage_env/epuck/tick.py
    contacts         swarm_forage_env/epuck/surroundings.py
    sensors, radio   swarm_forage_env/epuck/sensors.py
    area memory      baselines/estimators/area_memory.py
    exchange         baselines/estimators/message_exchange.py, baselines/weighting/sgikf.py
    steering         baselines/motion/subsumption.py

Points are complex numbers, x + iy [m]; a product with rect(1, theta) turns one by theta. What
crosses the border of sensors, radio or beliefs has 32 bits (f32).
"""

import math
import sys
from collections.abc import Iterator

import numpy as np

from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.equations.elementary import atan2, cos_sin, hypot, log
from swarm_forage_env.random_streams import NoiseSource as Cause

ES1, SSGIKF = find_scenario("es1"), find_controller("ssgikf")
BODY, SENSORS, RADIO, TASK, DT = ES1.robot, ES1.sensors, ES1.radio, ES1.task, ES1.tick
SOCIAL, MOTION, SIDES = SSGIKF.estimator, SSGIKF.motion, (ES1.arena.length, ES1.arena.width)
NEST, PREY, CENTRES = 0, 1, [complex(*centre) for centre in ES1.areas]
BRIGHTNESS = {NEST: 0.0, PREY: 0.5, None: 1.0}  # of the ground: black, grey, white
ANGLES = np.radians([-17.0, -50.0, -90.0, -150.0, 150.0, 90.0, 50.0, 17.0]).tolist()  # infrared


def f32(*numbers: float) -> list[float]:
    """Round to 32 bits."""
    return np.float32(numbers).tolist()


def rect(r: float, angle: float) -> complex:
    """The point at a distance and a direction."""
    c, s = cos_sin(angle)
    return complex(r * c, r * s)


def length(way: complex) -> float:
    """How long a way is."""
    return hypot(way.real, way.imag)


def phase(way: complex) -> float:
    """The direction of a way, in [-pi, pi]."""
    return atan2(way.imag, way.real)


def wrap(angle: float) -> float:
    """The same angle in [-pi, pi)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


def mix(z: int) -> int:
    """Scramble 64 bits, as SplitMix64 does."""
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
    z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
    return z ^ z >> 31


def draws(seed: int, robot: int, cause: int) -> Iterator[float]:
    """Uniform numbers in [0, 1): a stream for each robot and cause, so that none moves another."""
    word = mix((seed + 0x9E3779B97F4A7C15) % 2**64)
    word = mix((word + (robot + 1) * 0xD1342543DE82EF95) % 2**64)
    word = mix((word + (cause + 1) * 0x2545F4914F6CDD1D) % 2**64)
    while True:
        word = (word + 0x9E3779B97F4A7C15) % 2**64
        yield (mix(word) >> 11) * 2.0**-53


def to_arc(left: float, right: float) -> tuple[float, float]:
    """Distance and turn for the paths of both wheels. TR, Eq. 3 and 4."""
    return 0.5 * (right + left), (right - left) / BODY.axle


def response(d: float) -> float:
    """What an infrared sensor reads at a distance from the rim [m]. ARGoS3-epuck."""
    return min(max((298.701 * d - 36.8961) * d + 1.08212, 0.0), 1.0) if d <= 0.05 else 0.0


def area_at(point: complex) -> int | None:
    """The area that holds a point."""
    return next((a for a in (NEST, PREY) if length(point - CENTRES[a]) <= TASK.area_radius), None)


class Pose:
    """A place and a heading, true or believed."""

    at, heading = 0j, 0.0

    def advance(self, drho: float, dtheta: float) -> None:
        """Go on by a distance and a turn. TR, Eq. 7."""
        self.at += rect(drho, self.heading + 0.5 * dtheta)
        self.heading = wrap(self.heading + dtheta)


class Mind(Pose):
    """What a robot knows, in a frame of its own: of the truth only what it sensed and heard."""

    def __init__(self, walk: Iterator[float]) -> None:
        self.place, self.p = {}, [0.0, 0.0]  # centres of the known areas; path since each [m]
        self.visited = set()  # areas it stood on since it was last lost
        self.on_area = self.came_from = self.goal = None  # no goal: it wanders
        self.search = None  # path left to look for the goal where it should be [m]
        self.partner, self.until, self.told = None, 0, {}  # of an area: sum of places, frames, p
        self.deaf_until, self.met_until = 0, {}  # deaf to all, or to a partner of before
        self.turn, self.run, self.walk = 0.0, 0.0, walk  # left to turn and to go straight on

    def dead_reckon(self, drho: float, dtheta: float) -> None:
        """Move the believed pose; confidence wanes with the path. TR, Eq. 7 and 13."""
        self.advance(drho, dtheta)
        self.p = [p + (abs(drho) + 0.5 * abs(dtheta) * BODY.axle) for p in self.p]

    def find_areas(self, ground: list[float]) -> None:
        """Remember the centre of an area on entering it, if two of three ground sensors see it."""
        seen = [NEST if light < 0.2 else PREY if light < 0.68 else None for light in ground]
        area = next((area for area in (NEST, PREY) if seen.count(area) >= 2), None)
        if area is not None:
            self.p[area] = 0.0
            if area != self.on_area:
                to_centre = SENSORS.ground_ahead + TASK.area_radius
                self.place[area] = self.at + to_centre * rect(1.0, self.heading)
                self.visited.add(area)
                self.came_from, self.search = area, None
        self.on_area = area

    def notice_loss(self, drho: float, clock: int) -> None:
        """Forget both areas where the goal should be and is not. TR, Section 5.1."""
        if self.search is not None:
            self.search -= abs(drho)
            if self.search < 0.0:
                self.place, self.visited, self.told = {}, set(), {}
                self.goal = self.came_from = self.search = self.partner = None
                self.deaf_until = clock + round(SOCIAL.deaf_when_lost / DT)
        elif self.goal is not None and length(self.place[self.goal] - self.at) < SOCIAL.lost_within:
            self.search = SOCIAL.overshoot

    def choose_goal(self) -> None:
        """From an area to the other; from nowhere to the nearer one known; else wander."""
        before = self.goal
        if self.came_from is not None:
            self.goal = 1 - self.came_from if 1 - self.came_from in self.place else None
        elif self.goal is None:
            ways = {area: length(place - self.at) for area, place in self.place.items()}
            self.goal = min(ways, key=ways.get, default=None)
        if self.goal != before:
            self.search = None

    def exchange(self, heard: list[tuple], clock: int) -> None:
        """Stop for one neighbour for a while, and sum up what it tells. TR, Section 5.2."""
        if self.partner is None and clock >= self.deaf_until:
            for sender, *_, message in heard:
                is_useful = any(a not in self.place or a == self.goal for a in message)
                if clock >= self.met_until.get(sender, 0) and is_useful:
                    self.partner, self.until = sender, clock + round(RADIO.exchange_time / DT)
                    break
        for sender, *beam, frames, message in heard:
            if sender == self.partner:
                self.listen(beam, frames, message)
        if self.partner is not None and clock == self.until:
            self.met_until[self.partner] = clock + round(SOCIAL.refractory / DT)
            self.partner, self.deaf_until = None, clock + round(SOCIAL.pause / DT)

    def listen(self, beam: list[float], frames: int, message: dict[int, list[float]]) -> None:
        """Where the partner says that areas are, in the own frame. TR, Eq. 40."""
        (d, gamma_i, gamma_j), x, y = beam, self.at.real, self.at.imag
        c, s = cos_sin(self.heading)
        for area, (d_j, phi_j, p_j) in message.items():
            phi_i = f32(gamma_i + f32(phi_j - gamma_j)[0])[0] - math.pi
            to = rect(d, gamma_i) + rect(d_j, phi_i)
            place = complex(x + c * to.real - s * to.imag, y + s * to.real + c * to.imag)
            total, n, _ = self.told.get(area, (0j, 0, 0.0))
            self.told[area] = total + frames * place, n + frames, p_j

    def merge(self) -> None:
        """Copy what was told of an unknown area; blend that of the goal. TR, Eq. 14, 33 to 35."""
        if self.partner is not None:
            return
        for area, (total, frames, p_j) in self.told.items():
            if area not in self.place:
                self.place[area], self.p[area] = total / frames, p_j
            elif area == self.goal:
                p_i = f32(self.p[area])[0]
                g = f32(p_i / f32(p_i + p_j)[0])[0]
                self.place[area] = (1.0 - g) * self.place[area] + g * (total / frames)
                self.p[area] = (1.0 - g) * self.p[area]
        self.told = {}

    def compose(self) -> dict[int, list[float]]:
        """Tell of areas it stood on; on its way, only of the one it comes from. TR 4.1, 6.1.2."""
        ways = {area: self.place[area] - self.at for area in self.visited}
        return {
            area: f32(length(to), wrap(phase(to) - self.heading), self.p[area])
            for area, to in ways.items()
            if area != self.goal or len(self.place) == 1
        }

    def avoid(self, infrared: list[float]) -> bool:
        """Turn past what is near in front: keep right, unless it is there. TR, Section 5.1."""
        near, total = response(MOTION.gap), 0j
        for reading, angle in zip(infrared, ANGLES, strict=True):
            if reading > near and abs(angle) <= MOTION.sector:
                total += reading * rect(1.0, angle)
        if total:
            swerve = MOTION.swerve if phase(total) < -math.pi / 6.0 else -MOTION.swerve
            self.turn = wrap(phase(total) + swerve)
        return bool(total)

    def wander(self) -> None:
        """Go straight on for a path of exponential length, then turn to a new direction."""
        if self.run <= 0.0:
            self.run = -MOTION.mean_run * log(1.0 - next(self.walk))
            self.turn = math.pi * (2.0 * next(self.walk) - 1.0)
        self.run -= BODY.cruise_speed * DT

    def steer(self, infrared: list[float]) -> list[float]:
        """Talk, else avoid, else go to the goal, else wander. TR, Section 5."""
        if self.partner is not None:
            return [0.0, 0.0]
        angle, creep = 0.0, 0.0
        if self.avoid(infrared):
            angle, creep = self.turn, MOTION.creep
        elif self.goal is None:
            self.wander()
            angle = self.turn
        elif self.search is None:
            to = (self.place[self.goal] - self.at) * rect(1.0, -self.heading)
            angle = phase(complex(*f32(to.real, to.imag)))
        forward = max(rect(1.0, angle).real, creep)
        turn = min(max(angle / 0.5, -1.0), 1.0)
        scale = max(1.0, forward + abs(turn))
        left, right = (forward - turn) / scale, (forward + turn) / scale
        turned = 0.5 * (right - left) * (2.0 * BODY.cruise_speed * DT / BODY.axle)
        self.turn = wrap(self.turn - turned)
        return f32(left, right)


class Robot(Pose):
    """The truth about a robot, what it senses and says, and its mind."""

    def __init__(self, seed: int, number: int) -> None:
        self.streams = {cause: draws(seed, number, cause) for cause in Cause}
        self.number, self.near, self.mind = number, [], Mind(self.streams[Cause.WANDER])
        self.paths, self.infrared = [0.0, 0.0], []  # of the wheels in a tick [m]
        self.message = {}  # of no area: it is silent
        self.leg, self.round_trips = None, 0  # the area it has to reach, once it was in the nest

    def noise(self, cause: Cause) -> float:
        """Draw from [-1, 1)."""
        return 2.0 * next(self.streams[cause]) - 1.0

    def drive(self, wheels: list[float]) -> None:
        """Turn the wheels, at shares of the cruise speed."""
        self.paths = [share * BODY.cruise_speed * DT for share in wheels]
        self.advance(*to_arc(*self.paths))

    def score(self) -> None:
        """Count the round trips: nest, prey, nest. TR, Section 6.1.2."""
        area = area_at(self.at + SENSORS.ground_ahead * rect(1.0, self.heading))
        if area == NEST:
            self.round_trips += self.leg == NEST
            self.leg = PREY
        elif area == PREY and self.leg == PREY:
            self.leg = NEST

    def read_encoders(self) -> list[float]:
        """Distance and turn of a tick, from noisy paths of the wheels. ANTS, Section 4.1."""
        error = SENSORS.wheel_noise * BODY.cruise_speed * DT
        return f32(*to_arc(*(u and u + error * self.noise(Cause.ENCODER) for u in self.paths)))

    def read_ground(self) -> list[float]:
        """Brightness under the left, middle and right sensor. TR, Sections 5 and 6.1."""
        ahead, side = SENSORS.ground_ahead, SENSORS.ground_spacing
        sensors = [complex(ahead, k * side) * rect(1.0, self.heading) for k in (1, 0, -1)]
        lights = (BRIGHTNESS[area_at(self.at + sensor)] for sensor in sensors)
        most = SENSORS.ground_noise
        return f32(*(light and light * (1.0 + most * self.noise(Cause.GROUND)) for light in lights))

    def read_infrared(self) -> list[float]:
        """What the eight infrared sensors see of walls and of other robots. TR, Section 6.1."""
        lights, most = (
            (response(self.ray_length(angle)) for angle in ANGLES),
            SENSORS.proximity_noise,
        )
        noisy = (light and light * (1.0 + most * self.noise(Cause.PROXIMITY)) for light in lights)
        return f32(*(min(light, 1.0) for light in noisy))

    def ray_length(self, angle: float) -> float:
        """How far a ray goes from the rim [m]."""
        ahead, ray = rect(1.0, self.heading), rect(1.0, angle)
        u = ahead * ray
        axes = zip(SIDES, (self.at.real, self.at.imag), (u.real, u.imag), strict=True)
        nearest = min((0.5 * side - (x if c > 0.0 else -x)) / abs(c) for side, x, c in axes)
        for other in self.near:
            to = (other.at - self.at) * ahead.conjugate() * ray.conjugate()
            if to.real > 0.0 and abs(to.imag) < BODY.radius:
                half_chord = math.sqrt(BODY.radius * BODY.radius - to.imag * to.imag)
                nearest = min(nearest, to.real - half_chord)
        return max(nearest - BODY.radius, 0.0)

    def hear(self) -> list[tuple]:
        """Receive messages: some are lost, and of too many for the slots any are kept. TR 6.1."""
        senders, arrived = [], 0
        for sender in self.near:
            share = (length(sender.at - self.at) - RADIO.near) / (RADIO.max_range - RADIO.near)
            lost = RADIO.loss_near + (RADIO.loss_far - RADIO.loss_near) * share
            if sender.message and share <= 1.0 and next(self.streams[Cause.LOSS]) >= lost:
                slot, arrived = arrived, arrived + 1
                if slot >= ES1.slots:
                    slot = int(next(self.streams[Cause.SLOT]) * arrived)
                if slot < ES1.slots:
                    senders[slot : slot + 1] = [sender]
        return [self.measure(sender) for sender in senders]

    def measure(self, sender: "Robot") -> tuple:
        """Who speaks; range, bearing and bearing back; of so many frames; what it says."""
        frames = 1 if any(self.paths) else RADIO.frames  # who stands averages several

        def error(most: float) -> float:
            return most * sum(self.noise(Cause.RADIO) for _ in range(frames)) / frames

        to = sender.at - self.at
        d = length(to) + error(RADIO.range_noise)
        gamma_i = wrap(wrap(phase(to) - self.heading) + error(RADIO.bearing_noise))
        gamma_j = wrap(wrap(phase(-to) - sender.heading) + error(RADIO.bearing_noise))
        return sender.number, *f32(d, gamma_i, gamma_j), frames, sender.message


class World:
    """All robots, at first at random in a circle where none overlaps another; and the clock."""

    def __init__(self, seed: int) -> None:
        self.clock, self.robots = 0, []
        for number in range(TASK.n_robots):
            robot, is_free = Robot(seed, number), False
            while not is_free:
                r = TASK.start_radius * math.sqrt(next(robot.streams[Cause.PLACE]))
                robot.at = rect(r, math.pi * robot.noise(Cause.PLACE))
                is_free = all(length(robot.at - o.at) >= 2.0 * BODY.radius for o in self.robots)
            robot.heading = math.pi * robot.noise(Cause.PLACE)
            self.robots.append(robot)
        find_neighbours(self.robots)
        for robot in self.robots:
            robot.read_ground()
            robot.infrared = robot.read_infrared()


def find_neighbours(robots: list[Robot]) -> None:
    """List who is near whom, by ascending numbers."""
    for me in robots:
        others = (other for other in robots if other is not me)
        me.near = [other for other in others if length(other.at - me.at) < RADIO.max_range + 0.02]


def resolve_contacts(robots: list[Robot]) -> None:
    """Move overlapping robots apart and inside the walls, until no overlap is large."""
    far_x, far_y = (0.5 * side - BODY.radius for side in SIDES)
    pairs = [(me, other) for me in robots for other in me.near if other.number < me.number]
    overlaps = [math.inf]
    for passes in range(2000):
        for robot in robots:
            x, y = robot.at.real, robot.at.imag
            robot.at = complex(min(max(x, -far_x), far_x), min(max(y, -far_y), far_y))
        if max(overlaps, default=0.0) <= 1e-4:
            return
        overlaps = [separate(*pair, 0.5 if passes < 20 else 0.9) for pair in pairs]


def separate(me: Robot, other: Robot, share: float) -> float:
    """Move two robots apart, each by a share of their overlap, which is returned [m]."""
    to = other.at - me.at
    overlap = max(2.0 * BODY.radius - length(to), 0.0)
    way = share * overlap * (to / length(to))
    me.at, other.at = me.at - way, other.at + way
    return overlap


def tick(world: World) -> None:
    """One tick: decide, move, be scored, sense, hear, believe."""
    world.clock += 1
    for robot in world.robots:
        wheels = robot.mind.steer(robot.infrared)
        robot.mind.merge()
        robot.message = robot.mind.compose()
        robot.drive(wheels)
    find_neighbours(world.robots)
    resolve_contacts(world.robots)
    for robot in world.robots:
        robot.score()
        odometry, robot.infrared = robot.read_encoders(), robot.read_infrared()
        robot.mind.dead_reckon(*odometry)
        robot.mind.find_areas(robot.read_ground())
        robot.mind.notice_loss(odometry[0], world.clock)
        robot.mind.choose_goal()
        robot.mind.exchange(robot.hear(), world.clock)


if __name__ == "__main__":
    world = World(seed=0)
    for _ in range(int(sys.argv[1]) if len(sys.argv) > 1 else 6000):
        tick(world)
    print(sum(robot.round_trips for robot in world.robots), "round trips")
