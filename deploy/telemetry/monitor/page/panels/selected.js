// The selected robot: its values, and its goal, set by a click in the picture or by numbers.
const LOOKS = "This page may not steer. To set goals, open the printed address with its token.";
const DIGITS = 4; // of a metre

export class SelectedRobot {
  constructor(model, selection, send) {
    Object.assign(this, { model, selection, send, may: false });
    const parts = ["selected", "selected-heading", "values", "order", "goal-x", "goal-y", "queue", "stay", "deselect", "how", "answer"];
    this.part = Object.fromEntries(parts.map((id) => [id, document.getElementById(id)]));
    this.part.order.addEventListener("submit", (event) => this.submit(event));
    this.part.stay.addEventListener("click", () => this.order([]));
    this.part.deselect.addEventListener("click", () => selection.select(null));
  }

  allow(may) {
    this.may = may;
    this.show();
  }

  // Whether orders are possible now.
  get open() {
    const phase = this.model.frame?.phase;
    return this.may && this.robot !== null && ["running", "paused", "halted", "gathering"].includes(phase);
  }

  get robot() {
    return this.model.robot(this.selection.selected);
  }

  show() {
    const { robot, part } = this;
    const changed = this.shown !== robot?.id;
    this.shown = robot?.id;
    part.selected.toggleAttribute("data-none", robot === null);
    write(part["selected-heading"], robot ? `Robot ${robot.id}` : "No robot selected");
    part.values.hidden = part.deselect.hidden = robot === null;
    part.order.hidden = !this.open;
    write(part.how, this.hint());
    if (robot === null) return;
    part.selected.style.setProperty("--hue", `var(--robot-${robot.hue})`);
    values(robot, this.model).forEach(([name, text]) => write(document.getElementById(`value-${name}`), text));
    if (changed) this.fill(robot);
  }

  hint() {
    if (!this.robot) return "Select one in the picture or in the table.";
    if (!this.may && this.model.frame !== null) return LOOKS;
    return this.open ? "Click in the picture to set its goal." : "";
  }

  fill(robot) {
    this.part.queue.checked = false;
    this.enter(robot.goal);
    if (this.asked !== robot.id) this.say("", "");
  }

  enter([x, y]) {
    this.part["goal-x"].value = Number(x.toFixed(DIGITS));
    this.part["goal-y"].value = Number(y.toFixed(DIGITS));
  }

  submit(event) {
    event.preventDefault();
    const point = [this.part["goal-x"].valueAsNumber, this.part["goal-y"].valueAsNumber];
    this.order([point]);
  }

  // Send the selected robot to points, m; queued: after its present goal. No points: it stays.
  order(points, queued = false) {
    if (!this.open) return;
    this.asked = this.robot.id;
    if (points.length) this.enter(points.at(-1));
    this.say("Sent …", "");
    this.send({ goal: { robot: this.asked, points, queue: points.length > 0 && (queued || this.part.queue.checked) } });
  }

  answered({ robot, points, accepted, text }) {
    this.asked = robot;
    if (!accepted) return this.say(`Robot ${robot} refused: ${text}`, "bad");
    const where = points.length ? `goes to ${place(points.at(-1))}` : "stays where it is";
    return this.say(`Robot ${robot} ${where}.${text ? ` Beware: ${text}` : ""}`, text ? "warn" : "good");
  }

  say(text, tone) {
    write(this.part.answer, text);
    this.part.answer.dataset.tone = tone;
  }
}

// Values of a robot, as [name, text].
export function values(robot, model) {
  const { row } = robot;
  const ahead = row?.ahead ? `, then ${row.ahead} more` : "";
  return [
    ["status", row?.status ?? "–"],
    ["distance", row ? millimetres(row.distance) : "–"],
    ["speed", row ? `${(Math.hypot(...row.velocity) * 1000).toFixed(0)} mm/s` : "–"],
    ["clearance", model.robots.length ? millimetres(model.clearance(robot)) : "–"],
    ["position", place(robot.to)],
    ["goal", place(robot.goal) + ahead],
  ];
}

const place = ([x, y]) => `(${x.toFixed(3)}, ${y.toFixed(3)}) m`;
const millimetres = (metres) => `${(metres * 1000).toFixed(1)} mm`;

function write(target, text) {
  if (target.textContent !== text) target.textContent = text;
}
