// Pause, step and speed of a lock-step run; Space and the right arrow do the same, Escape deselects.
const REAL_TIME = "This run is in real time: it cannot be paused.";

export class Controls {
  constructor(send, selection) {
    this.send = send;
    this.selection = selection;
    this.paused = false;
    this.pause = document.getElementById("pause");
    this.step = document.getElementById("step");
    this.speed = document.getElementById("speed");
    this.note = document.getElementById("held");
    this.pause.addEventListener("click", () => this.toggle());
    this.step.addEventListener("click", () => this.send({ steer: { step: 1 } }));
    this.speed.addEventListener("change", () => this.send({ steer: { speed: Number(this.speed.value) } }));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  begin(overview) {
    this.lockstep = overview.scenario !== null && overview.lockstep;
    this.note.textContent = overview.scenario !== null && !overview.lockstep ? REAL_TIME : "";
  }

  show(frame) {
    const open = this.lockstep && !["ended", "lost", "searching"].includes(frame.phase);
    for (const control of [this.pause, this.step, this.speed]) control.disabled = !open;
    this.paused = frame.steering.paused;
    this.pause.textContent = this.paused ? "Resume" : "Pause";
    if (document.activeElement !== this.speed) this.showSpeed(this.lockstep ? frame.steering.speed : 1);
  }

  showSpeed(speed) {
    const value = String(speed);
    if (![...this.speed.options].some((option) => option.value === value)) this.speed.add(new Option(`${speed}×`, value));
    if (this.speed.value !== value) this.speed.value = value;
  }

  lost() {
    for (const control of [this.pause, this.step, this.speed]) control.disabled = true;
  }

  refused(text) {
    this.note.textContent = text;
  }

  toggle() {
    if (!this.pause.disabled) this.send({ steer: { pause: !this.paused } });
  }

  key(event) {
    if (event.key === "Escape") this.selection.select(null);
    if (event.target.closest("button, input, select") || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === " ") {
      event.preventDefault();
      this.toggle();
    } else if (event.key === "ArrowRight" && !this.step.disabled) {
      this.send({ steer: { step: 1 } });
    }
  }
}
