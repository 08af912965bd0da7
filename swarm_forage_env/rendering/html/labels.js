/* Names in the arena: never over a robot or another name, nor beyond the walls. */
const labels = {
  /* Which place each name took last: it stays there for as long as it can. */
  taken: new Map(),
  /* The names as they stand, of each swarm: left, top, width and height [px]. */
  boxes: swarms.map(() => []),

  draw(robots) {
    const { context } = arena;
    context.font = `600 12px ${FONT}`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineJoin = "round";
    const boxes = this.boxes[view.swarm] = [];
    this.wanted(robots).forEach((each) => {
      const places = this.places(each, context.measureText(each.text).width + 6);
      const key = `${view.swarm} ${each.key}`, before = this.taken.get(key) ?? 0;
      const order = [before, ...places.keys()].filter((k) => k < places.length);
      const chosen = order.find((k) => this.isFree(places[k], robots, each.own, boxes));
      if (chosen === undefined) return;
      this.taken.set(key, chosen);
      boxes.push({ ...places[chosen], text: each.text });
      this.write(each.text, places[chosen]);
    });
  },

  /* What has a name: the middle [px] and size of the circle it belongs to; the chosen robot
     first. */
  wanted(robots) {
    const found = [], { scale } = arena;
    const add = (key, text, x, y, radius, own) =>
      text && found.push({ key, text, at: arena.place(x, y), radius, own });
    if (view.focus !== null) {
      const { x, y } = robots[view.focus];
      add("robot", `robot ${view.focus}`, x, y, arena.robotSize + 7, view.focus);
    }
    if (about.goals) {
      add("home", "home", 0, 0, 7);
      return found;
    }
    areasNow().forEach(([x, y], which) =>
      add(`area ${which}`, about.names[which], x, y, about.areaRadius * scale + 2));
    add("start", "start", 0, 0, about.startRadius * scale + 2);
    return found;
  },

  /* Boxes below, above, right, left and at the corners of a circle. */
  places({ at: [x, y], radius }, width) {
    const height = 16, down = radius + height / 2, along = radius + width / 2;
    const away = [[0, down], [0, -down], [along, 0], [-along, 0],
      [along, down], [along, -down], [-along, down], [-along, -down]];
    return away.map(([right, below]) =>
      ({ left: x + right - width / 2, top: y + below - height / 2, width, height }));
  },

  isFree(box, robots, own, boxes) {
    const [left, top] = arena.place(-about.length / 2, about.width / 2);
    const [right, bottom] = arena.place(about.length / 2, -about.width / 2);
    const ends = [box.left + box.width, box.top + box.height];
    if (box.left < left || box.top < top || ends[0] > right || ends[1] > bottom) return false;
    const apart = ({ left: x, top: y, width, height }) =>
      x >= ends[0] || x + width <= box.left || y >= ends[1] || y + height <= box.top;
    if (!boxes.every(apart)) return false;
    return robots.every(({ robot, x, y }) => {
      const [across, down] = arena.place(x, y), halo = robot === view.focus ? 6 : 1;
      const nearest = [
        Math.min(Math.max(across, box.left), ends[0]), Math.min(Math.max(down, box.top), ends[1])];
      return robot === own
        || Math.hypot(across - nearest[0], down - nearest[1]) > arena.robotSize + halo;
    });
  },

  /* Words on the floor's own colour, so that nothing runs through them. */
  write(text, { left, top, width, height }) {
    const { context } = arena, x = left + width / 2, y = top + height / 2;
    context.fillStyle = about.colours.floor;
    context.fillRect(left + 1, top + 1, width - 2, height - 2);
    context.fillStyle = about.colours.ink;
    context.fillText(text, x, y);
  },
};
