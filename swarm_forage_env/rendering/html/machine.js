/* A worker: it runs one world in WebAssembly, whole episodes or, with a driven robot, some ticks at a time. */
let machine = null, plan = null, image = null, world = null;

const bytes = () => new Uint8Array(machine.memory.buffer);
const numbers = () => new DataView(machine.memory.buffer);
const aligned = (address) => Math.ceil(address / 64) * 64;

/* The product of two whole numbers of 128 bits, which a C compiler's own library has. */
function __multi3(at, a, aUpper, b, bUpper) {
  const whole = (lower, upper) => BigInt.asUintN(64, lower) + (BigInt.asUintN(64, upper) << 64n);
  const product = whole(a, aUpper) * whole(b, bUpper);
  numbers().setBigUint64(at, BigInt.asUintN(64, product), true);
  numbers().setBigUint64(at + 8, BigInt.asUintN(64, product >> 64n), true);
}

/* Where each array of a world of so many robots lies, by name; behind them what comes back. */
function places(robots) {
  const at = {};
  let end = aligned(machine.__heap_base.value);
  for (const { name, fixed, per_robot, per_pair, same } of plan.arrays) {
    at[name] = same ? at[same] : end;
    end = aligned(end + fixed + robots * per_robot + robots * robots * per_pair);
  }
  return { at, count: end, end: end + 64 };
}

/* A world is set up from its image, in which the chosen numbers are written; its robots are placed
   by its seed when it runs. */
function begin({ robots, seed, patches }) {
  const { at, count, end } = places(robots);
  const missing = end - machine.memory.buffer.byteLength;
  if (missing > 0) machine.memory.grow(Math.ceil(missing / 65536));
  const kept = image.slice();
  for (const [offset, written] of patches) kept.set(written, offset);
  const memory = bytes().fill(0, aligned(machine.__heap_base.value), end);
  let from = 0;
  for (const { name, fixed, is_kept } of plan.arrays) {
    if (!is_kept) continue;
    memory.set(kept.subarray(from, from + fixed), at[name]);
    from += fixed;
  }
  numbers().setBigUint64(at.seeds, BigInt(seed), true);
  world = { at, count, robots, done: 0, found: room(robots), heard: [] };
}

/* Room for all frames of an episode. */
function room(robots) {
  const { columns, every, ticks } = plan, frames = Math.ceil(ticks / every) + 1;
  const found = {
    times: new Float32Array(frames),
    share: new Float32Array(frames),
    total: new Float32Array(frames),
    heardUpTo: new Uint32Array(frames),
  };
  for (const name of columns) found[name] = new Float32Array(robots * frames);
  return found;
}

function runTicks(ticks) {
  const { at, count, robots } = world;
  const pointers = plan.arrays.map(({ name }) => at[name]);
  const given = [robots, ...plan.widths, ticks].map(BigInt);
  const status = machine.swarm_run(count, count + 16, ...pointers, ...given);
  const error = numbers().getBigInt64(at.errors + 8, true);
  if (status || error) throw new Error(`the world stopped after ${(world.done * plan.tick).toFixed(1)} s`);
  world.done += ticks;
  const messages = Number(numbers().getBigInt64(count, true));
  const pairs = new Int32Array(machine.memory.buffer, at.pairs, 2 * messages);
  for (let k = 0; k < messages; k++) world.heard.push(pairs[2 * k] * 65536 + pairs[2 * k + 1]);
}

/* The robots now: a number of each for each column. */
const drawn = () => new Float32Array(machine.memory.buffer, world.at.columns, plan.columns.length * world.robots);

