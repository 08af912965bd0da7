/* A visitor drives a robot of the first swarm: its world is then run some ticks at a time. */
const TURNING = 0.6; // of full speed that each wheel has more or less in the sharpest turn
const TOWARDS = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1],
  w: [1, 0], s: [-1, 0], a: [0, 1], d: [0, -1] };

const drive = {
  pressed: new Set(),
  target: null, // where a pointer is held [m]
  due: 0, // time that the world has yet to run [s]
  isAsking: false,

  prepare() {
    const button = document.createElement("button");
    button.id = "drive";
    element("robot").closest("h2").append(button);
    button.onclick = () => (view.driving ? this.letGo() : this.takeOver());
    window.addEventListener("blur", () => this.pressed.clear());
    const observed = document.createElement("details");
    observed.id = "observed";
    observed.open = true;
    observed.append(document.createElement("summary"), document.createElement("p"));
    observed.append(document.createElement("table"));
    element("robot-card").after(observed);
    const { observed: numbers } = about.driving;
    observed.firstChild.textContent = `What a learner observes there: ${numbers.length} numbers`;
    observed.querySelector("table").append(...numbers.map(([name, unit]) => {
      const row = document.createElement("tr");
      row.title = unit;
      row.insertCell().textContent = name.replace("situation.", "");
      const bar = document.createElement("meter");
      row.insertCell().append(bar);
      row.insertCell();
      return row;
    }));
  },

  async takeOver() {
    const robot = view.chosen ?? 0, ticks = Math.round(view.time / about.tick);
    view.chosen = robot;
    view.driving = { swarm: 0, robot, now: null, observed: null };
    this.pressed.clear();
    this.target = null;
    this.due = 0;
    if (view.speed > 5) player.setSpeed(2);
    await this.ask("start", { ...live.world(0), robot, ticks });
    player.play(true);
  },

  /* Ask for ticks, and show what came of them; an answer that is too late is dropped. */
  async ask(what, question) {
    const { driving } = view;
    this.isAsking = true;
    const found = await live.ask(0, what, question).catch((error) => refuse(error.message));
    this.isAsking = false;
    if (!found || view.driving !== driving) return;
    Object.assign(driving, { now: found.now, observed: found.observed });
    if (found.episode) view.episodes[0] = found.episode;
    view.time = found.time;
    if (view.time >= view.end - 1e-6) this.letGo();
    player.refresh();
  },

  /* Some time has passed for the driven world. */
  advance(seconds) {
    this.due += seconds;
    const ticks = Math.min(Math.floor(this.due / about.tick), about.every);
    if (ticks < 1 || this.isAsking) return;
    this.due = Math.min(this.due - ticks * about.tick, 1);
    this.ask("drive", { robot: view.driving.robot, wheels: this.wheels, ticks });
  },

  /* The robot goes on as its controller says, to the end of the episode. */
  async letGo() {
    const { driving } = view;
    if (!driving) return;
    view.driving = null;
    this.pressed.clear();
    this.target = null;
    const found = await live.ask(0, "end", { robot: driving.robot });
    if (view.driving) return;
    view.episodes[0] = found;
    player.refresh();
  },

  /* Speeds of the left and right wheel, as shares of full speed. */
  get wheels() {
    let forward = 0, turn = 0;
    this.pressed.forEach((key) => {
      forward += TOWARDS[key][0];
      turn += TOWARDS[key][1];
    });
    if (this.target) {
      const { x, y, heading } = robotAt(view.driving.robot);
      const off = Math.atan2(this.target[1] - y, this.target[0] - x) - heading;
      [forward, turn] = [Math.max(Math.cos(off), 0), Math.sin(off) >= 0 ? 1 : -1];
      turn *= Math.min(Math.abs(Math.atan2(Math.sin(off), Math.cos(off))), 1);
    }
    return [forward - TURNING * turn, forward + TURNING * turn]
      .map((speed) => Math.min(Math.max(speed, -1), 1));
  },

  /* Whether a key steers. */
  onKey(event, isDown) {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!view.driving || !(key in TOWARDS)) return false;
    event.preventDefault();
    if (isDown) this.pressed.add(key); else this.pressed.delete(key);
    return true;
  },

  /* The driven robot goes to where a pointer is held. */
  listenTo(canvas, which) {
    const follow = (event) => {
      if (!view.driving || which !== 0 || !event.buttons) return;
      this.target = arena.point(event.offsetX, event.offsetY);
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (view.driving) canvas.setPointerCapture(event.pointerId);
      follow(event);
    });
    canvas.addEventListener("pointermove", follow);
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, () => { this.target = null; });
    }
    canvas.addEventListener("touchmove", (event) => {
      if (view.driving) event.preventDefault();
    }, { passive: false });
  },

  draw() {
    const { driving } = view, observed = element("observed");
    element("drive").textContent = driving ? "Let go" : "Drive it";
    element("drive").setAttribute("aria-pressed", String(Boolean(driving)));
    observed.hidden = !driving?.observed;
    if (observed.hidden) return;
    observed.querySelector("p").textContent =
      "Steer by the arrow keys, or hold a finger or the mouse where it shall go.";
    observed.querySelectorAll("tr").forEach((row, k) => {
      const value = driving.observed[k], low = about.driving.observed[k][2];
      Object.assign(row.querySelector("meter"), { min: low, max: 1, value });
      row.lastChild.textContent = value.toFixed(2);
    });
  },
};
