// The WebSocket to the server: it connects again by itself, and hands over messages.
import { ofTab } from "./storage.js";

const firstRetryMs = 250, longestRetryMs = 8000;

/** Below a proxy, viewers with tokens of their own have the same origin. */
const tokenKey = () => `rhoray-token:${location.pathname}`;
let token = null;

/**
 * Takes the token out of the URL, so that no copied link contains it, and keeps it for this tab;
 * where the browser blocks storage, until the page is loaded again.
 */
export function takeToken() {
  const items = location.hash.slice(1).split("&");
  const given = items.find((item) => item.startsWith("token="));
  if (!given) return;
  token = given.slice("token=".length).replace(/[^0-9a-f]/g, "");  // a WebSocket refuses other letters
  ofTab.set(tokenKey(), token);
  const rest = items.filter((item) => item !== given).join("&");
  history.replaceState(null, "", `${location.pathname}${rest && `#${rest}`}`);
}

export class Connection {
  /**
   * @param listeners  onOpen(), onMessage(object), onPicture(buffer, socket), onLost(ms to the next
   * try), onRefused() if the server is there and does not let this page in
   */
  constructor(listeners) {
    Object.assign(this, listeners, { retryMs: firstRetryMs, isClosed: false });
    this.connect();
  }

  /** Sends an object; returns false without a connection. */
  send(message) {
    const isOpen = this.socket.readyState === WebSocket.OPEN;
    if (isOpen) this.socket.send(JSON.stringify(message));
    return isOpen;
  }

  close() {
    this.isClosed = true;
    clearTimeout(this.timer);
    this.socket.close();
  }

  connect() {
    const url = new URL("ws", location.href);
    url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    token ??= ofTab.get(tokenKey());
    let wasOpen = false;
    const socket = new WebSocket(url, token ? ["rhoray.1", token] : ["rhoray.1"]);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.retryMs = firstRetryMs;
      wasOpen = true;
      this.onOpen();
    };
    socket.onmessage = ({ data }) => {
      if (this.isClosed) return;
      if (typeof data === "string") this.onMessage(JSON.parse(data));
      else this.onPicture(data, socket);
    };
    socket.onclose = () => {
      if (this.isClosed) return;
      this.onLost(this.retryMs);
      if (!wasOpen) this.#askWhetherItIsThere();
      this.timer = setTimeout(() => this.connect(), this.retryMs);
      this.retryMs = Math.min(longestRetryMs, 2 * this.retryMs);
    };
  }

  #askWhetherItIsThere() {
    const refuse = ({ ok }) => { if (ok && !this.isClosed) this.onRefused(); };
    fetch("./", { method: "HEAD" }).then(refuse, () => {});
  }
}
