// Jobs of the server: asked about until they end, their progress, the button that stops them.

const at = (id) => document.getElementById(id);
const WAIT = 150; // milliseconds between questions about a job
const PATIENCE = 0.4; // seconds after which progress is shown
const RESTART = 3000; // milliseconds that a process takes to start: a job that ends sooner is not stopped

let watched = []; // jobs whose progress may be shown; a long one comes first

export async function ask(path, options) {
  const response = await fetch(path, options);
  return response.json().catch(() => ({ problems: [{ field: "", text: `The page was not answered (${response.status}).` }] }));
}

const end = (key) => ask(`/api/stop?key=${key}`, { method: "POST" });

/** Stop the job whose progress is shown. */
export function stop() {
  if (watched.length) end(watched[0].key);
}

/** Wait for the end of a job, with its progress unless it is not a loud one; a job that is no longer wanted is stopped. */
export async function finished(state, { loud = true, long = false, wanted = () => true }) {
  const job = { key: state.key, state, long };
  if (loud && state.key) watched = long ? [job, ...watched] : [...watched, job];
  let pause = WAIT;
  try {
    while (job.state.state === "waiting" || job.state.state === "running") {
      if (!wanted()) {
        setTimeout(() => end(job.key), job.state.state === "waiting" ? 0 : RESTART);
        return { state: "stopped" };
      }
      progress();
      await new Promise((resolve) => setTimeout(resolve, pause));
      pause = Math.min(1.2 * pause, 1000);
      job.state = await ask(`/api/job?key=${job.key}`);
    }
    return job.state;
  } finally {
    watched = watched.filter((each) => each !== job);
    progress();
  }
}

/** Show the progress of the first job that is watched. */
function progress() {
  const state = watched[0]?.state;
  at("status").hidden = !(state?.seconds > PATIENCE);
  if (at("status").hidden) return;
  const bar = at("progress");
  const [steps, all] = state.progress ?? [0, 0]; // all = 0: nobody knows how many there will be
  if (all) {
    bar.max = all;
    bar.value = steps;
  } else bar.removeAttribute("value");
  const done = all ? `${steps} of ${all}, ` : "";
  at("status-text").textContent = state.state === "waiting" ? "Waiting for a free process" : `Solving, ${done}${Math.round(state.seconds)} s`;
}
