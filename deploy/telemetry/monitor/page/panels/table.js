// A row per robot, built once per scenario; only changed text is written. Of many robots only alarms and the
// selected one are shown by default.
const MANY = 24; // robots; with more the table folds
const NAMED = 5; // alarms read out by name
const COLUMNS = [
  { name: "status", text: (row) => row.status },
  { name: "distance", label: "To goal, mm", text: (row) => millimetres(row.distance) },
  { name: "age", label: "Age, s", text: (row) => number(row.age, 1), hint: (row) => (row.age_ticks === null ? "" : `${row.age_ticks} ticks behind`) },
  { name: "rate", label: "Rate, 1/s", text: (row) => number(row.rate, 0) },
  { name: "bound", label: "Error, mm", text: (row) => millimetres(row.bound) },
  { name: "rejected", label: "Rejected", text: (row) => String(row.rejected), hint: (row) => reasons(row.reasons) },
  { name: "restarts", label: "Restarts", text: (row) => String(row.restarts) },
];

export class RobotTable {
  constructor(body, selection) {
    Object.assign(this, { body, selection, rows: [], folded: false });
    const parts = ["count", "alarms", "find", "finder", "fold"];
    this.part = Object.fromEntries(parts.map((id) => [id, document.getElementById(id)]));
    body.addEventListener("keydown", (event) => this.key(event));
    body.addEventListener("pointerleave", () => selection.point(null));
    this.part.fold.addEventListener("click", () => this.fold(!this.folded));
    this.part.find.addEventListener("input", () => this.find());
  }

  begin(model) {
    this.model = model;
    this.rows = model.robots.map((robot) => this.build(robot));
    this.body.replaceChildren(...this.rows.map((row) => row.line));
    const many = this.rows.length > MANY;
    this.part.finder.hidden = this.part.fold.hidden = !many;
    this.body.closest("section").toggleAttribute("data-many", many);
    this.fold(many);
  }

  build(robot) {
    const line = document.createElement("tr");
    line.dataset.robot = robot.id;
    line.style.setProperty("--hue", `var(--robot-${robot.hue})`);
    line.addEventListener("click", () => this.selection.toggle(robot.id));
    line.addEventListener("pointerenter", () => this.selection.point(robot.id));
    const head = document.createElement("th");
    head.scope = "row";
    const button = document.createElement("button"); // clicks select the row
    button.type = "button";
    button.tabIndex = -1;
    button.setAttribute("aria-label", `Robot ${robot.id}`);
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    button.append(swatch, String(robot.id));
    button.addEventListener("focus", () => this.selection.point(robot.id));
    head.append(button);
    const cells = COLUMNS.map((column) => {
      const cell = document.createElement("td");
      cell.className = column.name;
      if (column.label) cell.dataset.label = column.label;
      return cell;
    });
    line.append(head, ...cells);
    return { line, button, cells, robot };
  }

  fold(folded) {
    this.folded = folded;
    this.part.fold.textContent = folded ? `Show all ${this.rows.length}` : "Show alarms and selection only";
    this.part.fold.setAttribute("aria-expanded", String(!folded));
    if (this.model) this.show(this.model);
  }

  show(model) {
    if (model.frame === null) return;
    for (const shown of this.rows) this.showRow(shown, shown.robot.row);
    this.count(this.rows.map((shown) => shown.robot.row).filter(Boolean));
    this.chooseStop();
    if (this.selection.selected !== this.found) this.reveal();
  }

  showRow({ line, button, cells, robot }, row) {
    const { selected, pointed } = this.selection;
    const chosen = robot.id === selected;
    line.hidden = this.folded && !chosen && !row?.alarm;
    if (line.hidden || row === null) return;
    line.dataset.status = row.status;
    line.toggleAttribute("data-alarm", row.alarm);
    line.toggleAttribute("data-selected", chosen);
    line.toggleAttribute("data-pointed", robot.id === pointed);
    button.setAttribute("aria-pressed", String(chosen));
    COLUMNS.forEach((column, i) => fill(cells[i], column.text(row), column.hint?.(row) ?? ""));
  }

  // "6 robots: 4 under way, 2 at goal", with new alarms read out.
  count(rows) {
    const counts = new Map();
    for (const row of rows) counts.set(row.status, (counts.get(row.status) ?? 0) + 1);
    const each = [...counts].map(([status, count]) => `${count} ${status}`).join(", ");
    fill(this.part.count, `${rows.length} robot${rows.length === 1 ? "" : "s"}: ${each}`, "");
    const alarms = rows.filter((row) => row.alarm).map((row) => `robot ${row.id} ${row.status}`);
    const more = alarms.length > NAMED ? ` and ${alarms.length - NAMED} more` : "";
    fill(this.part.alarms, alarms.length ? `Alarm: ${alarms.slice(0, NAMED).join(", ")}${more}` : "", "");
  }

  // Scroll to a row that was selected elsewhere.
  reveal() {
    this.found = this.selection.selected;
    const shown = this.rows.find((row) => row.robot.id === this.found);
    const box = this.body.closest(".rows");
    if (shown && box.scrollHeight > box.clientHeight) {
      box.scrollTop += shown.line.getBoundingClientRect().top - box.getBoundingClientRect().top - box.clientHeight / 2;
    }
  }

  find() {
    const id = this.part.find.valueAsNumber;
    if (this.model.robot(id) !== null) this.selection.select(id);
  }

  // The table is one stop of the Tab key; arrow keys select rows.
  chooseStop() {
    const open = this.rows.filter((row) => !row.line.hidden);
    const held = open.find((row) => row.button === document.activeElement);
    const stop = held ?? open.find((row) => row.robot.id === this.selection.selected) ?? open[0];
    for (const row of this.rows) row.button.tabIndex = row === stop ? 0 : -1;
  }

  key(event) {
    const open = this.rows.filter((row) => !row.line.hidden);
    const here = open.findIndex((row) => row.button === document.activeElement);
    const there = { ArrowDown: here + 1, ArrowUp: here - 1, Home: 0, End: open.length - 1 }[event.key];
    if (here < 0 || there === undefined || !open[there]) return;
    event.preventDefault();
    open[there].button.focus();
    this.chooseStop();
  }
}

function fill(cell, text, hint) {
  if (cell.textContent !== text) cell.textContent = text;
  if (cell.title !== hint) cell.title = hint;
}

const number = (value, digits) => (value === null ? "–" : value.toFixed(digits));
const millimetres = (metres) => (metres === null ? "–" : (metres * 1000).toFixed(1));
const reasons = (counts) => Object.entries(counts).map(([reason, count]) => `${reason}: ${count}`).join(", ");
