// The websocket: overviews and frames come in, steering goes out; opened again when it breaks.
const RETRY = 1000; // ms

export class Live {
  constructor(handlers) {
    this.handlers = handlers;
    this.socket = null;
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(`${scheme}//${location.host}/live`);
    this.socket.onmessage = (event) => this.receive(JSON.parse(event.data));
    this.socket.onclose = () => {
      this.handlers.lost();
      setTimeout(() => this.open(), RETRY);
    };
  }

  receive(news) {
    if (news.kind === "refused") this.handlers.refused(news.text);
    else this.handlers[news.kind](news);
  }

  send(order) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(order));
  }
}
