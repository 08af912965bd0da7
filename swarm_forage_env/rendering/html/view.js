/* What is shown now, and the episodes at that time; what follows speaks of one swarm at once. */
const view = {
  episodes: [],
  swarm: 0,
  time: 0,
  speed: 10,
  playing: false,
  hovered: null,
  chosen: null,
  driving: null, // the robot that a visitor drives: its swarm, and the robots as they are now
  show: { trails: true, messages: true, beliefs: false },

  get episode() { return this.episodes[this.swarm] ?? null; },
  get start() { return Math.max(this.episode.times[0], about.start); },
  get end() { return this.episode.times[about.frames - 1]; },
  get focus() { return this.hovered ?? this.chosen; },
  get last() { return frameAt(this.time); },
};

/* Do something with each swarm in turn as the one that is spoken of: what came of it. */
function eachSwarm(act) {
  const results = swarms.map((swarm, which) => {
    view.swarm = which;
    return act(swarm, which);
  });
  view.swarm = 0;
  return results;
}

/* How bright a colour, #rrggbb, is to the eye: relative luminance, as WCAG 2 defines it. */
function luminance(colour) {
  const parts = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) / 255)
    .map((part) => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4);
  return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2];
}

/* Whether a colour hardly differs from that of the page, so that it needs an edge to be seen. */
function isFaint(colour, page) {
  const [dark, light] = [colour, page].map(luminance).sort((a, b) => a - b);
  return (light + 0.05) / (dark + 0.05) < 2.2;
}

/* Gap between the dashes of the second swarm [px]: none where the swarms differ in colour. */
const gapOfSecond = () => swarms.length > 1 && swarms[0].colour === swarms[1].colour ? 3 : 0;

/* Give the page the colours of its controllers, which are those of figures. */
function colourSwarms() {
  const { style } = document.documentElement;
  const page = getComputedStyle(document.documentElement).getPropertyValue("--page").trim();
  swarms.forEach(({ colour }, which) => {
    style.setProperty(`--swarm-${which}`, colour);
    style.setProperty(`--edge-${which}`, isFaint(colour, page) ? "var(--faint)" : colour);
    style.setProperty(`--gap-${which}`, which * gapOfSecond());
  });
}

const AREAS = ["nest", "prey"];

/* Centres of all areas at the present time. */
function areasNow() {
  const found = [...about.areas];
  about.moves.forEach(([which, when, x, y]) => {
    if (view.time >= when - 1e-4) found[which] = [x, y];
  });
  return found;
}

/* The centre of the area of a kind that is nearest to a place. */
function nearestArea(kind, { x, y }) {
  const away = ([left, top]) => Math.hypot(left - x, top - y);
  return areasNow().filter((_, which) => about.kinds[which] === kind)
    .reduce((best, each) => away(each) < away(best) ? each : best);
}

/* The last frame that is not later than a time. */
function frameAt(time) {
  const times = view.episode.times;
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time + 1e-4) low = middle; else high = middle - 1;
  }
  return low;
}

/* A robot at the present time, between two frames on the straight line from one to the other. */
function robotAt(robot) {
  const { episode, last, driving } = view;
  if (driving?.now && driving.swarm === view.swarm) {
    return asDrawn(robot, driving.now, robot, robot, 0);
  }
  const next = Math.min(last + 1, about.frames - 1);
  const gap = episode.times[next] - episode.times[last];
  const share = gap > 0 ? Math.min(Math.max((view.time - episode.times[last]) / gap, 0), 1) : 0;
  return asDrawn(robot, episode, robot * about.frames + last, robot * about.frames + next, share);
}

/* A robot at a share of the way between two places of columns. */
function asDrawn(robot, columns, a, b, share) {
  const between = (name) => columns[name][a] + share * (columns[name][b] - columns[name][a]);
  const turn = columns.heading[b] - columns.heading[a];
  const own = about.goals ? goalsOf(robot, a, between) : foragingOf(columns, a, b, between);
  return {
    robot,
    x: between("x"),
    y: between("y"),
    heading: columns.heading[a] + share * Math.atan2(Math.sin(turn), Math.cos(turn)),
    doing: columns.doing[a],
    faulty: Boolean(columns.faulty?.[a]),
    ...own,
  };
}

/* What a robot that forages has done and believes. */
function foragingOf(columns, a, b, between) {
  return {
    trips: columns.trips[a],
    beliefs: AREAS.map((area, bit) => {
      if (!(columns.known[a] & (1 << bit))) return null;
      const along = columns.known[b] & (1 << bit) ? between : (name) => columns[name][a];
      const place = { x: along(area + "X"), y: along(area + "Y"), p: columns[area + "P"][a] };
      const [x, y] = nearestArea(bit, place);
      return { ...place, off: Math.hypot(place.x - x, place.y - y) };
    }),
  };
}

/* Messages heard of late, youngest last: sender, receiver, and age as a share. */
function messagesNow() {
  const { episode, last, time } = view;
  const found = [];
  for (let frame = last; frame >= 0; frame--) {
    const age = time - episode.times[frame];
    if (age > about.justNow - 1e-3 && frame < last) break;
    const first = frame > 0 ? episode.heardUpTo[frame - 1] : 0;
    for (let i = first; i < episode.heardUpTo[frame]; i++) {
      const faded = Math.min(age / about.justNow, 0.8);
      found.push({ sender: episode.pairs[2 * i], receiver: episode.pairs[2 * i + 1], faded });
    }
  }
  return found.reverse();
}

function clockText(seconds) {
  const whole = Math.floor(seconds + 1e-3);
  const two = (n) => String(n).padStart(2, "0");
  const hours = Math.floor(whole / 3600), minutes = Math.floor(whole / 60) % 60;
  return hours ? `${hours}:${two(minutes)}:${two(whole % 60)}` : `${minutes}:${two(whole % 60)}`;
}

/* A canvas of the size of its box, in device pixels; the context draws in CSS pixels. */
function sharpContext(canvas) {
  const { width, height } = canvas.getBoundingClientRect();
  const ratio = window.devicePixelRatio || 1;
  const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}
