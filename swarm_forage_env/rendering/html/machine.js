/* A worker: it runs a whole episode in WebAssembly, from the memory of a world that is about to begin. */
let machine = null, plan = null, images = null;

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

/* Where each array of the world lies, and behind them what it is asked for. */
function places() {
  const { sizes, columns, robots, heard } = plan;
  const arrays = [];
  let at = aligned(machine.__heap_base.value);
  for (const size of sizes) {
    arrays.push(at);
    at += size;
  }
  const drawn = at, pairs = aligned(drawn + 4 * columns.length * robots);
  const count = aligned(pairs + 8 * heard);
  return { arrays, drawn, pairs, count, end: count + 64 };
}

/* A world is set up from the bytes of its seed, in which the chosen numbers are written. */
function begin({ arrays, end }, { seed, patches }) {
  const missing = end - machine.memory.buffer.byteLength;
  if (missing > 0) machine.memory.grow(Math.ceil(missing / 65536));
  const size = plan.sizes.reduce((sum, each) => sum + each, 0);
  const memory = bytes();
  memory.set(images.subarray(seed * size, (seed + 1) * size), arrays[0]);
  for (const [offset, written] of patches) memory.set(written, arrays[0] + offset);
}

function episode(asked) {
  const { columns, robots, every, ticks, tick } = plan;
  const at = places();
  begin(at, asked);
  const frames = Math.ceil(ticks / every) + 1;
  const found = {
    times: new Float32Array(frames),
    share: new Float32Array(frames),
    total: new Float32Array(frames),
    heardUpTo: new Uint32Array(frames),
  };
  for (const name of columns) found[name] = new Float32Array(robots * frames);
  const heard = [];
  for (let frame = 0, done = 0; frame < frames; frame++) {
    const more = frame ? Math.min(every, ticks - done) : 0;
    const status = machine.swarm_run(
      at.count, at.count + 16, ...at.arrays, at.drawn, at.pairs, BigInt(more));
    if (status) throw new Error(`the world stopped after ${(done * tick).toFixed(1)} s`);
    done += more;
    found.times[frame] = done * tick;
    const drawn = new Float32Array(machine.memory.buffer, at.drawn, columns.length * robots);
    columns.forEach((name, k) => {
      for (let i = 0; i < robots; i++) found[name][i * frames + frame] = drawn[k * robots + i];
    });
    const sum = (name) =>
      Array.from({ length: robots }, (_, i) => found[name][i * frames + frame]).reduce((a, b) => a + b);
    found.total[frame] = sum("trips");
    found.share[frame] = sum("knowsWay") / robots;
    const messages = Number(numbers().getBigInt64(at.count, true));
    const pairs = new Int32Array(machine.memory.buffer, at.pairs, 2 * messages);
    const once = new Set();
    for (let k = 0; k < messages; k++) once.add(pairs[2 * k] * 65536 + pairs[2 * k + 1]);
    once.forEach((pair) => heard.push(Math.floor(pair / 65536), pair % 65536));
    found.heardUpTo[frame] = heard.length / 2;
  }
  found.pairs = new Uint16Array(heard);
  return found;
}

let ready = null;

async function prepare({ code }) {
  const made = await WebAssembly.instantiate(code, { env: { __multi3 } });
  machine = made.instance.exports;
}

onmessage = async ({ data }) => {
  if (data.code) {
    ({ plan, images } = data);
    ready = prepare(data);
    return;
  }
  try {
    await ready;
    const found = episode(data);
    postMessage({ asked: data.asked, found }, Object.values(found).map((each) => each.buffer));
  } catch (error) {
    postMessage({ asked: data.asked, reason: error.message });
  }
};
