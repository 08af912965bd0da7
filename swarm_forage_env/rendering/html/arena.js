/* The arena from above, to scale. */
const TRAIL_POINTS = 60;
const SMALLEST = 4; // a robot is drawn at least this large [px]
const FONT = "system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif";

const arena = {
  canvases: [element("arena")],
  scale: 1,
  middle: [0, 0],

  /* World [m] to CSS pixels of the canvas. */
  place(x, y) { return [this.middle[0] + x * this.scale, this.middle[1] - y * this.scale]; },

  /* CSS pixels of the canvas to the world [m]. */
  point(left, top) {
    return [(left - this.middle[0]) / this.scale, (this.middle[1] - top) / this.scale];
  },

  get robotSize() { return Math.max(about.robotRadius * this.scale, SMALLEST); },

  /* A canvas for each swarm, side by side and named. */
  prepare() {
    const first = this.canvases[0].closest("figure");
    swarms.forEach(({ controller }, which) => {
      const figure = which ? first.parentNode.appendChild(first.cloneNode(true)) : first;
      if (which) {
        figure.querySelectorAll("[id]").forEach((part) => part.removeAttribute("id"));
        this.canvases.push(figure.querySelector("canvas"));
      }
      const canvas = this.canvases[which];
      canvas.setAttribute("aria-label", `${canvas.getAttribute("aria-label")}, ${controller}`);
      const name = figure.querySelector("figcaption");
      name.hidden = swarms.length === 1;
      name.className = `swarm-${which}`;
      name.textContent = controller;
    });
  },

  draw() { eachSwarm((_, which) => this.drawSwarm(this.canvases[which])); },

  drawSwarm(canvas) {
    const { context, width, height } = sharpContext(canvas);
    const margin = 3;
    this.scale = Math.max(
      Math.min((width - 2 * margin) / about.length, (height - 2 * margin) / about.width), 1);
    this.middle = [width / 2, height / 2];
    this.context = context;
    const robots = Array.from({ length: about.robots }, (_, robot) => robotAt(robot));
    this.floor();
    context.save();
    this.clip();
    if (about.goals) goals.field(); else this.areas();
    this.obstacles();
    if (view.show.trails) robots.forEach((robot) => this.trail(robot));
    if (about.goals) goals.draw(robots); else this.foraging(robots);
    context.restore();
    robots.forEach((robot) => this.robot(robot));
    if (view.focus !== null) this.halo(robots[view.focus]);
    if (about.goals) goals.home();
    labels.draw(robots);
  },

  /* Nothing but robots, their halo and walls is drawn beyond the arena. */
  clip() {
    const { context } = this, [left, top] = this.place(-about.length / 2, about.width / 2);
    context.beginPath();
    context.rect(left - 1, top - 1, about.length * this.scale + 2, about.width * this.scale + 2);
    context.clip();
  },

  /* What robots that forage believe and hear. */
  foraging(robots) {
    if (view.show.beliefs) robots.forEach((robot) => this.crosses(robot));
    if (view.focus !== null) this.beliefs(robots[view.focus]);
    if (view.show.messages) messagesNow().forEach((message) => this.message(message, robots));
  },

  floor() {
    const { context } = this, [left, top] = this.place(-about.length / 2, about.width / 2);
    context.beginPath();
    if (about.corners.length) this.chain(about.corners, true);
    else context.rect(left, top, about.length * this.scale, about.width * this.scale);
    this.fill(about.colours.floor);
    this.stroke(about.colours.wall, 2);
  },

  fill(colour) {
    this.context.fillStyle = colour;
    this.context.fill();
  },

  stroke(colour, width, dashes = []) {
    const { context } = this;
    context.setLineDash(dashes);
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.stroke();
    context.setLineDash([]);
  },

  /* A line between two places. */
  line(from, to, colour, width) {
    this.context.beginPath();
    this.context.moveTo(...this.place(from.x, from.y));
    this.context.lineTo(...this.place(to.x, to.y));
    this.stroke(colour, width);
  },

  chain(points, closed) {
    const { context } = this;
    points.forEach((point) => context.lineTo(...this.place(...point)));
    if (closed) context.closePath();
  },

  /* Discs, walls with round ends, and polygons of them, which are filled. */
  obstacles() {
    const { context } = this;
    context.fillStyle = context.strokeStyle = about.colours.wall;
    about.obstacles.forEach(({ points, radius, closed }) => {
      const size = Math.max(radius * this.scale, 1);
      if (points.length === 1) {
        this.circle(...points[0], size);
        context.fill();
        return;
      }
      context.beginPath();
      this.chain(points, closed);
      if (closed) context.fill();
      context.lineWidth = 2 * size;
      context.lineCap = context.lineJoin = "round";
      context.stroke();
    });
    context.lineCap = "butt";
    context.lineJoin = "miter";
  },

  circle(x, y, radius) {
    this.context.beginPath();
    this.context.arc(...this.place(x, y), radius, 0, 2 * Math.PI);
  },

  areas() {
    this.circle(0, 0, about.startRadius * this.scale);
    this.stroke(about.colours.faint, 1, [2, 4]);
    areasNow().forEach(([x, y], which) => {
      const colour = about.colours.areas[about.kinds[which]];
      this.circle(x, y, about.areaRadius * this.scale);
      this.fill(colour + "38");
      this.stroke(colour, 2);
    });
  },

  trail({ robot, x, y, doing }) {
    const { context } = this, { episode, last, time } = view;
    const first = frameAt(Math.max(time - about.trail, episode.times[0]));
    const stride = Math.max(1, Math.round((last - first) / TRAIL_POINTS));
    context.strokeStyle = about.colours.trails[doing];
    context.lineWidth = 1.8;
    context.lineCap = "butt";
    let from = this.place(x, y);
    for (let frame = last - (last % stride); frame >= first; frame -= stride) {
      const at = robot * about.frames + frame;
      const to = this.place(episode.x[at], episode.y[at]);
      context.globalAlpha = 0.65 * Math.max(0, 1 - (time - episode.times[frame]) / about.trail);
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
      from = to;
    }
    context.globalAlpha = 1;
  },

  crosses({ beliefs }) {
    beliefs.forEach((belief, which) => {
      if (belief) this.cross(belief, about.colours.areas[which], 4);
    });
  },

  cross(place, colour, size) {
    const { context } = this, [left, top] = this.place(place.x, place.y);
    context.beginPath();
    context.moveTo(left - size, top);
    context.lineTo(left + size, top);
    context.moveTo(left, top - size);
    context.lineTo(left, top + size);
    this.stroke(colour, 1.6);
  },

  /* Where one robot believes the areas to be, p as a ring, and a line to where they are. */
  beliefs({ beliefs }) {
    beliefs.forEach((belief, which) => {
      if (!belief) return;
      const colour = about.colours.areas[which];
      this.circle(belief.x, belief.y, (about.areaRadius + about.ring * belief.p) * this.scale);
      this.fill(colour + "1c");
      this.stroke(colour + "b0", 1.2);
      this.circle(belief.x, belief.y, about.areaRadius * this.scale);
      this.stroke(colour, 2, [5, 4]);
      const [x, y] = nearestArea(which, belief);
      this.line(belief, { x, y }, colour, 1.2);
      this.cross(belief, colour, 6);
    });
  },

  message({ sender, receiver, faded }, robots) {
    const { context } = this, a = robots[sender], b = robots[receiver];
    const [left, top] = this.place(a.x, a.y), [right, bottom] = this.place(b.x, b.y);
    const bend = 0.22; // to the left of its way, so that there and back are two arcs
    const middle = [(left + right) / 2, (top + bottom) / 2];
    context.beginPath();
    context.moveTo(left, top);
    context.quadraticCurveTo(
      middle[0] + bend * (bottom - top), middle[1] - bend * (right - left), right, bottom);
    context.globalAlpha = 0.9 * (1 - faded);
    const isOfFocus = sender === view.focus || receiver === view.focus;
    this.stroke(about.colours.message, isOfFocus ? 3.2 : 1.6);
    context.globalAlpha = 1;
  },

  robot({ x, y, heading, doing, faulty }) {
    const { context, robotSize } = this, [left, top] = this.place(x, y);
    this.circle(x, y, robotSize);
    this.fill(about.colours.doing[doing]);
    this.stroke(about.colours.ink, 1.3);
    context.translate(left, top);
    context.rotate(-heading);
    context.beginPath();
    context.moveTo(0.78 * robotSize, 0);
    context.lineTo(-0.1 * robotSize, 0.5 * robotSize);
    context.lineTo(-0.1 * robotSize, -0.5 * robotSize);
    this.fill(about.colours.noses[doing]);
    context.rotate(heading);
    context.translate(-left, -top);
    if (faulty) this.fault(left, top);
  },

  /* A red cross over a faulty robot. */
  fault(left, top) {
    const { context } = this, arm = 0.85 * this.robotSize;
    for (const [colour, width] of [["#ffffff", 4], [about.colours.faulty, 2]]) {
      context.beginPath();
      context.moveTo(left - arm, top - arm);
      context.lineTo(left + arm, top + arm);
      context.moveTo(left - arm, top + arm);
      context.lineTo(left + arm, top - arm);
      this.stroke(colour, width);
    }
  },

  halo({ x, y }) {
    this.circle(x, y, this.robotSize + 4);
    this.stroke(about.colours.selected, 2.5);
  },

  /* The robot under a point of the canvas, if there is one. */
  robotNear(left, top) {
    let nearest = null, least = Math.max(this.robotSize + 6, 14);
    for (let robot = 0; robot < about.robots; robot++) {
      const at = robotAt(robot), [x, y] = this.place(at.x, at.y);
      const apart = Math.hypot(x - left, y - top);
      if (apart < least) [nearest, least] = [robot, apart];
    }
    return nearest;
  },
};
