// The page: tabs, requests to the server, jobs with progress, and what each tab shows.

import { element } from "./fields.js";
import { build, defaults, read, sharedFields, showProblems, write } from "./form.js";
import { TABS } from "./tabs.js";

const at = (id) => document.getElementById(id);
const WAIT = 150; // milliseconds between questions about a job
const TYPING = 250; // milliseconds without a key before the form is sent
const ADDRESS = 200; // milliseconds without a change before the address follows
const LONGEST = 16000; // characters of an address

let tab = "press";
let sent = null; // form that is being solved
let drawn = null; // form that is shown
let job = null; // key of the job that runs
let dirty = false; // whether the form has changed meanwhile
let timer = null;
let address = null;

async function ask(path, options) {
  const response = await fetch(path, options);
  const data = await response.json().catch(() => ({ problems: [{ field: "", text: `The page was not answered (${response.status}).` }] }));
  return data;
}

function formText() {
  return read(tab).toString();
}

/** Write the form into the address, not more often than browsers allow. */
function keepAddress(at_once = false) {
  clearTimeout(address);
  if (!at_once) {
    address = setTimeout(() => keepAddress(true), ADDRESS);
    return;
  }
  const query = `tab=${tab}&${formText()}`;
  history.replaceState(null, "", query.length < LONGEST ? `?${query}` : `?tab=${tab}`);
}

/** After a change: check and solve what is quick. */
function changed(how) {
  stale();
  clearTimeout(timer);
  if (how === "slide") {
    go(false);
    return;
  }
  timer = setTimeout(() => go(false), TYPING);
}

function stale() {
  at("shown").classList.toggle("stale", drawn !== null && drawn !== `${tab}?${formText()}`);
}

/** Send the form; while an earlier one is being solved, the latest waits for it. */
async function go(run) {
  keepAddress();
  TABS[tab].changed?.(tools, at("shown"));
  const body = formText();
  const asked = `${tab}?${body}`;
  if (sent !== null) {
    if (run || asked !== sent) dirty = run ? "run" : dirty || "check";
    return;
  }
  sent = asked;
  dirty = false;
  at("long").hidden = true;
  try {
    const solve = async (long) => finished(await ask(`/api/solve?tab=${tab}&run=${long ? 1 : 0}`, { method: "POST", body }));
    let state = await solve(false);
    if (run && state.result?.long && asked.startsWith(`${tab}?`)) state = await solve(true);
    if (asked.startsWith(`${tab}?`)) shown(state, asked);
  } catch (error) {
    problems([{ field: "", text: `The page is not answered; is flatpunch still running? (${error.message})` }]);
  } finally {
    sent = null;
    job = null;
    at("status").hidden = true;
    if (dirty) go(dirty === "run");
  }
}

/** Wait for the end of a job, with its progress if it is a loud one. */
async function finished(state, loud = true) {
  let pause = WAIT;
  while (state.state === "waiting" || state.state === "running") {
    if (loud) job = state.key;
    if (loud && state.seconds > 0.4) progress(state);
    await new Promise((resolve) => setTimeout(resolve, pause));
    pause = Math.min(1.2 * pause, 1000);
    state = await ask(`/api/job?key=${state.key}`);
  }
  return state;
}

function progress(state) {
  at("status").hidden = false;
  const bar = at("progress");
  if (state.progress) {
    bar.max = state.progress[1];
    bar.value = state.progress[0];
  } else bar.removeAttribute("value");
  const done = state.progress ? `${state.progress[0]} of ${state.progress[1]}, ` : "";
  at("status-text").textContent = state.state === "waiting" ? "Waiting for another job" : `Solving, ${done}${Math.round(state.seconds)} s`;
}

function shown(state, asked) {
  if (state.state === "stopped") {
    problems(standing());
    long("Stopped. The results below, if any, belong to an earlier form.");
    return;
  }
  const result = state.result ?? { problems: state.problems ?? [{ field: "", text: state.message ?? "It was not solved." }] };
  if (result.problems) {
    problems(result.problems);
    stale();
    return;
  }
  problems(standing());
  if (typeof result.long === "string") {
    long(result.long);
    return;
  }
  if (result.long) {
    long(result.about.find((line) => line.startsWith("Takes"))?.replace("Takes", "Solving takes").replace(/\s+/g, " ") ?? "");
    return;
  }
  drawn = asked;
  at("shown").classList.toggle("stale", asked !== `${tab}?${formText()}`);
  TABS[tab].show(at("shown"), result, tools);
}

/** Problems that an answer to the form does not end: of a file that cannot be read, say. */
function standing() {
  return TABS[tab].standing?.() ?? [];
}

function problems(list) {
  const elsewhere = showProblems(list);
  at("problems").replaceChildren(...elsewhere.map((text) => element("li", {}, text)));
  at("problems").hidden = !elsewhere.length;
}

