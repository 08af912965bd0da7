/* Robots that visit goals: goals, claims, what filters believe, and lidar. */

/* What a robot that visits goals is about at the present time; a goal does not slide to the next. */
function goalsOf(robot, a, between) {
  const { episode } = view;
  const place = { x: between("believedX"), y: between("believedY") };
  return {
    goal: [episode.goalX[a], episode.goalY[a]],
    right: episode.right[a],
    wrong: episode.wrong[a],
    estimate: {
      ...place,
      long: episode.long[a],
      short: episode.short[a],
      direction: episode.direction[a],
      off: Math.hypot(place.x - between("x"), place.y - between("y")),
    },
  };
}

/* Claims that were judged of late: where the robot was, where the goal was, and whether it was
   right. */
function claimsNow() {
  const { episode, last, time } = view;
  const found = [];
  const first = Math.max(frameAt(Math.max(time - about.trail, episode.times[0])), 1);
  for (let robot = 0; robot < about.robots; robot++) {
    for (let frame = first; frame <= last; frame++) {
      const b = robot * about.frames + frame, a = b - 1;
      const right = episode.right[b] > episode.right[a];
      if (!right && episode.wrong[b] <= episode.wrong[a]) continue;
      found.push({
        right, place: [episode.x[a], episode.y[a]], goal: [episode.goalX[a], episode.goalY[a]],
      });
    }
  }
  return found;
}

const goals = {
  /* The square in which goals lie, and home with its reach. */
  field() {
    const { context, scale } = arena, { side, reach } = about.goals;
    const [left, top] = arena.place(-side / 2, side / 2);
    context.strokeStyle = "#d6d6d2";
    context.lineWidth = 1;
    context.strokeRect(left, top, side * scale, side * scale);
    arena.circle(0, 0, reach * scale);
    arena.stroke(about.colours.faint, 1, [5, 4]);
  },

  home() {
    const { context } = arena, [x, y] = arena.place(0, 0);
    context.beginPath();
    [[-6, 0], [0, -6], [6, 0], [4, 0], [4, 5], [-4, 5], [-4, 0]].forEach(
      ([right, down]) => context.lineTo(x + right, y + down));
    arena.fill(about.colours.ink);
  },

  /* How far each robot sees; lines join those that see each other. */
  lidar(robots) {
    robots.forEach(({ robot, x, y }) => {
      const chosen = robot === view.focus;
      arena.circle(x, y, about.goals.reach * arena.scale);
      arena.stroke(about.colours.lidar + (chosen ? "ff" : "70"), chosen ? 2 : 1);
    });
    messagesNow().forEach(({ sender, receiver }) => {
      const [from, to] = [robots[sender], robots[receiver]];
      if (sender < receiver) arena.line(from, to, about.colours.message, 1.2);
    });
  },

  goal({ robot, x, y, goal }) {
    const colour = about.colours.goal, [gx, gy] = goal, chosen = robot === view.focus;
    arena.line({ x, y }, { x: gx, y: gy }, colour + (chosen ? "ff" : "58"), chosen ? 2 : 1);
    arena.circle(gx, gy, about.goals.tolerance * arena.scale);
    arena.stroke(colour, 1.8);
    arena.circle(gx, gy, 1.8);
    arena.fill(colour);
  },

  claim({ right, place, goal }) {
    const { context } = arena, [x, y] = arena.place(...place);
    if (right) {
      arena.circle(...place, 5);
      arena.fill(about.colours.right);
      context.beginPath();
      [[-2.5, 0.3], [-0.5, 2.3], [2.8, -2]].forEach(
        ([ahead, down]) => context.lineTo(x + ahead, y + down));
      arena.stroke("#ffffff", 1.5);
      return;
    }
    arena.line({ x: place[0], y: place[1] }, { x: goal[0], y: goal[1] }, about.colours.wrong, 1);
    context.beginPath();
    for (const side of [-4, 4]) {
      context.moveTo(x - 4, y - side);
      context.lineTo(x + 4, y + side);
    }
    arena.stroke(about.colours.wrong, 2.4);
  },

  /* Where a robot believes it is: an ellipse of 95 %, and a line to where it is. */
  estimate({ robot, x, y, estimate }) {
    const { context, scale } = arena, chosen = robot === view.focus;
    if (estimate.long === 0) return;
    const [left, top] = arena.place(estimate.x, estimate.y);
    const axis = (deviation) => about.goals.within * deviation * scale;
    const colour = about.colours.estimate, width = chosen ? 2.2 : 1.2;
    arena.line({ x, y }, estimate, colour, width);
    context.beginPath();
    context.ellipse(
      left, top, axis(estimate.long), axis(estimate.short), -estimate.direction, 0, 2 * Math.PI);
    arena.stroke(colour, width);
    arena.circle(estimate.x, estimate.y, 2);
    arena.fill(colour);
  },

  draw(robots) {
    if (view.show.messages) this.lidar(robots);
    robots.forEach((robot) => this.goal(robot));
    claimsNow().forEach((claim) => this.claim(claim));
    if (view.show.beliefs) robots.forEach((robot) => this.estimate(robot));
    else if (view.focus !== null) this.estimate(robots[view.focus]);
  },

  /* What the card says of a robot. */
  rows(robot) {
    const [x, y] = robot.goal, { off, long } = robot.estimate;
    return [
      ["believed", `${off.toFixed(2)} m off`],
      ["ellipse", `${(about.goals.within * long).toFixed(2)} m`],
      ["goal", `${Math.hypot(x - robot.x, y - robot.y).toFixed(2)} m away`],
      ["claimed rightly", String(robot.right)],
      ["claimed wrongly", String(robot.wrong)],
    ];
  },
};
