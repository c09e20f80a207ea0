// The WebSocket: requests out, frames and figures in; comes back by itself when the server does.

const RETRY_MS = 1000;
/** The status by which a server says that it does not know this browser. */
const UNKNOWN = 401;

export class Link {
  /** handlers: by a message's type; `frame` for frames, `open` and `closed` for the link itself. */
  constructor(handlers) {
    this.handlers = handlers;
    this.key = "";
    this.connect();
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/ws`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.handlers.open?.();
    socket.onclose = () => {
      this.handlers.closed?.({ known: true });
      this.comeBackLater();
    };
    let newest = 0; // of the frames shown: two may be decoded at once, and end in either order
    const isNewer = ({ sequence }) => {
      if (socket !== this.socket || sequence <= newest) return false;
      newest = sequence;
      return true;
    };
    socket.onmessage = (event) => {
      if (event.data instanceof ArrayBuffer) this.receiveFrame(event.data, isNewer);
      else this.receive(JSON.parse(event.data));
    };
    this.socket = socket;
  }

  comeBackLater() { setTimeout(() => this.comeBack(), RETRY_MS); }

  /** A server that was started anew at an address with tokens knows nobody; a WebSocket would not say so. */
  async comeBack() {
    try {
      const answer = await fetch("icon.svg", { cache: "no-store" });
      if (answer.ok) return this.connect();
      this.handlers.closed?.({ known: answer.status !== UNKNOWN });
    } catch {
      this.handlers.closed?.({ known: true }); // nobody is there
    }
    this.comeBackLater();
  }

  receive(message) {
    if (message.type === "hello") this.key = message.key;
    this.handlers[message.type]?.(message);
  }

  /** See frame.rs for the layout. Decoding frees the server to send the next; what is not newer is not shown. */
  async receiveFrame(buffer, isNewer) {
    try {
      const view = new DataView(buffer);
      const [sequence, input, width, height, count] = [4, 8, 12, 16, 20].map((at) => view.getUint32(at, true));
      const bitmaps = [];
      for (let i = 0, at = 24; i < count; i++) {
        const length = view.getUint32(at, true);
        const jpeg = new Blob([new Uint8Array(buffer, at + 4, length)], { type: "image/jpeg" });
        bitmaps.push(await createImageBitmap(jpeg));
        at += 4 + length;
      }
      const frame = { sequence, input, width, height, bitmaps };
      if (isNewer(frame)) this.handlers.frame?.(frame);
      else bitmaps.forEach((bitmap) => bitmap.close());
    } finally {
      this.send({ type: "decoded" });
    }
  }

  send(request) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }

  /** Sends a file to an upload. */
  async upload(batch, path, file) {
    const place = path.split("/").map(encodeURIComponent).join("/");
    const headers = { "x-midway-key": this.key };
    const answer = await fetch(`upload/${batch}/${place}`, { method: "PUT", headers, body: file });
    if (!answer.ok) throw new Error(await answer.text());
  }

  /** Fetches the picture and hands it to the browser as a download. */
  async save(format, name) {
    const answer = await fetch(`save/${format}`);
    if (!answer.ok) throw new Error(await answer.text());
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await answer.blob());
    link.download = `${name}.${format}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }
}
