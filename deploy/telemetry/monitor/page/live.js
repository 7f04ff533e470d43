// The WebSocket: overviews, frames and answers in, steering and orders out; reconnects after a failure.
// The token that permits steering follows the # of the address.
const RETRY = 1000; // ms

export class Live {
  constructor(handlers) {
    this.handlers = handlers;
    this.socket = null;
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(`${scheme}//${location.host}/live?token=${encodeURIComponent(location.hash.slice(1))}`);
    this.socket.onmessage = (event) => {
      const news = JSON.parse(event.data);
      this.handlers[news.kind](news);
    };
    this.socket.onclose = () => {
      this.handlers.lost();
      setTimeout(() => this.open(), RETRY);
    };
  }

  send(order) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(order));
  }
}
