// A canvas at the resolution of the screen, drawn at most once per refresh, in the colours of the theme.
export class Painted {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.waiting = false;
  }

  wake() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => {
      this.waiting = false;
      this.fit();
      this.style = getComputedStyle(document.documentElement);
      if (this.draw(now)) this.wake();
    });
  }

  fit() {
    const { width, height } = this.canvas.getBoundingClientRect();
    const scale = window.devicePixelRatio || 1;
    const [wide, high] = [Math.round(width * scale), Math.round(height * scale)];
    if (this.canvas.width !== wide || this.canvas.height !== high) Object.assign(this.canvas, { width: wide, height: high });
    this.width = width;
    this.height = height;
    this.context.setTransform(scale, 0, 0, scale, 0, 0);
    this.context.clearRect(0, 0, width, height);
  }

  colour(name) {
    return this.style.getPropertyValue(`--${name}`).trim();
  }

  font(size, weight = 400) {
    return `${weight} ${size}px ${this.colour("sans")}`;
  }
}
