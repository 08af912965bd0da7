/* Round trips, and below them the share of robots on the path, or within their ellipse, over time; what is still to come is faint. */
const TIME_STEPS = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600]; // [s]

const curves = {
  canvas: element("curves"),
  left: 40,
  right: 12,

  draw() {
    const { context, width, height } = sharpContext(this.canvas);
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    this.inks = { rule: colour("--rule"), faint: colour("--faint"), page: colour("--page") };
    Object.assign(this, { context, width, height });
    const bottom = height - 18, split = 20 + 0.6 * (bottom - 38);
    const most = Math.max(...view.episodes.map(({ total }) => total.reduce((a, b) => Math.max(a, b))), 1);
    this.timeAxis(bottom);
    const [score, part] = about.headings.map((name) => name.toLowerCase());
    const panels = [
      ["total", most, [18, split], score, String(most)],
      ["share", 1, [split + 18, bottom], `robots ${part}`, "100%"],
    ];
    panels.forEach((each) => this.panel(...each));
    const now = this.x(view.time);
    context.strokeStyle = colour("--ink");
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(now, 4);
    context.lineTo(now, bottom);
    context.stroke();
    panels.forEach(([, , [top], name]) => this.name(name, top));
    if (swarms.length > 1) this.key(panels[0][2][0] - 9);
  },

  /* Which curve is of which controller, from the right end; a long name is cut, beside that of the panel. */
  key(y) {
    const room = (this.width - this.left - this.right - 100) / swarms.length - 38;
    let x = this.width - this.right;
    for (const [which, { controller, colour }] of [...swarms.entries()].reverse()) {
      let name = controller;
      for (let n = name.length; this.context.measureText(name).width > room && n > 0; n--) {
        name = `${controller.slice(0, n - 1)}…`;
      }
      this.text(name, x, y, "right");
      x -= this.context.measureText(name).width + 6;
      this.context.beginPath();
      this.context.moveTo(x - 18, y);
      this.context.lineTo(x, y);
      this.stroke(colour, 2, which * gapOfSecond());
      x -= 32;
    }
  },

  /* The name of a panel, which no line runs through. */
  name(words, top) {
    const { context } = this;
    context.font = `11px ${FONT}`;
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.lineWidth = 5;
    context.lineJoin = "round";
    context.strokeStyle = this.inks.page;
    context.strokeText(words, this.left + 6, top - 9);
    this.text(words, this.left + 6, top - 9, "left");
  },

  x(time) {
    const share = (time - view.start) / (view.end - view.start || 1);
    return this.left + share * (this.width - this.left - this.right);
  },

  timeAt(x) {
    const share = (x - this.left) / (this.width - this.left - this.right);
    return view.start + share * (view.end - view.start);
  },

  text(words, x, y, align) {
    this.context.font = `11px ${FONT}`;
    this.context.textAlign = align;
    this.context.textBaseline = "middle";
    this.context.fillStyle = this.inks.faint;
    this.context.fillText(words, x, y);
  },

  timeAxis(bottom) {
    const room = (this.width - this.left - this.right) / 70;
    const step = TIME_STEPS.find((s) => (view.end - view.start) / s <= room) ?? 7200;
    for (let time = Math.ceil(view.start / step) * step; time <= view.end; time += step) {
      const x = this.x(time);
      this.line(x, bottom, x, bottom + 4);
      const fits = x < this.width - 24;
      this.text(clockText(time), fits ? x : this.width, bottom + 11, fits ? "center" : "right");
    }
  },

  line(...[x1, y1, x2, y2]) {
    this.context.strokeStyle = this.inks.rule;
    this.context.lineWidth = 1;
    this.context.beginPath();
    this.context.moveTo(x1, y1);
    this.context.lineTo(x2, y2);
    this.context.stroke();
  },

  panel(values, most, [top, bottom], name, highest) {
    const { inks } = this;
    const y = (value) => bottom - (value / most) * (bottom - top);
    this.line(this.left, bottom, this.width - this.right, bottom);
    this.line(this.left, top, this.left, bottom);
    this.text(highest, this.left - 6, top, "right");
    this.text("0", this.left - 6, bottom, "right");
    const draw = (last, strokes) => eachSwarm((swarm, which) => {
      this.steps(view.episode[values], y, last);
      strokes(swarm, which).forEach((each) => this.stroke(...each));
    });
    const isOne = swarms.length === 1;
    this.context.globalAlpha = isOne ? 1 : 0.4;
    draw(about.frames - 1, ({ colour }) => [[isOne ? inks.rule : colour, 1.5]]);
    this.context.globalAlpha = 1;
    draw(view.last, ({ colour }, which) => [
      ...(isFaint(colour, inks.page) ? [[inks.faint, 3.5]] : []),
      [colour, 2, which * gapOfSecond()],
    ]);
  },

  stroke(colour, thick, gap = 0) {
    const { context } = this;
    context.setLineDash(gap ? [6, gap] : []);
    context.strokeStyle = colour;
    context.lineWidth = thick;
    context.lineJoin = "round";
    context.stroke();
    context.setLineDash([]);
  },

  /* A curve that keeps its value from one frame to the next; one point for each change. */
  steps(values, y, last) {
    const { context } = this, { times } = view.episode;
    const first = frameAt(view.start);
    context.beginPath();
    context.moveTo(this.x(view.start), y(values[first]));
    for (let frame = first + 1; frame <= last; frame++) {
      if (values[frame] === values[frame - 1]) continue;
      context.lineTo(this.x(times[frame]), y(values[frame - 1]));
      context.lineTo(this.x(times[frame]), y(values[frame]));
    }
    context.lineTo(this.x(last === about.frames - 1 ? times[last] : view.time), y(values[last]));
  },
};
