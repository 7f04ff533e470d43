// The selected robot and the one under the pointer; panels and drawings follow their changes.
export class Selection extends EventTarget {
  constructor() {
    super();
    this.selected = null; // id
    this.pointed = null;
  }

  select(id) {
    this.become({ selected: id });
  }

  toggle(id) {
    this.select(this.selected === id ? null : id);
  }

  point(id) {
    this.become({ pointed: id });
  }

  // Absent robots can be neither.
  keep(robots) {
    const known = (id) => (robots.some((robot) => robot.id === id) ? id : null);
    this.become({ selected: known(this.selected), pointed: known(this.pointed) });
  }

  become(next) {
    if (Object.entries(next).every(([name, id]) => this[name] === id)) return;
    Object.assign(this, next);
    this.dispatchEvent(new Event("change"));
  }
}
