// WebSocket: distributes messages, reports a lost connection, and reconnects.

const WAITS = [500, 1000, 2000, 3000]; // ms until the next attempt
const UNSENT = "Not connected: nothing was sent.";

class Link {
  constructor(live) {
    this.live = live;
    this.failed = 0;
    this.lost = document.getElementById("lost");
    this.open();
  }

  open() {
    const { protocol, host, pathname, search } = location;
    this.socket = new WebSocket(`${protocol === "https:" ? "wss" : "ws"}://${host}${pathname}${search}`);
    this.socket.addEventListener("open", () => {
      this.failed = 0;
      this.lost.hidden = true;
      document.body.classList.remove("lost");
    });
    this.socket.addEventListener("message", (event) => this.live.receive(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => this.again());
  }

  again() {
    const wait = WAITS[Math.min(this.failed, WAITS.length - 1)];
    this.failed += 1;
    this.lost.hidden = false;
    const why = this.failed > 3 ? "The connection is lost, and cdpr gui does not answer: it may have ended." : "The connection is lost.";
    setText(this.lost, `${why} Trying again …`);
    document.body.classList.add("lost");
    setTimeout(() => this.open(), wait);
  }

  // Return whether a message was sent; nothing is queued. Files follow a line feed, as bytes.
  send(message, files) {
    if (this.socket.readyState !== WebSocket.OPEN) {
      this.live.note("error", UNSENT);
      return false;
    }
    const text = JSON.stringify(message);
    this.socket.send(files ? new Blob([text, "\n", ...files]) : text);
    return true;
  }
}
