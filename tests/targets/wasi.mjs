// Run run.wasm in this folder: node wasi.mjs
import { readFileSync } from 'node:fs';
import { WASI } from 'node:wasi';

const wasi = new WASI({ version: 'preview1', preopens: { '.': '.' }, returnOnExit: true });
const { instance } = await WebAssembly.instantiate(readFileSync('run.wasm'), wasi.getImportObject());
process.exitCode = wasi.start(instance);
