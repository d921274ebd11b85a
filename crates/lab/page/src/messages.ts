// The messages between page and server; `src/messages.rs` of the crate is the other side.

export interface Setup {
  scene: string;
  method: string;
  stiffness?: number;
  damping?: number;
  step?: number;
  duration?: number;
  particles?: number;
  gravity?: number;
  wind?: [number, number, number];
}

export type Range = [number, number];

export interface SceneChoice {
  name: string;
  description: string;
  step: number;
  duration: number;
  stiffness: number | null;
  damping: number | null;
  particles: number | null;
  gravity: number;
  wind: [number, number, number];
}

export interface SettingChoice {
  key: string;
  default: string;
  allowed: string;
  help: string;
  values:
    | { kind: "number"; range: Range; is_optional: boolean; is_whole: boolean }
    | { kind: "word"; words: string[] };
}

export interface MethodChoice {
  id: string;
  name: string;
  theory: string;
  has_lesson: boolean;
  presets: { name: string; settings: [string, string][] }[];
  settings: SettingChoice[];
}

export interface Limits {
  panes: number;
  particles: Range;
  stiffness: Range;
  damping: Range;
  step: Range;
  duration: Range;
  rate: Range;
  gravity: Range;
  wind: Range;
  mesh_bytes: number;
  file_bytes: number;
}

export interface Hello {
  tell: "hello";
  version: string;
  scenes: SceneChoice[];
  methods: MethodChoice[];
  limits: Limits;
}

export interface Solid {
  points: [number, number, number][];
  triangles: number[];
  is_endless: boolean;
  is_moving: boolean;
}

export interface Scenery {
  tell: "scenery";
  pane: number;
  run: number;
  particles: number;
  /** Lowest and highest coordinates of the particles at the start, m. */
  extent: [[number, number, number], [number, number, number]];
  triangles: number[];
  lines: number[];
  pins: number[];
  solids: Solid[];
  step: number;
  duration: number;
  method: string;
}

export interface Numbers {
  step: number;
  time: number;
  /** Energy by kind, J; the last is the total. A number that is not finite comes as null. */
  energy: [string, number | null][];
  causes: Record<string, number | null> | null;
  stretch: number | null;
  momentum: [number | null, number | null, number | null];
  angular_momentum: [number | null, number | null, number | null];
  cg_iterations: number;
  all_cg_iterations: number;
  micros: number;
  times_real_time: number;
  theta: number;
  offsets: [number, number, number][];
}

export interface Status {
  tell: "status";
  pane: number;
  run: number;
  phase:
    | { kind: "preparing" | "ready" | "ended" | "diverged" }
    | { kind: "refused"; sentence: string };
  numbers: Numbers;
  verdict: {
    kind: string;
    is_final: boolean;
    reason: string;
    why: string;
    decides: string;
  } | null;
  behind: number;
  /** Root mean square distance of the particles from the reference, m. */
  distance: number | null;
  /** Why there is no reference, if one was asked for. */
  ghost: string | null;
}

export interface Clock {
  tell: "clock";
  time: number;
  playing: boolean;
  rate: number;
  wait: boolean;
}

export interface Repeat {
  tell: "repeat";
  pane: number;
  repeat: {
    command: string;
    arguments: string[];
    file: string | null;
    mesh: string | null;
    scene: string;
    note: string;
    way: { command: string; arguments: string[]; file: string; scene: string } | null;
  };
}

/** A file was taken. */
export interface Dropped {
  tell: "dropped";
  scene: SceneChoice;
  notes: string[];
}

export interface Lesson {
  id: string;
  title: string;
  idea: string;
  equation: string;
  equation_file: string;
  code: string;
  code_file: string;
  /** Step size, s, and the factor by which a step multiplies the motion. */
  radii: [number, number][];
  panes: Setup[];
  question: string;
  unit: string;
  way: string;
  attempt: string;
  repeat: string;
  file: string | null;
  docs: string;
  study: string;
}

export type LessonReply =
  | { tell: "lessons"; lessons: { id: string; title: string }[] }
  | { tell: "lesson"; lesson: Lesson }
  | { tell: "marked"; lesson: string; right: boolean; sentence: string };

export type LessonRequest =
  | { do: "lessons" }
  | { do: "lesson"; id: string }
  | { do: "answer"; lesson: string; value: number };

export type Reply =
  | Hello
  | LessonReply
  | Scenery
  | Status
  | Clock
  | Repeat
  | Dropped
  | { tell: "refused"; sentence: string };

export type Request =
  | LessonRequest
  | { do: "open"; panes: Setup[]; keep: boolean }
  | { do: "play" }
  | { do: "pause" }
  | { do: "step" }
  | { do: "restart" }
  | { do: "rate"; rate: number }
  | { do: "wait"; wait: boolean }
  | { do: "repeat"; pane: number }
  | { do: "lead"; particle: number; by: [number, number, number] }
  | { do: "let_go" }
  | { do: "ghost"; on: boolean };

/** Positions of a pane. */
export interface Frame {
  pane: number;
  run: number;
  /** Whether they are those of the reference. */
  isGhost: boolean;
  time: number;
  /** x, y, z of each particle, m. */
  positions: Float32Array;
}

/** Reads a binary message; undefined if it is not whole. */
export function readFrame(bytes: ArrayBuffer): Frame | undefined {
  if (bytes.byteLength < 24) return undefined;
  const view = new DataView(bytes);
  const count = view.getUint32(8, true);
  if (bytes.byteLength !== 24 + 12 * count) return undefined;
  const positions = new Float32Array(3 * count);
  for (let i = 0; i < positions.length; i++) positions[i] = view.getFloat32(24 + 4 * i, true);
  return {
    pane: view.getUint32(0, true),
    run: view.getUint32(4, true),
    isGhost: view.getUint32(12, true) === 1,
    time: view.getFloat64(16, true),
    positions,
  };
}
