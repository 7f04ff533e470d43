// A row per robot, built once per scenario; only text that changed is touched.
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
  constructor(body) {
    this.body = body;
    this.rows = [];
  }

  begin(model) {
    this.rows = model.robots.map((robot) => this.build(robot));
    this.body.replaceChildren(...this.rows.map((row) => row.line));
  }

  build(robot) {
    const line = document.createElement("tr");
    line.dataset.robot = robot.id;
    line.style.setProperty("--hue", `var(--robot-${robot.hue})`);
    const head = document.createElement("th");
    head.scope = "row";
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    head.append(swatch, String(robot.id));
    const cells = COLUMNS.map((column) => {
      const cell = document.createElement("td");
      cell.className = column.name;
      if (column.label) cell.dataset.label = column.label;
      return cell;
    });
    line.append(head, ...cells);
    return { line, cells };
  }

  show(frame) {
    frame.robots.forEach((row, index) => {
      const shown = this.rows[index];
      if (!shown) return;
      shown.line.dataset.status = row.status;
      shown.line.toggleAttribute("data-alarm", row.alarm);
      COLUMNS.forEach((column, i) => fill(shown.cells[i], column.text(row), column.hint?.(row) ?? ""));
    });
  }
}

function fill(cell, text, hint) {
  if (cell.textContent !== text) cell.textContent = text;
  if (cell.title !== hint) cell.title = hint;
}

const number = (value, digits) => (value === null ? "–" : value.toFixed(digits));
const millimetres = (metres) => (metres === null ? "–" : (metres * 1000).toFixed(1));
const reasons = (counts) => Object.entries(counts).map(([reason, count]) => `${reason}: ${count}`).join(", ");
