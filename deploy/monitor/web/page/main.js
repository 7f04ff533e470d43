// Wires the page together: news from the fleet go into the model, the parts show what it holds.
import { Controls } from "./controls.js";
import { showFigures } from "./figures.js";
import { Live } from "./live.js";
import { Model } from "./model.js";
import { Plot } from "./drawing/plot.js";
import { RobotTable } from "./table.js";
import { followTheme } from "./drawing/theme.js";
import { Workspace } from "./drawing/workspace.js";

const element = (id) => document.getElementById(id);

const model = new Model();
const workspace = new Workspace(element("workspace"), model);
const table = new RobotTable(element("robots"));
const controls = new Controls((order) => live.send(order));
const plots = [
  new Plot(element("clearance"), element("clearance-now"), model, {
    pick: (point) => point[1] * 1000, unit: " mm", digits: 1, floor: 0, zero: "contact", name: "Clearance",
  }),
  new Plot(element("phi"), element("phi-now"), model, {
    pick: (point) => point[2], unit: "", digits: 4, floor: 0, ceiling: 1, name: "Navigation function",
  }),
];

const live = new Live({
  overview(overview) {
    model.begin(overview);
    table.begin(model);
    controls.begin(overview);
    redraw();
  },
  frame(frame) {
    model.take(frame, performance.now());
    table.show(frame, model);
    controls.show(frame);
    showFigures(frame, model);
    redraw();
  },
  lost() {
    controls.lost();
    showFigures(null, model);
  },
  refused: (text) => controls.refused(text),
});

function redraw() {
  workspace.wake();
  plots.forEach((plot) => plot.wake());
}

followTheme(element("theme"), redraw);
new ResizeObserver(redraw).observe(document.body);
live.open();
