// Runs the engine in a page that needs no server. `wasm/src/lib.rs` of the crate is the other side.

import type { Asked, Told } from "./link";

/** Time between two looks at the panes, ms. */
const TICK = 33;
/** How long the panes may work in one of them, ms. */
const SHARE = 27;

interface Engine {
  memory: WebAssembly.Memory;
  _initialize?(): void;
  room(bytes: number): number;
  hear_text(): void;
  hear_file(): void;
  tick(elapsed: number, share: number): void;
  next(): number;
  start(): number;
  length(): number;
  source(): void;
}

/** Says that a function of the system does not exist (WASI's NOSYS). */
const MISSING = 52;

/** What the engine asks of a system: clocks, random numbers, and a place for its last words. */
function system(memory: () => DataView, say: (text: string) => void): WebAssembly.ModuleImports {
  const known: Record<string, (...numbers: never[]) => number> = {
    clock_time_get: (_clock: number, _precision: bigint, at: number) => {
      memory().setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true);
      return 0;
    },
    random_get: (at: number, length: number) => {
      crypto.getRandomValues(new Uint8Array(memory().buffer as ArrayBuffer, at, length));
      return 0;
    },
    fd_write: (_file: number, parts: number, count: number, written: number) => {
      let sum = 0;
      for (let part = 0; part < count; part++) {
        const view = memory();
        const [at, length] = [0, 4].map((o) => view.getUint32(parts + 8 * part + o, true));
        const bytes = new Uint8Array(view.buffer as ArrayBuffer, at, length);
        say(new TextDecoder().decode(bytes));
        sum += bytes.length;
      }
      memory().setUint32(written, sum, true);
      return 0;
    },
    environ_sizes_get: (count: number, size: number) => {
      memory().setUint32(count, 0, true);
      memory().setUint32(size, 0, true);
      return 0;
    },
    environ_get: () => 0,
  };
  return new Proxy(known, { get: (known, name) => known[String(name)] ?? (() => MISSING) }) as never;
}

const tell = (told: Told, moved: Transferable[] = []): void => postMessage(told, { transfer: moved });

let engine: Engine | undefined;
let waiting: Asked[] = [];
let lastWords = "";

/** Gives the engine a message. */
function give(engine: Engine, asked: Asked): void {
  if (asked.kind === "engine") return;
  const isText = asked.kind === "text";
  const bytes = isText ? new TextEncoder().encode(asked.text) : new Uint8Array(asked.bytes);
  const at = engine.room(bytes.length);
  new Uint8Array(engine.memory.buffer, at, bytes.length).set(bytes);
  if (isText) engine.hear_text();
  else engine.hear_file();
}

function present({ memory, start, length }: Engine): Uint8Array<ArrayBuffer> {
  const [at, bytes] = [start(), length()];
  return new Uint8Array(memory.buffer as ArrayBuffer).slice(at, at + bytes);
}

const readText = (bytes: Uint8Array<ArrayBuffer>): string => new TextDecoder().decode(bytes);

/** Passes on what the engine tells. */
function pass(engine: Engine): void {
  for (let kind = engine.next(); kind !== 0; kind = engine.next()) {
    const bytes = present(engine);
    if (kind === 1) tell({ kind: "text", text: readText(bytes) });
    else tell({ kind: "bytes", bytes: bytes.buffer }, [bytes.buffer]);
  }
}

/** Does something that a bug in the engine may end. */
function guarded(act: (engine: Engine) => void): void {
  if (engine === undefined) return;
  try {
    act(engine);
  } catch (error) {
    engine = undefined;
    const cause = lastWords === "" ? String(error) : lastWords.trim();
    const sentence = `The engine failed by a bug in drape; please report it, and load this page again. It said: ${cause}`;
    tell({ kind: "failed", sentence });
  }
}

async function begin(bytes: ArrayBuffer): Promise<void> {
  const say = (text: string): void => void (lastWords += text);
  let memory: WebAssembly.Memory | undefined;
  const view = (): DataView => new DataView(memory?.buffer ?? new ArrayBuffer(0));
  const imports = { wasi_snapshot_preview1: system(view, say) };
  const { instance } = await WebAssembly.instantiate(bytes, imports);
  const made = instance.exports as unknown as Engine;
  memory = made.memory;
  engine = made;
  guarded(() => made._initialize?.());
  guarded(() => {
    made.source();
    tell({ kind: "source", text: readText(present(made)) });
  });
  for (const asked of waiting) guarded((engine) => give(engine, asked));
  waiting = [];
  let last = performance.now();
  const turn = (): void => {
    const now = performance.now();
    guarded((engine) => {
      engine.tick(now - last, SHARE);
      pass(engine);
    });
    last = now;
    if (engine !== undefined) setTimeout(turn, Math.max(0, TICK - (performance.now() - now)));
  };
  turn();
}

addEventListener("message", ({ data }: MessageEvent<Asked>) => {
  if (data.kind === "engine")
    begin(data.bytes).catch((error: unknown) =>
      tell({ kind: "failed", sentence: `The engine of the lab does not start: ${String(error)}` }),
    );
  else if (engine === undefined) waiting.push(data);
  else
    guarded((engine) => {
      give(engine, data);
      pass(engine);
    });
});
