/* Worlds that are run here: each swarm has a worker, which gives the episode of a seed and of chosen numbers. */
const live = {
  workers: [],
  patches: [],
  waiting: new Map(),
  asked: 0,

  /* Give each worker its machine code and the first bytes of its worlds. */
  async prepare() {
    const script = URL.createObjectURL(new Blob([element("machine").textContent]));
    await Promise.all(swarms.map(async ({ sizes, codeSize, patches }, which) => {
      const packed = await inflated(element(which ? `recording-${which}` : "recording").textContent);
      const worker = new Worker(script);
      worker.onmessage = ({ data }) => this.take(data);
      worker.onerror = ({ message }) => refuse(message);
      const plan = { ...about.live, sizes, robots: about.robots, tick: about.tick, every: about.every };
      const images = new Uint8Array(packed, codeSize);
      worker.postMessage({ code: packed.slice(0, codeSize), images, plan });
      this.workers.push(worker);
      this.patches[which] = patches;
    }));
    this.makeControls();
    window.addEventListener("hashchange", () => this.readAddress() && this.run());
    this.readAddress();
  },

  take({ asked, found, reason }) {
    const { done, fail } = this.waiting.get(asked);
    this.waiting.delete(asked);
    if (reason) fail(new Error(reason)); else done(found);
  },

  ask(which, question) {
    const asked = this.asked++;
    return new Promise((done, fail) => {
      this.waiting.set(asked, { done, fail });
      this.workers[which].postMessage({ asked, ...question });
    });
  },

  /* The episodes of all swarms under what is chosen. */
  episodes() {
    const seed = Number(element("seed").value);
    return Promise.all(swarms.map((_, which) => {
      const patches = about.live.sliders.flatMap(({ name }) =>
        this.patches[which][name]?.[element(name).value] ?? []);
      return this.ask(which, { seed, patches: patches.map(([at, text]) => [at, bytesOf(text)]) });
    }));
  },

  async run() {
    this.tell();
    this.writeAddress();
    const latest = this.runs = (this.runs ?? 0) + 1;
    const found = await this.episodes().catch((error) => refuse(error.message));
    if (!found || latest !== this.runs) return;
    view.episodes = found;
    player.refresh();
  },

  makeControls() {
    const { seeds, sliders } = about.live;
    const section = document.createElement("section");
    section.className = "world";
    section.setAttribute("aria-label", "World");
    const line = (id, words, control, after = "") => {
      const label = document.createElement("label");
      const value = document.createElement("output");
      value.id = `${id}-value`;
      value.htmlFor = id;
      value.textContent = after;
      control.id = id;
      label.append(words, control, value);
      section.append(label);
      control.onchange = () => this.run();
      control.oninput = () => this.tell();
    };
    const seed = document.createElement("select");
    for (let k = 0; k < seeds; k++) seed.add(new Option(String(k), String(k)));
    line("seed", "Seed", seed);
    for (const { name, label, values, usual } of sliders) {
      const slider = document.createElement("input");
      Object.assign(slider, { type: "range", min: 0, max: values.length - 1, step: 1, value: usual });
      slider.setAttribute("value", usual);
      line(name, label, slider);
    }
    element("legend").closest("section").before(section);
    this.tell();
  },

  tell() {
    for (const { name, values, unit } of about.live.sliders) {
      const text = `${values[element(name).valueAsNumber]} ${unit}`.trim();
      element(`${name}-value`).textContent = text;
      element(name).setAttribute("aria-valuetext", text);
    }
  },

  /* What is chosen, as in the address of the page; usual numbers are left out. */
  get choice() {
    const chosen = new URLSearchParams({ seed: element("seed").value });
    for (const { name, values, usual } of about.live.sliders) {
      const at = element(name).valueAsNumber;
      if (at !== usual) chosen.set(name, values[at]);
    }
    return chosen.toString();
  },

  writeAddress() { history.replaceState(null, "", `#${this.choice}`); },

  /* Choose what the address says; whether that differs from what was chosen. */
  readAddress() {
    const before = this.choice, asked = new URLSearchParams(location.hash.slice(1));
    const seed = element("seed");
    seed.value = asked.get("seed") ?? "0";
    if (seed.selectedIndex < 0) seed.value = "0";
    for (const { name, values, usual } of about.live.sliders) {
      const at = asked.has(name) ? values.indexOf(Number(asked.get(name))) : usual;
      element(name).value = at < 0 ? usual : at;
    }
    this.tell();
    return before !== this.choice;
  },
};
