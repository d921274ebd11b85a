// The connection to the engine of the lab: a server, or a worker of this page.

import { byId } from "./dom";

/** The messages that the page sends. */
export interface Link {
  text(request: string): void;
  bytes(file: Uint8Array<ArrayBuffer>): void;
  /** The address of the line of the source that decides a verdict. */
  place(decides: string): string;
}

/** The messages that the page gets. */
export interface Ears {
  text(message: string): void;
  bytes(message: ArrayBuffer): void;
  complain(sentence: string): void;
}

/** Time between two attempts to reach a server that is gone, ms. */
const AGAIN = 2000;

/** The messages of the worker to the page. */
export type Told =
  | { kind: "text"; text: string }
  | { kind: "bytes"; bytes: ArrayBuffer }
  | { kind: "source"; text: string }
  | { kind: "failed"; sentence: string };

/** The messages of the page to the worker. */
export type Asked =
  | { kind: "engine"; bytes: ArrayBuffer }
  | { kind: "text"; text: string }
  | { kind: "bytes"; bytes: ArrayBuffer };

/** The engine that a page holds, or else the server that gave the page. */
export function connect(ears: Ears): Link {
  const engine = document.getElementById("engine");
  return engine === null ? new Server(ears) : new Inside(engine, ears);
}

/** The server that gave the page. */
class Server implements Link {
  private socket: WebSocket | undefined;

  constructor(private ears: Ears) {
    this.open();
  }

  private open(): void {
    const url = new URL("socket", location.href);
    url.protocol = "ws:";
    url.hash = "";
    const socket = new WebSocket(url);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("message", (event: MessageEvent<string | ArrayBuffer>) => {
      if (typeof event.data === "string") this.ears.text(event.data);
      else this.ears.bytes(event.data);
    });
    socket.addEventListener("close", () => {
      this.ears.complain(
        "The lab does not answer. Is `drape lab` still running? Trying again. " +
          "If you started it anew, open the address that it printed.",
      );
      setTimeout(() => this.open(), AGAIN);
    });
    this.socket = socket;
  }

  text(request: string): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(request);
  }

  bytes(file: Uint8Array<ArrayBuffer>): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(file);
  }

  place(decides: string): string {
    return decides;
  }
}

/** The engine that the page holds: packed WebAssembly, run by a worker. */
class Inside implements Link {
  private worker: Worker;
  private source = "";

  constructor(engine: HTMLElement, ears: Ears) {
    const code = new Blob([byId("worker").textContent ?? ""], { type: "text/javascript" });
    this.worker = new Worker(URL.createObjectURL(code));
    this.worker.addEventListener("message", ({ data }: MessageEvent<Told>) => {
      if (data.kind === "text") ears.text(data.text);
      else if (data.kind === "bytes") ears.bytes(data.bytes);
      else if (data.kind === "failed") ears.complain(data.sentence);
      else this.source = URL.createObjectURL(new Blob([styled(data.text)], { type: "text/html" }));
    });
    const fail = (error: unknown): void =>
      ears.complain(`This browser cannot run the engine of the lab: ${String(error)}`);
    unpack(engine.textContent ?? "").then((bytes) => {
      this.worker.postMessage({ kind: "engine", bytes } satisfies Asked, [bytes]);
      // The page keeps no copy.
      engine.textContent = "";
    }, fail);
  }

  text(text: string): void {
    this.worker.postMessage({ kind: "text", text } satisfies Asked);
  }

  bytes(file: Uint8Array<ArrayBuffer>): void {
    this.worker.postMessage({ kind: "bytes", bytes: file.slice().buffer } satisfies Asked);
  }

  place(decides: string): string {
    const line = decides.split("#")[1];
    return this.source === "" || line === undefined ? "" : `${this.source}#${line}`;
  }
}

/** A page that asks a server for its style, with the style of this page. */
function styled(page: string): string {
  const style = document.querySelector("style")?.outerHTML ?? "";
  return page.replace(/<link rel="stylesheet"[^>]*>/, () => style);
}

/** Bytes from base64 of their gzip form. */
async function unpack(text: string): Promise<ArrayBuffer> {
  const packed = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const bytes = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(bytes).arrayBuffer();
}
