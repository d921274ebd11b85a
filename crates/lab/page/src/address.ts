// The part of the address after `#` holds the whole set-up, so that a link repeats it.

import type { Setup } from "./messages";

export interface State {
  panes: Setup[];
  rate: number;
  wait: boolean;
  /** The lesson that is open. */
  lesson?: string;
  /** Whether a reference solution is laid over the panes. */
  ghost: boolean;
  /** Whether the cloth goes on after a change, where it can. */
  keep: boolean;
}

const NUMBERS = ["stiffness", "damping", "step", "duration", "particles", "gravity"] as const;

/** The set-up with which the lab opens: one method explodes, one stands still, one falls. */
export function opening(): State {
  const pane = (method: string): Setup => ({
    scene: "hanging-textile-1e6",
    method,
    step: 0.01,
    duration: 2,
  });
  return {
    panes: ["explicit-euler", "imex-euler", "imex-updated"].map(pane),
    rate: 0.5,
    wait: true,
    ghost: false,
    keep: false,
  };
}

/**
 * One `pane` for each pane, with the values that differ from its scene, and `rate`, `wait`, `ghost`
 * and `keep`. Of a scene from a file the text holds only the name.
 */
export function write(state: State): string {
  const query = new URLSearchParams();
  query.set("rate", String(state.rate));
  if (!state.wait) query.set("wait", "no");
  if (state.lesson !== undefined) query.set("lesson", state.lesson);
  if (state.ghost) query.set("ghost", "yes");
  if (state.keep) query.set("keep", "yes");
  for (const setup of state.panes) {
    const parts = [`scene=${encodeURIComponent(setup.scene)}`, `method=${setup.method}`];
    for (const key of NUMBERS) {
      const value = setup[key];
      if (value !== undefined) parts.push(`${key}=${value}`);
    }
    if (setup.wind !== undefined) parts.push(`wind=${setup.wind.join(",")}`);
    query.append("pane", parts.join(";"));
  }
  return query.toString();
}

/** A name as it was; a text that is no such name stays as it is. */
function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/**
 * Reads a text that `write` wrote; undefined if it names neither panes nor a lesson. A lesson
 * without panes opens its own panes.
 */
export function read(text: string): State | undefined {
  const query = new URLSearchParams(text.replace(/^#/, ""));
  const panes: Setup[] = [];
  for (const part of query.getAll("pane")) {
    const pairs = new Map<string, string>();
    for (const pair of part.split(";")) {
      const at = pair.indexOf("=");
      if (at > 0) pairs.set(pair.slice(0, at), pair.slice(at + 1));
    }
    const setup: Setup = { scene: decoded(pairs.get("scene") ?? ""), method: pairs.get("method") ?? "" };
    for (const key of NUMBERS) {
      const value = pairs.get(key);
      if (value !== undefined && Number.isFinite(Number(value))) setup[key] = Number(value);
    }
    const wind = pairs.get("wind")?.split(",").map(Number) ?? [];
    const [x, y, z] = wind;
    if (wind.length === 3 && wind.every(Number.isFinite)) setup.wind = [x ?? 0, y ?? 0, z ?? 0];
    panes.push(setup);
  }
  const lesson = query.get("lesson") ?? undefined;
  if (panes.length === 0 && lesson === undefined) return undefined;
  const rate = Number(query.get("rate") ?? 1);
  return {
    panes,
    rate: rate > 0 && Number.isFinite(rate) ? rate : 1,
    wait: query.get("wait") !== "no",
    ...(lesson === undefined ? {} : { lesson }),
    ghost: query.get("ghost") === "yes",
    keep: query.get("keep") === "yes",
  };
}
