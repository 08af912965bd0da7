/* The words beside the picture. */
const SEEN = about.believes ? "what it believes and hears" : "what it hears";
const HINT = window.matchMedia("(hover: none)").matches
  ? `Tap a robot to see ${SEEN}.`
  : `Point at a robot to see ${SEEN}; click to keep it.`;

const panel = {
  prepare() {
    element("command").textContent = about.command;
    element("ring").textContent = `${Math.round(100 * about.ring)} cm`;
    this.prepareWords();
    element("legend").replaceChildren(...about.states.map((state, code) => {
      const row = document.createElement("li");
      const dot = row.appendChild(document.createElement("i"));
      dot.style.background = about.colours.doing[code];
      row.appendChild(document.createElement("span")).textContent = state;
      swarms.forEach((_, which) => {
        row.appendChild(document.createElement("b")).className = `swarm-${which}`;
      });
      row.hidden = !state;
      return row;
    }));
    if (swarms.length > 1) element("legend").prepend(this.headOfLegend());
    element("fault-sign").hidden = !about.columns.some((column) => column.name === "faulty");
    this.listRobots();
    const gap = (about.tick * about.every).toFixed(1);
    element("sampling").textContent = about.live
      ? `This page runs the world itself, in WebAssembly, and draws every ${gap} s of it.`
      : about.every === 1
      ? `Every tick of ${gap} s is kept.`
      : `To keep the file small, one frame is kept every ${gap} s (${about.every} ticks); `
        + "robots move on straight lines between.";
  },

  listRobots() {
    const names = Array.from({ length: about.robots }, (_, robot) => String(robot));
    const options = names.map((name) => new Option(name, name));
    element("robot").replaceChildren(new Option("none", ""), ...options);
  },

  /* Which column counts which swarm. */
  headOfLegend() {
    const row = document.createElement("li");
    row.append(document.createElement("span"), document.createElement("span"));
    swarms.forEach(({ controller }, which) => {
      const sign = row.appendChild(document.createElement("em"));
      sign.className = `swarm-${which}`;
      sign.title = controller;
    });
    return row;
  },

  /* What the score and the signs are called here; robots that visit goals have others. */
  prepareWords() {
    element("score-name").textContent = about.headings[0];
    element("share-name").textContent = about.headings[1];
    element(about.goals ? "signs" : "goal-signs").remove();
    if (!about.believes) {
      element("share-box").title = "";
      element("beliefs").hidden = true;
      element("signs").querySelectorAll(".of-belief").forEach((sign) => sign.remove());
    }
    if (!about.goals) return;
    element("goal-signs").id = "signs";
    element("share-box").title = "Share of robots whose true place lies within their ellipse";
    element("messages").textContent = "Lidar";
    element("beliefs").textContent = "Estimates";
    view.show.beliefs = true;
    element("beliefs").setAttribute("aria-pressed", "true");
    element("arena").setAttribute("aria-label", "Top view of the field with home, goals and robots");
    element("curves").setAttribute("aria-label",
      "Goals reached by the swarm and share of robots within their ellipse, over time");
  },

  draw() {
    const last = view.last;
    eachSwarm((_, which) => this.count(which));
    values("trips", eachSwarm(() => view.episode.total[last]));
    values("on-path", eachSwarm(() => `${Math.round(100 * view.episode.share[last])}%`));
    const slider = element("time");
    slider.value = view.time;
    slider.setAttribute("aria-valuetext", `${clockText(view.time)} of ${clockText(view.end)}`);
    const clock = element("clock"), whole = document.createElement("small");
    whole.textContent = ` / ${clockText(view.end)}`;
    clock.replaceChildren(clockText(view.time), whole);
    element("robot").value = view.focus ?? "";
    this.card();
    if (about.live) drive.draw();
  },

  /* How many robots of a swarm are doing what. */
  count(which) {
    const { episode, last } = view;
    const counts = about.states.map(() => 0);
    for (let robot = 0; robot < about.robots; robot++) {
      counts[episode.doing[robot * about.frames + last]]++;
    }
    element("legend").querySelectorAll(`b.swarm-${which}`).forEach((cell, code) => {
      cell.textContent = counts[code];
    });
  },

  card() {
    const card = element("robot-card");
    element("signs").classList.toggle("idle", !about.goals && view.focus === null);
    if (view.focus === null) {
      const hint = document.createElement("p");
      hint.textContent = HINT;
      card.replaceChildren(hint);
      return;
    }
    card.replaceChildren(...eachSwarm(({ controller }, which) => {
      const made = this.robotTable(robotAt(view.focus));
      if (swarms.length > 1) {
        made.createCaption().textContent = controller;
        made.caption.className = `swarm-${which}`;
      }
      return made;
    }));
  },

  /* What there is to say of a robot. */
  robotTable(robot) {
    const heard = messagesNow().filter((message) => message.receiver === view.focus);
    const senders = [...new Set(heard.map((message) => message.sender))].sort((a, b) => a - b);
    const rows = about.goals ? [[""], ...goals.rows(robot)] : [
      about.believes ? ["", "off by", "p"] : [""],
      ...(about.believes ? robot.beliefs : []).map((belief, which) => [
        AREAS[which],
        belief ? `${belief.off.toFixed(2)} m` : "unknown",
        belief ? `${belief.p.toFixed(2)} m` : "–",
      ]),
      [about.headings[0].toLowerCase(), String(robot.trips)],
    ];
    rows.push(["doing", about.states[robot.doing] + (robot.faulty ? ", faulty" : "")]);
    rows.push([about.goals ? "sees" : "hears",
      senders.length ? `robot ${senders.join(", ")}` : "nobody"]);
    return table(rows);
  },
};

/* A value for each swarm, in its colour where there are several. */
function values(id, texts) {
  element(id).replaceChildren(...texts.map((text, which) => {
    const value = document.createElement("span");
    value.className = `swarm-${which}`;
    value.textContent = text;
    return value;
  }));
}

/* A table; the first row is its head, the first column names the others, a short row is wide. */
function table(rows) {
  const made = document.createElement("table");
  rows.forEach((cells, r) => {
    const section = r === 0 ? made.createTHead() : made.tBodies[0] ?? made.createTBody();
    const row = section.insertRow();
    cells.forEach((text, c) => {
      const cell = row.appendChild(document.createElement(r === 0 || c === 0 ? "th" : "td"));
      if (cells.length === 2 && c === 1) cell.colSpan = 2;
      const area = c === 0 ? AREAS.indexOf(text) : -1;
      if (area >= 0) {
        const dot = cell.appendChild(document.createElement("i"));
        dot.style.background = about.colours.areas[area];
      }
      cell.append(text);
    });
  });
  return made;
}
