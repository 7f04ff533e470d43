// The websocket: overviews and frames come in, steering goes out; opened again when it breaks.
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
