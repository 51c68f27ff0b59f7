// The page: tabs, requests to the server, jobs with progress, and what each tab shows.

import { element } from "./fields.js";
import { ask, finished, stop } from "./jobs.js";
import { build, defaults, read, sharedFields, showProblems, write } from "./form.js";
import { TABS } from "./tabs.js";

const at = (id) => document.getElementById(id);
const TYPING = 250; // milliseconds without a key before the form is sent
const ADDRESS = 200; // milliseconds without a change before the address follows
const LONGEST = 16000; // characters of an address
const STOPPED = "Stopped. The results below, if any, belong to an earlier form.";

let tab = "press";
let sent = null; // form that is being checked, and solved if that is quick
let drawn = null; // form that is shown
let version = 0; // of what is shown; details of an earlier one are no longer wanted
let beside = null; // long job that runs while the page is used: its form
let halted = null; // form whose solution was stopped last
let dirty = false; // whether the form has changed meanwhile
let timer = null;
let address = null;

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

const asking = () => `${tab}?${formText()}`;
const solve = (asked, long) => ask(`/api/solve?tab=${asked.slice(0, asked.indexOf("?"))}&run=${long ? 1 : 0}`, { method: "POST", body: asked.slice(asked.indexOf("?") + 1) });

/** Send the form; while an earlier one is being solved, the latest waits for it. Long jobs run beside. */
async function go(run) {
  keepAddress();
  TABS[tab].changed?.(tools, at("shown"));
  const asked = asking();
  if (sent !== null) {
    if (run || asked !== sent) dirty = run ? "run" : dirty || "check";
    return;
  }
  sent = asked;
  dirty = false;
  at("long").hidden = true;
  const [mine, here] = [tab, () => asked.startsWith(`${tab}?`)];
  try {
    const state = await finished(await solve(asked, false), { wanted: () => tab === mine });
    if (here() && run && state.result?.long) runBeside(asked);
    else if (here() && !(state.result?.long && beside === asked)) shown(state, asked);
  } catch (error) {
    unanswered(error);
  } finally {
    sent = null;
    if (dirty) go(dirty === "run");
  }
}

/** Solve a form that takes long while the page is used; a second one takes the place of the first. */
async function runBeside(asked) {
  if (beside === asked) return;
  beside = asked;
  problems(standing());
  try {
    const state = await finished(await solve(asked, true), { wanted: () => beside === asked, long: true });
    // elsewhere meanwhile: the server keeps the result for when this form comes back
    if (beside === asked && asked === asking()) shown(state, asked);
  } catch (error) {
    unanswered(error);
  } finally {
    if (beside === asked) beside = null;
  }
}

function unanswered(error) {
  problems([{ field: "", text: `The page is not answered; is flatpunch still running? (${error.message})` }]);
}

function shown(state, asked) {
  if (state.state === "stopped") {
    problems(standing());
    halted = asked;
    long(STOPPED);
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
    const takes = result.about.find((line) => line.startsWith("Takes"))?.replace("Takes", "Solving takes").replace(/\s+/g, " ") ?? "";
    long(asked === halted ? `${STOPPED} ${takes}` : takes);
    return;
  }
  drawn = asked;
  version += 1;
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
    const shownNow = version;
    const state = await ask(`/api/detail?tab=${tab}&name=${name}&step=${step}`, { method: "POST", body: formText() });
    const end = await finished(state, { wanted: () => version === shownNow });
    return end.result ?? { none: end.message ?? end.problems?.[0]?.text ?? "It was stopped." };
  },
  async preview(name) {
    const state = await ask(`/api/detail?tab=${tab}&name=${name}`, { method: "POST", body: formText() });
    const end = await finished(state, { loud: false });
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
  version += 1;
  problems([]);
}

function tabs() {
  const [before, after] = sharedFields();
  const own = [];
  for (const [name, { title, fields }] of Object.entries(TABS)) {
    const button = element("button", { type: "button", role: "tab", "data-tab": name, id: `tab-${name}` }, title);
    button.addEventListener("click", () => {
      choose(name);
      // the one long job goes on while another tab is looked at
      go(beside === null);
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
  at("stop").addEventListener("click", stop);
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
