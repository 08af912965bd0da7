// Run ticks compiled to WebAssembly: node run.mjs MODULE MEMORY OUT TICKS SIZES...
import { readFileSync, writeFileSync } from 'node:fs';

const [module, memory, out, ticks, ...sizes] = process.argv.slice(2);
let view;

// The product of two 128-bit numbers, which a C compiler's own library has.
function __multi3(at, a, aUpper, b, bUpper) {
  const whole = (lower, upper) => BigInt.asUintN(64, lower) + (BigInt.asUintN(64, upper) << 64n);
  const product = whole(a, aUpper) * whole(b, bUpper);
  view().setBigUint64(at, BigInt.asUintN(64, product), true);
  view().setBigUint64(at + 8, BigInt.asUintN(64, product >> 64n), true);
}

const { instance } = await WebAssembly.instantiate(readFileSync(module), { env: { __multi3 } });
const machine = instance.exports;
view = () => new DataView(machine.memory.buffer);
machine.memory.grow(4);
const start = Math.ceil(machine.__heap_base.value / 64) * 64;
const bytes = () => new Uint8Array(machine.memory.buffer);
const data = readFileSync(memory);
bytes().set(data, start);
const places = [];
let at = start;
for (const size of sizes.map(Number)) {
  places.push(at);
  at += size;
}
machine.swarm_run(at, at + 16, ...places, BigInt(ticks));
writeFileSync(out, bytes().slice(start, start + data.length));
