"use strict";

const element = (id) => document.getElementById(id);
const about = JSON.parse(element("about").textContent);

/* The bytes behind a base64 text. */
function bytesOf(text) {
  const raw = atob(text);
  const found = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) found[i] = raw.charCodeAt(i);
  return found;
}

/* The bytes behind a base64 text, inflated by the browser itself. */
async function inflated(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/* A column as numbers, robot after robot, from the differences between its codes. */
function decoded(bytes, { low, step }, robots, frames) {
  const size = robots * frames;
  const values = new Float32Array(size);
  for (let robot = 0, at = 0; robot < robots; robot++) {
    for (let frame = 0, code = 0; frame < frames; frame++, at++) {
      code = (code + bytes[at] + 256 * bytes[size + at]) & 65535;
      values[at] = low + step * code;
    }
  }
  return values;
}

/* The swarms of the page: one, or several in the same world, moved by different controllers. */
const swarms = [about, ...about.beside];

/* The episode of a swarm: times [s], places [m], headings [rad]; columns hold robot * frames + frame. */
async function loaded({ messages, columns }, id) {
  const { frames, robots } = about;
  const buffer = await inflated(element(id).textContent);
  let at = 0;
  const take = (Kind, count) => {
    const part = new Kind(buffer, at, count);
    at += part.byteLength;
    return part;
  };
  const episode = {
    times: take(Float32Array, frames),
    share: take(Float32Array, frames),
    heardUpTo: take(Uint32Array, frames),
    pairs: take(Uint16Array, 2 * messages),
  };
  for (const column of columns) {
    episode[column.name] = decoded(take(Uint8Array, 2 * robots * frames), column, robots, frames);
  }
  episode.total = new Float32Array(frames);
  const scored = about.goals ? episode.right : episode.trips;
  for (let i = 0; i < robots * frames; i++) episode.total[i % frames] += scored[i];
  return episode;
}

/* The episodes of all swarms from the elements of this name. */
const recorded = (name) =>
  Promise.all(swarms.map((swarm, which) => loaded(swarm, `${name}-${which}`)));
