"""Painter: draws scenes to pictures in memory, without a display."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pygame

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.rendering import palette, shapes
from swarm_forage_env.rendering.hud import HeadUpDisplay
from swarm_forage_env.rendering.layout import P_RING, Layout
from swarm_forage_env.rendering.palette import Colour, mixed, trail_colour
from swarm_forage_env.rendering.trails import Trails
from swarm_forage_env.scene import WITHIN, GoalField, Localised, Scene, Stage

FINENESS = 3
"""Factor by which the arena is enlarged when drawn; scaling down smooths its edges."""


@dataclass
class Show:
    """Options for what is drawn besides the robots."""

    trails: bool = True
    beliefs: bool = True
    messages: bool = True
    selected: int | None = None
    """Index of the robot with drawn beliefs."""


class Painter:
    """Painter of the scenes of one stage."""

    def __init__(self, stage: Stage, layout: Layout) -> None:
        self.layout, self._stage = layout, stage
        self._fine = FINENESS if layout.width <= 640 else 2
        self._scale = layout.scale * self._fine
        """Pixels of the canvas per metre."""
        self._pixel = layout.unit * self._fine
        """Normal width of a line on the canvas [px]."""
        self._wall = max(2, round(2 * layout.unit))
        """Thickness of the walls around the arena [px]."""
        self._trails = Trails()
        pygame.font.init()
        self._large = pygame.font.Font(None, round(1.1 * layout.text * self._fine))
        self._areas = stage.areas_at(0.0)
        self._places: dict[int, int] = {}
        length, height = (side + 2 * self._wall for side in layout.arena)
        self._smooth = pygame.Surface((length, height), depth=32)
        self._canvas = pygame.Surface((self._fine * length, self._fine * height), depth=32)
        self._inside = self._canvas.get_rect().inflate(*([-2 * self._fine * self._wall] * 2))
        """Rectangle of the arena on the canvas."""
        self._floor = self._empty_floor()
        self._picture = pygame.Surface((layout.width, layout.height), depth=32)
        self._panel = HeadUpDisplay(stage, layout, self._picture)

    def take(self, scene: Scene) -> None:
        """Add a scene, drawn or not, to the trails and recent messages."""
        self._trails.take(scene)

    def paint(self, scene: Scene, show: Show, note: str = "") -> pygame.Surface:
        """Return the picture of the last scene given to `take`; the next call overwrites it."""
        areas = self._stage.areas_at(scene.time)
        if not np.array_equal(areas, self._areas):
            self._areas = areas
            self._floor = self._empty_floor()
        self._canvas.blit(self._floor, (0, 0))
        if show.trails:
            self._draw_trails(scene)
        if self._stage.goals is None or scene.localised is None:
            self._draw_foraging(scene, show)
        else:
            self._draw_visits(self._stage.goals, scene, scene.localised, show)
        self._draw_robots(scene, show.selected)
        if self.layout.enlarges:
            self._draw_rims()
        self._write_names(scene)
        pygame.transform.smoothscale(self._canvas, self._smooth.get_size(), self._smooth)
        self._panel.draw(scene, show.selected, note)
        x, y = self.layout.corner
        self._picture.blit(self._smooth, (x - self._wall, y - self._wall))
        return self._picture

    def _draw_foraging(self, scene: Scene, show: Show) -> None:
        if show.messages:
            spots, width = self._spot(scene.pose[:, :2]), max(2, round(1.4 * self._pixel))
            for sender, receiver in self._trails.messages().tolist():
                shapes.draw_arc(self._canvas, spots[sender], spots[receiver], width)
        if show.beliefs and show.selected is not None:
            self._draw_beliefs(scene, show.selected)

    def _draw_visits(self, field: GoalField, scene: Scene, own: Localised, show: Show) -> None:
        if show.messages:
            self._draw_lidar(scene, field.reach * self._scale, show.selected)
        self._draw_goals(scene, own, field.tolerance * self._scale, show.selected)
        self._draw_claims()
        if show.beliefs:
            self._draw_estimates(scene, own, show.selected)

    def _draw_lidar(self, scene: Scene, radius: float, selected: int | None) -> None:
        """Draw the reach of each robot [px], and lines between robots that see each other."""
        canvas, spots, width = self._canvas, self._spot(scene.pose[:, :2]), self._width(0.8)
        pale = mixed(palette.LIDAR, palette.FLOOR, 0.45)
        for spot in spots.tolist():
            pygame.draw.circle(canvas, pale, spot, radius, width)
        if selected is not None:
            pygame.draw.circle(canvas, palette.LIDAR, spots[selected], radius, 2 * width)
        for sender, receiver in scene.messages.tolist():
            if sender < receiver:
                pygame.draw.line(canvas, palette.MESSAGE, spots[sender], spots[receiver], width)

    def _draw_goals(
        self, scene: Scene, own: Localised, radius: float, selected: int | None
    ) -> None:
        """Draw each goal with the radius in which it is reached [px], and a line from its robot."""
        goals, spots = self._spot(own.goal), self._spot(scene.pose[:, :2])
        for robot, (goal, spot) in enumerate(zip(goals.tolist(), spots.tolist(), strict=True)):
            is_selected = robot == selected
            ink = palette.GOAL if is_selected else mixed(palette.GOAL, palette.FLOOR, 0.35)
            width = self._width(1.6 if is_selected else 0.8)
            pygame.draw.line(self._canvas, ink, spot, goal, width)
            shapes.draw_goal(self._canvas, goal, radius, self._pixel)

    def _draw_claims(self) -> None:
        """Draw recent claims: a disc if right, a cross with a line to the goal if wrong."""
        size = 4.5 * self._pixel
        for claim in self._trails.claims:
            place, goal = self._spot(claim.place), self._spot(claim.goal)
            if claim.is_right:
                shapes.draw_right(self._canvas, place, size)
            else:
                pygame.draw.line(self._canvas, palette.WRONG, place, goal, self._width(0.8))
                shapes.draw_wrong(self._canvas, place, size)

    def _draw_estimates(self, scene: Scene, own: Localised, selected: int | None) -> None:
        """Draw estimated positions: 95 % ellipses, with lines to the true positions."""
        spots, true = self._spot(own.believed), self._spot(scene.pose[:, :2])
        axes, direction = WITHIN * self._scale * own.ellipse[:, :2], own.ellipse[:, 2].tolist()
        for robot, (long, short) in enumerate(axes.tolist()):
            if long > 0.0:
                width = self._width(2.4 if robot == selected else 1.2)
                pygame.draw.line(self._canvas, palette.ESTIMATE, true[robot], spots[robot], width)
                size = long, short
                shapes.draw_ellipse(self._canvas, spots[robot], size, direction[robot], width)

    def _width(self, width: float) -> int:
        return max(1, round(width * self._pixel))

    def _spot(self, places: Float64[Array, "*any 2"]) -> Float64[Array, "*any 2"]:
        """Convert the world frame [m] to pixels of the canvas."""
        return np.asarray((self.layout.pixels(places) + self._wall) * self._fine)

    def _empty_floor(self) -> pygame.Surface:
        stage = self._stage
        floor = pygame.Surface(self._canvas.get_size(), depth=32)
        floor.fill(palette.WALL)
        if len(stage.corners):
            pygame.draw.polygon(floor, palette.FLOOR, self._spot(stage.corners).tolist())
        else:
            floor.fill(palette.FLOOR, self._inside)
        ring = stage.start_radius
        if stage.goals is not None:
            ring = stage.goals.reach
            self._draw_field(floor, 0.5 * stage.goals.side)
        stroke = self._width(1.0), 6.0 * self._pixel
        middle = self._spot(np.zeros(2))
        shapes.dashed_circle(floor, palette.FAINT, middle, ring * self._scale, stroke)
        for centre, colour, _ in self._named_areas():
            radius = stage.area_radius * self._scale
            pygame.draw.circle(floor, mixed(colour, palette.FLOOR, 0.28), centre, radius)
            pygame.draw.circle(floor, colour, centre, radius, self._width(1.5))
        for each in stage.obstacles:
            points = self._spot(each.points).tolist()
            shapes.draw_walls(floor, points, each.radius * self._scale, each.is_closed)
        return floor

    def _draw_field(self, floor: pygame.Surface, half: float) -> None:
        """Draw the square of goals, and home as a small house."""
        corners = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
        pygame.draw.polygon(floor, palette.RULE, self._spot(corners).tolist(), self._width(1.0))
        x, y = self._spot(np.zeros(2))
        size = 5.0 * self._pixel
        pygame.draw.polygon(floor, palette.INK, [(x - size, y), (x, y - size), (x + size, y)])
        pygame.draw.rect(floor, palette.INK, (x - 0.7 * size, y, 1.4 * size, 0.9 * size))

    def _named_areas(self) -> Iterator[tuple[Float64[Array, " 2"], Colour, str]]:
        """Return the current centre on the canvas [px], the colour and the name of each area."""
        colours = [palette.AREA[kind] for kind in self._stage.kinds]
        return zip(self._spot(self._areas), colours, self._stage.names, strict=True)

    def _draw_rims(self) -> None:
        """Draw the rims of the areas on top of enlarged robots."""
        radius, width = self._stage.area_radius * self._scale, self._width(1.5)
        for centre, colour, _ in self._named_areas():
            pygame.draw.circle(self._canvas, palette.WHITE, centre, radius + width / 2, 2 * width)
            pygame.draw.circle(self._canvas, colour, centre, radius, width)

    def _write_names(self, scene: Scene) -> None:
        """Write the names of areas and home at places without robots, on the colour of the floor.

        A name keeps its place as long as that is free, and is left out if no place is free.
        """
        robots = self._spot(scene.pose[:, :2])
        clear = self.layout.robot_radius * self._fine + 5.0 * self._pixel
        occupied: list[pygame.Rect] = []
        for index, (centre, radius, ground, name) in enumerate(self._names()):
            word = self._large.render(name, True, palette.INK)
            is_inside = word.get_width() < 1.6 * radius
            x, y = centre.tolist()
            places = places_about((x, y), word.get_size(), radius + 3.0 * self._pixel, is_inside)
            order = [self._places.get(index, 0), *range(len(places))]
            free = (k for k in order if is_free(places[k], self._inside, robots, clear, occupied))
            if (chosen := next(free, None)) is None:
                continue
            self._places[index] = chosen
            occupied.append(places[chosen])
            inside = is_inside and chosen == 0
            self._canvas.fill(ground if inside else palette.FLOOR, places[chosen])
            self._canvas.blit(word, places[chosen])

    def _names(self) -> Iterator[tuple[Float64[Array, " 2"], float, Colour, str]]:
        """Yield centre and radius on the canvas [px], fill colour and name of each named place."""
        radius = self._stage.area_radius * self._scale
        for centre, colour, name in self._named_areas():
            yield centre, radius, mixed(colour, palette.FLOOR, 0.28), name
        if self._stage.goals is not None:
            yield self._spot(np.zeros(2)), 6.0 * self._pixel, palette.FLOOR, "home"

    def _draw_trails(self, scene: Scene) -> None:
        places, activities = self._trails.trails()
        spots = self._spot(np.concatenate([places, scene.pose[None, :, :2]]))
        points, width = len(activities), self._width(1.3)
        for k in range(points):
            share = 0.12 + 0.55 * (k + 1) / points
            inks = [mixed(trail_colour(code), palette.FLOOR, share) for code in palette.ROBOT]
            for code, a, b in zip(
                activities[k].tolist(), spots[k].tolist(), spots[k + 1].tolist(), strict=True
            ):
                pygame.draw.line(self._canvas, inks[code], a, b, width)

    def _draw_beliefs(self, scene: Scene, robot: int) -> None:
        stage, believed = self._stage, self._spot(scene.believed[robot])
        for area, colour in enumerate(palette.AREA):
            if not scene.known[robot, area]:
                continue
            nearest = stage.nearest_area(area, scene.believed[robot, area], scene.time)
            true, ring = self._spot(nearest), P_RING * float(scene.p[robot, area])
            radii = stage.area_radius * self._scale, (stage.area_radius + ring) * self._scale
            pygame.draw.line(self._canvas, palette.INK, true, believed[area], self._width(1.5))
            shapes.draw_belief(self._canvas, believed[area], radii, colour, self._pixel)

    def _draw_robots(self, scene: Scene, selected: int | None) -> None:
        size = self.layout.robot_radius * self._fine, 1.2 * self._pixel
        spots, headings = self._spot(scene.pose[:, :2]).tolist(), scene.pose[:, 2].tolist()
        for spot, heading, activity in zip(spots, headings, scene.activity.tolist(), strict=True):
            shapes.draw_robot(self._canvas, spot, heading, activity, size)
        if scene.faulty is not None:
            for robot in np.flatnonzero(scene.faulty):
                shapes.draw_fault_mark(self._canvas, spots[robot], size[0], self._width(1.5))
        if selected is not None:
            halo = size[0] + 3.5 * self._pixel
            width = self._width(2.0)
            pygame.draw.circle(self._canvas, palette.SELECTED, spots[selected], halo, width)


def places_about(
    centre: tuple[float, float], size: tuple[int, int], radius: float, is_inside: bool
) -> list[pygame.Rect]:
    """Return places for a name of this size in or around a circle [px], best first."""
    x, y = centre
    across, along = radius + 0.6 * size[1], radius + 0.6 * size[0]
    away = [(0.0, 0.0)] if is_inside else []
    away += [(0.0, -across), (0.0, across), (along, 0.0), (-along, 0.0)]
    away += [(side * along, end * across) for side in (1.0, -1.0) for end in (-1.0, 1.0)]
    rects = [pygame.Rect((0, 0), size) for _ in away]
    for rect, (right, down) in zip(rects, away, strict=True):
        rect.center = round(x + right), round(y + down)
    return rects


def is_free(
    place: pygame.Rect,
    arena: pygame.Rect,
    robots: Float64[Array, "robots 2"],
    radius: float,
    occupied: Sequence[pygame.Rect],
) -> bool:
    """Return whether a place is inside the arena and clear of all robots and other names [px]."""
    if not arena.contains(place) or place.collidelist(list(occupied)) >= 0:
        return False
    nearest = np.clip(robots, place.topleft, place.bottomright)
    return bool((np.hypot(*(robots - nearest).T) > radius).all())
