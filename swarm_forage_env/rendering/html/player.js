/* Play, pause, scrub, choose: everything that changes what is shown. */
const SPEEDS = [1, 2, 5, 10, 20, 50, 100, 200];
const ICONS = { play: "M4 2.5v11l9-5.5z", pause: "M3.5 2.5h3.2v11H3.5zM9.3 2.5h3.2v11H9.3z" };

const player = {
  drawing: false,

  /* Draw once before the next repaint, however often it was asked for. */
  refresh() {
    if (this.drawing) return;
    this.drawing = true;
    requestAnimationFrame((now) => {
      this.drawing = false;
      this.advance(now);
      arena.draw();
      curves.draw();
      panel.draw();
      if (view.playing) this.refresh();
    });
  },

  advance(now) {
    if (!view.playing) return;
    const passed = Math.min((now - this.before) / 1000, 0.25);
    this.before = now;
    if (view.driving) {
      drive.advance(Math.max(passed, 0) * view.speed);
      return;
    }
    view.time = Math.min(view.time + Math.max(passed, 0) * view.speed, view.end);
    if (view.time >= view.end) this.play(false);
  },

  play(playing) {
    if (playing && view.time >= view.end) view.time = view.start;
    view.playing = playing;
    this.before = performance.now();
    element("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    element("play-icon").setAttribute("d", playing ? ICONS.pause : ICONS.play);
    this.refresh();
  },

  seek(time) {
    drive.letGo();
    view.time = Math.min(Math.max(time, view.start), view.end);
    this.refresh();
  },

  stepFrames(count) {
    this.play(false);
    const frame = Math.min(Math.max(view.last + count, frameAt(view.start)), about.frames - 1);
    this.seek(view.episode.times[frame]);
  },

  setSpeed(speed) {
    view.speed = speed;
    element("speed").value = String(speed);
  },

  stepSpeed(count) {
    const at = SPEEDS.indexOf(view.speed) + count;
    this.setSpeed(SPEEDS[Math.min(Math.max(at, 0), SPEEDS.length - 1)]);
  },

  choose(robot) {
    if (view.driving && robot !== view.driving.robot) drive.letGo();
    view.chosen = robot;
    this.refresh();
  },

  stepRobot(count) {
    const none = count > 0 ? -1 : 0;
    this.choose(((view.chosen ?? none) + count + about.robots) % about.robots);
  },

  toggle(name) {
    view.show[name] = !view.show[name];
    element(name).setAttribute("aria-pressed", String(view.show[name]));
    this.refresh();
  },
};

const KEYS = {
  " ": () => player.play(!view.playing),
  ArrowLeft: (event) => player.seek(view.time - (event.shiftKey ? 60 : 5)),
  ArrowRight: (event) => player.seek(view.time + (event.shiftKey ? 60 : 5)),
  ArrowUp: () => player.stepSpeed(1),
  ArrowDown: () => player.stepSpeed(-1),
  "+": () => player.stepSpeed(1),
  "=": () => player.stepSpeed(1),
  "-": () => player.stepSpeed(-1),
  Home: () => player.seek(view.start),
  End: () => player.seek(view.end),
  ",": () => player.stepFrames(-1),
  ".": () => player.stepFrames(1),
  "[": () => player.stepRobot(-1),
  "]": () => player.stepRobot(1),
  Escape: () => player.choose(null),
  t: () => player.toggle("trails"),
  m: () => player.toggle("messages"),
  b: () => player.toggle("beliefs"),
};

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const tag = event.target.tagName;
  if (tag === "SELECT" || (tag === "BUTTON" && event.key === " ")) return;
  if (event.target.closest(".world") && /^(Arrow|Home|End)/.test(event.key)) return;
  if (drive.onKey(event, true)) return;
  const act = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act) return;
  event.preventDefault();
  act(event);
}

function listenToControls() {
  element("play").onclick = () => player.play(!view.playing);
  element("back").onclick = () => player.stepFrames(-1);
  element("forth").onclick = () => player.stepFrames(1);
  for (const name of Object.keys(view.show)) element(name).onclick = () => player.toggle(name);
  const slider = element("time");
  Object.assign(slider, { min: view.start, max: view.end, step: about.tick });
  slider.oninput = () => player.seek(slider.valueAsNumber);
  if (!SPEEDS.includes(about.speed)) SPEEDS.push(about.speed);
  SPEEDS.sort((a, b) => a - b).forEach((speed) => element("speed").add(new Option(`${speed}×`, String(speed))));
  element("speed").onchange = (event) => player.setSpeed(Number(event.target.value));
  element("robot").onchange = ({ target }) =>
    player.choose(target.value === "" ? null : Number(target.value));
  document.addEventListener("keydown", onKey);
  document.addEventListener("keyup", (event) => drive.onKey(event, false));
}

function listenToArena(canvas, which) {
  const robotAtPointer = (event) => {
    view.swarm = which;
    const robot = arena.robotNear(event.offsetX, event.offsetY);
    view.swarm = 0;
    return robot;
  };
  const hover = (robot) => {
    if (robot === view.hovered) return;
    view.hovered = robot;
    canvas.style.cursor = robot === null ? "default" : "pointer";
    player.refresh();
  };
  canvas.onpointermove = (event) => {
    if (event.pointerType !== "touch") hover(robotAtPointer(event));
  };
  canvas.onpointerleave = () => hover(null);
  drive.listenTo(canvas, which);
  canvas.onclick = (event) => {
    if (view.driving) return;
    const robot = robotAtPointer(event);
    player.choose(robot === view.chosen ? null : robot);
  };
}

function listenToCanvases() {
  arena.canvases.forEach(listenToArena);
  const scrub = (event) => player.seek(curves.timeAt(event.offsetX));
  curves.canvas.onpointerdown = (event) => {
    curves.canvas.setPointerCapture(event.pointerId);
    scrub(event);
  };
  curves.canvas.onpointermove = (event) => {
    if (event.buttons) scrub(event);
  };
}

async function begin() {
  const isReplay = about.live && typeof WebAssembly === "undefined";
  if (isReplay) live.becomeReplay();
  colourSwarms();
  panel.prepare();
  arena.prepare();
  if (about.live) {
    await live.prepare();
    live.show(await live.episodes());
  } else {
    view.episodes = await recorded(isReplay ? "replay" : "recording");
  }
  view.time = Math.min(Math.max(view.time, view.start), view.end);
  view.speed = about.speed;
  view.chosen = about.select;
  element("arenas").style.setProperty("--aspect", `${about.length} / ${about.width}`);
  element("arenas").classList.toggle("several", swarms.length > 1);
  listenToControls();
  listenToCanvases();
  player.setSpeed(view.speed);
  const redraw = () => player.refresh();
  new ResizeObserver(redraw).observe(element("arenas"));
  window.addEventListener("resize", redraw);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    colourSwarms();
    redraw();
  });
  player.refresh();
}

function refuse(reason) {
  element("notice").hidden = false;
  element("notice").textContent = typeof DecompressionStream === "undefined"
    ? "This browser is too old for the replay: it takes Chromium 80, Firefox 113, Safari 16.4 or"
      + " a later one."
    : about.live ? `The world cannot be run in this browser (${reason}).`
    : `The recording in this file cannot be read (${reason}); make it again with the command above.`;
}

begin().catch(refuse);
