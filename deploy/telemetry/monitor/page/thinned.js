// The past of a run in bounded memory: when full, every second entry is deleted.
export class Thinned {
  constructor(limit, items = [], merge = (_, later) => later) {
    this.limit = limit;
    this.merge = merge;
    this.items = items.slice();
    this.stride = 1;
    this.count = 0;
  }

  append(item) {
    const last = this.items.length - 1;
    if (this.count % this.stride && last >= 0) this.items[last] = this.merge(this.items[last], item);
    else this.items.push(item);
    this.count += 1;
    if (this.items.length > this.limit) this.halve();
  }

  halve() {
    const kept = [];
    for (let i = 0; i + 1 < this.items.length; i += 2) kept.push(this.merge(this.items[i], this.items[i + 1]));
    if (this.items.length % 2) kept.push(this.items.at(-1));
    this.items = kept;
    this.stride *= 2;
    this.count = 0;
  }
}
