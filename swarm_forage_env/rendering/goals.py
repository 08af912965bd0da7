"""Robots that visit goals: goals, claims, what filters believe, and lidar, on a canvas."""

from collections.abc import Callable, Sequence

import numpy as np
import pygame

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.rendering import palette
from swarm_forage_env.rendering.shapes import Point, dashed_circle, draw_cross
from swarm_forage_env.rendering.trails import Claim
from swarm_forage_env.scene import WITHIN, Localised, Scene, Stage

Spot = Callable[[Float64[Array, "*any 2"]], Float64[Array, "*any 2"]]
"""World frame [m] to pixels of a surface."""


class GoalPainter:
    """Draws on one canvas, `scale` pixels a metre; a line of normal width has `pixel` pixels."""

    def __init__(self, stage: Stage, spot: Spot, scale: float, pixel: float) -> None:
        assert stage.goals is not None, "robots that forage have no goals to draw"
        self._field, self._spot, self._scale, self._pixel = stage.goals, spot, scale, pixel

    def _width(self, width: float) -> int:
        return max(1, round(width * self._pixel))

    def draw_field(self, floor: pygame.Surface) -> None:
        """Draw the square in which goals lie, and home, a little house, with its reach."""
        half = 0.5 * self._field.side
        corners = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
        pygame.draw.polygon(floor, palette.RULE, self._spot(corners).tolist(), self._width(1.0))
        x, y = home = self._spot(np.zeros(2))
        stroke = self._width(1.0), 6.0 * self._pixel
        dashed_circle(floor, palette.FAINT, home, self._field.reach * self._scale, stroke)
        size = 5.0 * self._pixel
        pygame.draw.polygon(floor, palette.INK, [(x - size, y), (x, y - size), (x + size, y)])
        pygame.draw.rect(floor, palette.INK, (x - 0.7 * size, y, 1.4 * size, 0.9 * size))

    def draw_lidar(self, canvas: pygame.Surface, scene: Scene, selected: int | None) -> None:
        """Draw how far each robot sees, and lines between those that see each other."""
        spots, radius = self._spot(scene.pose[:, :2]), self._field.reach * self._scale
        width = self._width(0.8)
        pale = palette.mixed(palette.LIDAR, palette.FLOOR, 0.45)
        for spot in spots.tolist():
            pygame.draw.circle(canvas, pale, spot, radius, width)
        if selected is not None:
            pygame.draw.circle(canvas, palette.LIDAR, spots[selected], radius, 2 * width)
        for sender, receiver in scene.messages.tolist():
            if sender < receiver:
                pygame.draw.line(canvas, palette.MESSAGE, spots[sender], spots[receiver], width)

    def draw_goals(
        self, canvas: pygame.Surface, scene: Scene, own: Localised, selected: int | None
    ) -> None:
        """Draw each robot's goal, as large as it is reached, and a line that leads there."""
        goals, spots = self._spot(own.goal), self._spot(scene.pose[:, :2])
        radius = self._field.tolerance * self._scale
        for robot, (goal, spot) in enumerate(zip(goals.tolist(), spots.tolist(), strict=True)):
            is_selected = robot == selected
            ink = palette.GOAL if is_selected else palette.mixed(palette.GOAL, palette.FLOOR, 0.35)
            width = self._width(1.6 if is_selected else 0.8)
            pygame.draw.line(canvas, ink, spot, goal, width)
            draw_goal(canvas, goal, radius, self._pixel)

    def draw_claims(self, canvas: pygame.Surface, claims: Sequence[Claim]) -> None:
        """Draw recent claims: right ones as a disc, others as a cross with a line to the goal."""
        size = 4.5 * self._pixel
        for claim in claims:
            place = self._spot(claim.place)
            if claim.is_right:
                draw_right(canvas, place, size)
            else:
                goal = self._spot(claim.goal)
                pygame.draw.line(canvas, palette.WRONG, place, goal, self._width(0.8))
                draw_wrong(canvas, place, size)

    def draw_estimates(
        self, canvas: pygame.Surface, scene: Scene, own: Localised, selected: int | None
    ) -> None:
        """Draw where robots believe they are: 95 % ellipses, with lines to where they are."""
        spots, true = self._spot(own.believed), self._spot(scene.pose[:, :2])
        axes = WITHIN * self._scale * own.ellipse[:, :2]
        for robot, (long, short) in enumerate(axes.tolist()):
            if long > 0.0:
                width = self._width(2.4 if robot == selected else 1.2)
                pygame.draw.line(canvas, palette.ESTIMATE, true[robot], spots[robot], width)
                direction = float(own.ellipse[robot, 2])
                draw_ellipse(canvas, spots[robot], (long, short), direction, width)


def draw_goal(surface: pygame.Surface, at: Point, radius: float, pixel: float) -> None:
    """Draw a ring in which the goal is reached, with a point in its middle [px]."""
    pygame.draw.circle(surface, palette.GOAL, at, radius, max(1, round(1.5 * pixel)))
    pygame.draw.circle(surface, palette.GOAL, at, 1.6 * pixel)


def draw_right(surface: pygame.Surface, at: Point, size: float) -> None:
    """Draw a right claim: a disc with a tick [px]."""
    pygame.draw.circle(surface, palette.RIGHT, at, size)
    tick = [(-0.5, 0.05), (-0.1, 0.45), (0.55, -0.4)]
    points = [(at[0] + size * a, at[1] + size * b) for a, b in tick]
    pygame.draw.lines(surface, palette.WHITE, False, points, max(1, round(0.28 * size)))


def draw_wrong(surface: pygame.Surface, at: Point, size: float) -> None:
    """Draw a wrong claim: a cross [px]."""
    draw_cross(surface, palette.WRONG, at, 0.8 * size, max(2, round(0.45 * size)))


def draw_ellipse(
    surface: pygame.Surface, centre: Point, axes: tuple[float, float], direction: float, width: int
) -> None:
    """Draw an ellipse of these half axes [px], its long one in a direction of the world [rad]."""
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    along, across = axes[0] * np.cos(angle), axes[1] * np.sin(angle)
    c, s = np.cos(direction), np.sin(direction)
    points = centre + np.stack([c * along - s * across, -s * along - c * across], axis=1)
    pygame.draw.lines(surface, palette.ESTIMATE, True, points.tolist(), width)
    pygame.draw.circle(surface, palette.ESTIMATE, centre, 1.2 * width)