/* Keep the robots as a frame. */
function keepFrame(frame) {
  const { robots, found } = world, columns = drawn(), frames = found.times.length;
  found.times[frame] = world.done * plan.tick;
  const sum = { trips: 0, knowsWay: 0 };
  plan.columns.forEach((name, k) => {
    for (let i = 0; i < robots; i++) {
      found[name][i * frames + frame] = columns[k * robots + i];
      if (name in sum) sum[name] += columns[k * robots + i];
    }
  });
  found.total[frame] = sum.trips;
  found.share[frame] = sum.knowsWay / robots;
  const before = world.pairs ?? [];
  new Set(world.heard).forEach((pair) => before.push(Math.floor(pair / 65536), pair % 65536));
  world.pairs = before;
  world.heard = [];
  found.heardUpTo[frame] = before.length / 2;
}

/* Run to a tick, and keep the frames on the way. */
function runTo(end) {
  if (world.done === 0) {
    runTicks(0);
    keepFrame(0);
  }
  while (world.done < end) {
    const next = Math.min(Math.floor(world.done / plan.every + 1) * plan.every, plan.ticks);
    runTicks(Math.min(next, end) - world.done);
    if (world.done === next) keepFrame(Math.ceil(next / plan.every));
  }
}

function episode(asked) {
  begin(asked);
  runTo(plan.ticks);
  return { ...world.found, pairs: new Uint16Array(world.pairs) };
}

/* A copy of the frames so far, from whose end on everything stands still. */
function soFar() {
  const { found, pairs } = world, frames = found.times.length;
  const last = Math.floor(world.done / plan.every), copy = {};
  for (const [name, values] of Object.entries(found)) {
    copy[name] = values.slice();
    for (let first = 0; first < copy[name].length; first += frames) {
      copy[name].fill(copy[name][first + last], first + last + 1, first + frames);
    }
  }
  for (let frame = last + 1; frame < frames; frame++) {
    copy.times[frame] = Math.min(frame * plan.every, plan.ticks) * plan.tick;
  }
  return { ...copy, pairs: new Uint16Array(pairs) };
}

/* Write what a visitor commands to the record of a robot: its wheels, or nothing any more. */
function command({ robot, wheels }) {
  const leaves = world.at.left_alone;
  if (leaves) numbers().setBigInt64(leaves, BigInt(wheels ? robot : -1), true);
  const { size, offset, action, wheels: within } = plan.driving;
  const at = world.at.robots + robot * size + offset;
  bytes().set(wheels ? action : new Uint8Array(action.length), at);
  if (!wheels) return;
  wheels.forEach((speed, k) => numbers().setFloat32(at + within + 4 * k, speed, true));
}

/* Drive a robot for some ticks; what is drawn then, and what a learner in its place observes. */
function drive({ robot, wheels, ticks }) {
  numbers().setBigInt64(world.at.learners, BigInt(robot), true);
  command({ robot, wheels });
  runTo(Math.min(world.done + ticks, plan.ticks));
  const { at } = world, seen = plan.driving.observed.length;
  const columns = drawn(), now = {};
  plan.columns.forEach((name, k) => {
    now[name] = columns.slice(k * world.robots, (k + 1) * world.robots);
  });
  const frame = Math.floor(world.done / plan.every), isNew = frame !== world.sent;
  world.sent = frame;
  return {
    now,
    time: world.done * plan.tick,
    observed: new Float32Array(machine.memory.buffer, at.seen, seen).slice(),
    episode: isNew ? soFar() : null,
  };
}

const ASKED = {
  episode,
  start(asked) {
    begin(asked);
    runTo(asked.ticks);
    return drive({ ...asked, wheels: null, ticks: 0 });
  },
  drive,
  end({ robot }) {
    command({ robot, wheels: null });
    runTo(plan.ticks);
    return { ...world.found, pairs: new Uint16Array(world.pairs) };
  },
};

let ready = null;

async function prepare({ code }) {
  const made = await WebAssembly.instantiate(code, { env: { __multi3 } });
  machine = made.instance.exports;
}

onmessage = async ({ data }) => {
  if (data.code) {
    ({ plan, image } = data);
    ready = prepare(data);
    return;
  }
  try {
    await ready;
    postMessage({ asked: data.asked, found: ASKED[data.what](data) });
  } catch (error) {
    postMessage({ asked: data.asked, reason: error.message });
  }
};
