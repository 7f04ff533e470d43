// The websocket: overviews, frames and answers come in, steering and orders go out; opened again when it breaks.
// The token that lets this page steer stands after the # of its address.
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
