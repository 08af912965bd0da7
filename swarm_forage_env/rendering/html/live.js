/* Worlds that are run here: each swarm has a worker, which gives the episode of a seed and of
   chosen numbers. */
const live = {
  workers: [],
  patches: [],
  waiting: new Map(),
  asked: 0,

  /* Give each worker its machine code and the memory of a world that begins. */
  async prepare() {
    const script = URL.createObjectURL(new Blob([element("machine").textContent]));
    await Promise.all(swarms.map(async ({ arrays, widths, codeSize, driving, patches }, which) => {
      const packed = await inflated(element(`recording-${which}`).textContent);
      const worker = new Worker(script);
      worker.onmessage = ({ data }) => this.take(data);
      worker.onerror = ({ message }) => refuse(message);
      const plan = { ...about.live, arrays, widths, tick: about.tick, every: about.every,
        driving: { ...driving, action: bytesOf(driving.action) } };
      const image = new Uint8Array(packed, codeSize);
      worker.postMessage({ code: packed.slice(0, codeSize), image, plan });
      this.workers.push(worker);
      this.patches[which] = patches;
    }));
    this.makeControls();
    drive.prepare();
    window.addEventListener("hashchange", () =>
      this.readAddress() ? this.run() : player.seek(view.time));
    this.readAddress();
  },

  take({ asked, found, reason }) {
    const { done, fail } = this.waiting.get(asked);
    this.waiting.delete(asked);
    if (reason) fail(new Error(reason)); else done(found);
  },

  ask(which, what, question) {
    const asked = this.asked++;
    return new Promise((done, fail) => {
      this.waiting.set(asked, { done, fail });
      this.workers[which].postMessage({ asked, what, ...question });
    });
  },

  /* Which value of a slider is chosen. */
  at({ name }) { return element(name).valueAsNumber; },

  /* A world of a swarm under what is chosen. */
  world(which) {
    const patches = about.live.sliders.flatMap((slider) =>
      this.patches[which][slider.name]?.[this.at(slider)] ?? []);
    return {
      seed: element("seed").value,
      robots: this.stage.robots ?? about.robots,
      patches: patches.map(([at, text]) => [at, bytesOf(text)]),
    };
  },

  /* The episodes of all swarms under what is chosen. */
  episodes() {
    return Promise.all(swarms.map((_, which) => this.ask(which, "episode", this.world(which))));
  },

  /* What is chosen may change how many robots there are, and what stands in the arena. */
  get stage() {
    return Object.assign({}, ...about.live.sliders.map((slider) => slider.shown[this.at(slider)]));
  },

  show(episodes) {
    const before = about.robots;
    Object.assign(about, this.stage);
    element("fault-sign").hidden = !about.hasFaults;
    view.episodes = episodes;
    if (about.robots === before) return;
    panel.listRobots();
    view.chosen = view.hovered = null;
  },

  /* A browser without WebAssembly plays the first minutes of an episode instead. */
  becomeReplay() {
    swarms.forEach((swarm, which) => Object.assign(swarm, about.live.replays[which]));
    element("notice").hidden = false;
    element("notice").textContent =
      "This browser runs no WebAssembly: here is a recording of the first minutes of one episode.";
    about.live = null;
  },

  async run() {
    view.driving = null;
    this.tell();
    this.writeAddress();
    const latest = this.runs = (this.runs ?? 0) + 1;
    const found = await this.episodes().catch((error) => refuse(error.message));
    if (!found || latest !== this.runs) return;
    this.show(found);
    player.refresh();
  },

  makeControls() {
    const { sliders } = about.live;
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
    const seed = document.createElement("input");
    Object.assign(seed, { type: "number", min: 0, max: Number.MAX_SAFE_INTEGER, step: 1 });
    seed.value = "0";
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
    if (!/^\d{1,16}$/.test(element("seed").value)) element("seed").value = "0";
    for (const slider of about.live.sliders) {
      const { name, words } = slider, text = words[this.at(slider)];
      element(`${name}-value`).textContent = text;
      element(name).setAttribute("aria-valuetext", text);
    }
    element("command").textContent = this.command;
  },

  /* What makes the same episodes in a terminal. */
  get command() {
    const [start, sets] = about.live.command, { sliders } = about.live;
    const changed = sliders.filter((slider) => this.at(slider) !== slider.usual);
    const names = swarms.map(({ controller, numbers }) => {
      const own = changed.filter(({ name }) => numbers.includes(name))
        .map((slider) => `${slider.name}=${slider.values[this.at(slider)]}`);
      return own.length ? `${controller}${controller.includes(":") ? "," : ":"}${own}` : controller;
    });
    const settings = changed.flatMap((slider) => slider.settings[this.at(slider)]);
    const quoted = (word) => /[^\w:=,.+/-]/.test(word) ? `'${word}'` : word;
    const isChanged = (set) => settings.some((each) => set.includes(`=${each.split("=")[0]}=`));
    return [start, ...names.map(quoted), ...sets.filter((set) => !isChanged(set)),
      ...settings.map((each) => `--set ${quoted(each)}`),
      "--physics kinematic --episodes 1", `--seed ${element("seed").value}`].join(" ");
  },

  /* What is chosen, as in the address of the page; usual numbers are left out. */
  get choice() {
    const chosen = new URLSearchParams({ seed: element("seed").value });
    for (const slider of about.live.sliders) {
      const at = this.at(slider);
      if (at !== slider.usual) chosen.set(slider.name, slider.values[at]);
    }
    return chosen.toString();
  },

  writeAddress() { history.replaceState(null, "", `#${this.choice}`); },

  /* Choose what the address says; whether that differs from what was chosen. */
  readAddress() {
    const before = this.choice, asked = new URLSearchParams(location.hash.slice(1));
    element("seed").value = asked.get("seed") ?? "0";
    view.time = Math.min(Math.max(Number(asked.get("t")) || 0, 0), about.live.ticks * about.tick);
    for (const { name, values, usual } of about.live.sliders) {
      const at = asked.has(name) ? values.indexOf(Number(asked.get(name))) : usual;
      element(name).value = at < 0 ? usual : at;
    }
    this.tell();
    return before !== this.choice;
  },
};
