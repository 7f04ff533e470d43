// Connects the page: messages update the model, which the panels show.
import { Controls } from "./panels/controls.js";
import { showFigures } from "./panels/figures.js";
import { Halt } from "./panels/halt.js";
import { SelectedRobot } from "./panels/selected.js";
import { RobotTable } from "./panels/table.js";
import { Live } from "./live.js";
import { Model } from "./model.js";
import { Selection } from "./selection.js";
import { Plot } from "./drawing/plot.js";
import { Pointer } from "./drawing/pointer.js";
import { followTheme } from "./drawing/theme.js";
import { Workspace } from "./drawing/workspace.js";

const element = (id) => document.getElementById(id);

const model = new Model();
const selection = new Selection();
const workspace = new Workspace(element("workspace"), model, selection);
const table = new RobotTable(element("robots"), selection);
const selected = new SelectedRobot(model, selection, (order) => live.send(order));
const pointer = new Pointer(workspace, model, selection, selected);
const controls = new Controls((order) => live.send(order), selection);
const halt = new Halt((order) => live.send(order));
const plots = [
  new Plot(element("clearance"), element("clearance-now"), model, {
    pick: (point) => point[1] * 1000, unit: " mm", digits: 1, floor: 0, zero: "contact",
  }),
  new Plot(element("potential"), element("potential-now"), model, {
    pick: (point) => point[2], unit: "", digits: 2, floor: 0,
  }),
];

const live = new Live({
  welcome(welcome) {
    selected.allow(welcome.may_steer);
    halt.allow(welcome.may_steer);
  },
  overview(overview) {
    model.begin(overview);
    table.begin(model);
    controls.begin(overview);
    selection.keep(model.robots);
    redraw();
  },
  frame(frame) {
    model.take(frame, performance.now());
    table.show(model);
    controls.show(frame);
    halt.show(frame);
    selected.show();
    pointer.show();
    showFigures(frame, model);
    redraw();
  },
  lost() {
    controls.lost();
    selected.allow(false);
    halt.allow(false);
    showFigures(null, model);
  },
  answer(answer) {
    if ("halt" in answer.asked || "release" in answer.asked) halt.answered(answer.text);
    else selected.answered({ ...answer.asked.goal, ...answer });
  },
  refused: (refusal) => controls.refused(refusal.text),
});

selection.addEventListener("change", () => {
  table.show(model);
  selected.show();
  pointer.show();
  workspace.wake();
});

function redraw() {
  workspace.wake();
  plots.forEach((plot) => plot.wake());
}

followTheme(element("theme"), redraw);
new ResizeObserver(redraw).observe(document.body);
live.open();