function long(text) {
  at("long").hidden = false;
  at("long").querySelector("p").textContent = text;
  at("solve").textContent = TABS[tab].verb ?? "Solve";
}

/** What tabs may do besides drawing. */
const tools = {
  form: formText,
  async detail(name, step) {
    const state = await ask(`/api/detail?tab=${tab}&name=${name}&step=${step}`, { method: "POST", body: formText() });
    const end = await finished(state);
    at("status").hidden = true;
    return end.result ?? { none: end.message ?? end.problems?.[0]?.text ?? "It was stopped." };
  },
  async preview(name) {
    const state = await ask(`/api/detail?tab=${tab}&name=${name}`, { method: "POST", body: formText() });
    const end = await finished(state, false);
    return end.result ?? { problems: end.problems ?? [{ field: "", text: end.message ?? "It was stopped." }] };
  },
  async save(kind, button) {
    button.disabled = true;
    try {
      const response = await fetch(`/file/${tab}.${kind}`, { method: "POST", body: formText() });
      if (!response.ok) {
        problems((await response.json()).problems);
        return;
      }
      const named = /filename\*=UTF-8''([^;]+)/.exec(response.headers.get("Content-Disposition"));
      const link = element("a", { href: URL.createObjectURL(await response.blob()), download: decodeURIComponent(named[1]) });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    } finally {
      button.disabled = false;
    }
  },
  changed,
  run: () => go(true),
  problems,
  ask,
};

function choose(name) {
  tab = name in TABS ? name : "press";
  document.body.dataset.tab = tab;
  for (const button of at("tabs").children) {
    button.setAttribute("aria-selected", button.dataset.tab === tab);
    button.tabIndex = button.dataset.tab === tab ? 0 : -1;
  }
  at("shown").replaceChildren();
  drawn = null;
  problems([]);
}

function tabs() {
  const [before, after] = sharedFields();
  const own = [];
  for (const [name, { title, fields }] of Object.entries(TABS)) {
    const button = element("button", { type: "button", role: "tab", "data-tab": name, id: `tab-${name}` }, title);
    button.addEventListener("click", () => {
      choose(name);
      go(true);
    });
    at("tabs").append(button);
    at("job").append(element("h2", { "data-tabs": name }, title));
    own.push(element("div", { "data-tabs": name }, ...fields(tools)));
  }
  at("job").append(...before, ...own, ...after);
  at("tabs").addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const all = [...at("tabs").children];
    const next = all[(all.indexOf(document.activeElement) + step + all.length) % all.length];
    next.focus();
    next.click();
  });
}

function theme() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const kept = localStorage.getItem("flatpunch-theme");
  const set = (name) => (document.documentElement.dataset.theme = name);
  set(kept ?? (dark.matches ? "dark" : "light"));
  dark.addEventListener("change", () => !localStorage.getItem("flatpunch-theme") && set(dark.matches ? "dark" : "light"));
  at("theme").addEventListener("click", () => {
    set(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
    localStorage.setItem("flatpunch-theme", document.documentElement.dataset.theme);
  });
}

function load(fields, name) {
  choose(name);
  write(fields);
  go(true);
}

async function begin() {
  theme();
  const start = await ask("/api/start");
  at("version").textContent = `flatpunch ${start.version}`;
  build(start.tables, at("form"), changed);
  tabs();
  start.examples.forEach((example, i) => at("example").append(element("option", { value: i }, example.title)));
  at("example").addEventListener("change", () => {
    const example = start.examples[at("example").value];
    if (example) load(new URLSearchParams(example.form), example.tab);
    at("example").value = "";
  });
  at("open-case").addEventListener("click", () => at("case-file").click());
  at("case-file").addEventListener("change", async () => {
    const file = at("case-file").files[0];
    at("case-file").value = "";
    if (!file) return;
    const found = await ask("/api/case", { method: "POST", body: file }).catch(() => ({ problems: [{ field: "", text: `${file.name} could not be sent; case files of up to 5 MB are read.` }] }));
    if (found.problems) problems(found.problems);
    else load(new URLSearchParams(found.form), tab);
  });
  at("stop").addEventListener("click", () => job && ask(`/api/stop?key=${job}`, { method: "POST" }));
  at("solve").addEventListener("click", () => go(true));
  at("form").addEventListener("keydown", (event) => {
    if (event.key === "Enter" && event.target.tagName === "INPUT") go(true);
  });
  const given = new URLSearchParams(location.search);
  const name = given.get("tab") ?? "press";
  given.delete("tab");
  choose(name);
  defaults();
  if ([...given.keys()].length) write(given);
  document.body.dataset.ready = "yes";
  go(true);
}

begin();
