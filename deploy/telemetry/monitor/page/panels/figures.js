// Heading, figures and the banner with the state of the run.
const PHASES = {
  searching: ["Looking for the run", "idle"],
  gathering: ["Waiting for robots", "idle"],
  running: ["Running", "live"],
  paused: ["Paused", "warn"],
  halted: ["Emergency stop", "bad"],
  lost: ["The world is gone", "bad"],
};

const VERDICTS = {
  arrived: ["✓ Arrived", "good"],
  collision: ["✕ Collision", "bad"],
  aborted: ["✕ Aborted", "bad"],
  timeout: ["Timeout", "warn"],
  deadlock: ["Deadlock", "warn"],
  interrupted: ["Interrupted", "warn"],
};

export function showFigures(frame, model) {
  const name = model.overview?.scenario ?? "disknav";
  write("scenario", name);
  document.title = name === "disknav" ? name : `${name} · disknav`;
  write("run", model.run ? `disknav/${model.run}` : "");
  if (frame === null) {
    banner(["Connection lost", "bad"]);
    return;
  }
  banner(frame.verdict ? VERDICTS[frame.verdict] ?? [frame.verdict, "warn"] : PHASES[frame.phase]);
  write("reason", frame.reason);
  write("time", frame.time.toFixed(2));
  write("tick", String(frame.tick));
  write("pace", frame.pace.toFixed(0));
  write("smallest", frame.smallest === null ? "–" : (frame.smallest * 1000).toFixed(2));
}

function banner([text, tone]) {
  write("verdict", text);
  document.getElementById("verdict").dataset.tone = tone;
}

function write(id, text) {
  const target = document.getElementById(id);
  if (target.textContent !== text) target.textContent = text;
}
