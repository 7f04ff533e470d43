// The emergency stop: a button, and the key S with any focus. Only the button releases: the stops that it has shown.
const DONE = ["ended", "lost", "searching"];

export class Halt {
  constructor(send) {
    this.send = send;
    this.may = this.open = this.halted = false;
    this.button = document.getElementById("halt");
    this.note = document.getElementById("halt-note");
    this.button.addEventListener("click", () => this.send(this.halted ? { release: this.stops } : { halt: true }));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  allow(may) {
    this.may = may;
    this.button.hidden = !may;
  }

  show(frame) {
    this.halted = frame.phase === "halted";
    this.stops = frame.stops;
    this.open = !DONE.includes(frame.phase);
    this.button.disabled = !this.open;
    this.button.textContent = this.halted ? "Release all" : "Stop all";
    this.button.title = this.halted ? "The robots may move again" : "Emergency stop: every robot brakes from the next tick on (key S)";
    this.button.toggleAttribute("data-halted", this.halted);
  }

  answered(text) {
    this.note.textContent = text && `Emergency stop: ${text}`;
  }

  key(event) {
    if (event.key.toLowerCase() !== "s" || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    if (this.may && this.open) this.send({ halt: true });
  }
}
