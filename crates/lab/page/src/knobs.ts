// Knobs: one set for all panes together, and the same set for each pane. The knobs of methods
// follow from the settings that each method declares.

import { make, short } from "./dom";
import type { Hello, Range, SceneChoice, SettingChoice, Setup } from "./messages";
import { isSame as isSameValue, methodOf, valueOf, withSetting } from "./methods";

/** What a knob does to a set-up, as it stands by then. */
export type Turn = (setup: Setup) => Setup;

type NumberKey = "stiffness" | "damping" | "step" | "duration" | "particles" | "gravity";

/** A setting whose range spans this factor has a logarithmic slider. */
const WIDE = 1e3;
/** Where the slider of a setting that may be 0 begins. */
const LEAST = 1e-16;
/** Whether the settings of all panes are unfolded. */
let isUnfolded = false;

interface NumberKnob {
  key: NumberKey;
  label: string;
  limits: (hello: Hello) => Range;
  /** What the scene has. */
  usual: (scene: SceneChoice) => number | null;
  isLogarithmic: boolean;
  isWhole?: boolean;
}

const NUMBERS: NumberKnob[] = [
  {
    key: "stiffness",
    label: "Stiffness k/m, 1/s²",
    limits: (hello) => hello.limits.stiffness,
    usual: (scene) => scene.stiffness,
    isLogarithmic: true,
  },
  {
    key: "damping",
    label: "Damping d/m, 1/s",
    limits: (hello) => hello.limits.damping,
    usual: (scene) => scene.damping,
    isLogarithmic: false,
  },
  {
    key: "step",
    label: "Time step h, s",
    limits: (hello) => hello.limits.step,
    usual: (scene) => scene.step,
    isLogarithmic: true,
  },
  {
    key: "duration",
    label: "Simulated time, s",
    limits: (hello) => hello.limits.duration,
    usual: (scene) => scene.duration,
    isLogarithmic: false,
  },
  {
    key: "particles",
    label: "Particles a side",
    limits: (hello) => hello.limits.particles,
    usual: (scene) => scene.particles,
    isLogarithmic: false,
    isWhole: true,
  },
  {
    key: "gravity",
    label: "Gravity, m/s²",
    limits: (hello) => hello.limits.gravity,
    usual: (scene) => scene.gravity,
    isLogarithmic: false,
  },
];

let last = 0;

function labelled(label: string, input: HTMLElement, more: Node[] = [], kind = ""): HTMLElement {
  input.id = `knob-${++last}`;
  return make("div", { class: kind }, make("label", { for: input.id }, label), input, ...more);
}

/**
 * Knobs for some panes. They call `change` with a person's change, and `complain` with a sentence
 * if a value is out of its range. Knobs for all panes fold the settings of the methods.
 */
export function knobs(
  hello: Hello,
  setups: Setup[],
  change: (turn: Turn) => void,
  complain: (sentence: string) => void,
  isShared: boolean,
): HTMLElement {
  const box = make("div", { class: "knobs" });
  const first = setups[0];
  if (first === undefined) return box;
  const scenes = new Map(hello.scenes.map((scene) => [scene.name, scene]));

  const scene = make("select");
  if (setups.some((setup) => setup.scene !== first.scene))
    scene.append(make("option", { value: "" }, "differs"));
  for (const { name } of hello.scenes) scene.append(make("option", { value: name }, name));
  scene.dataset.knob = "scene";
  scene.value = setups.every((setup) => setup.scene === first.scene) ? first.scene : "";
  scene.addEventListener("change", () => {
    if (scene.value === "") return;
    // Another scene has its own stiffness, steps and so on.
    change((setup) => ({ scene: scene.value, method: setup.method }));
  });
  box.append(labelled("Scene", scene, [], "wide"));

  if (setups.length === 1) {
    const list = make("datalist", { id: `methods-${++last}` });
    for (const method of hello.methods) {
      list.append(make("option", { value: method.id }, method.name));
      for (const { name } of method.presets)
        list.append(make("option", { value: `${method.id}:${name}` }));
    }
    const method = make("input", {
      list: list.id,
      spellcheck: "false",
      autocomplete: "off",
      value: first.method,
    });
    method.dataset.knob = "method";
    method.addEventListener("change", () => change((setup) => ({ ...setup, method: method.value.trim() })));
    box.append(labelled("Method and settings", method, [list], "wide"));
  }

  for (const knob of NUMBERS) {
    const value = (setup: Setup): number | null => {
      const known = scenes.get(setup.scene);
      return setup[knob.key] ?? (known === undefined ? null : knob.usual(known));
    };
    const values = setups.map(value);
    const isSame = values.every((other) => other === values[0]);
    const [least, most] = knob.limits(hello);
    const now = values[0] ?? null;
    const input = make("input", { inputmode: "decimal", spellcheck: "false", autocomplete: "off" });
    input.dataset.knob = knob.key;
    if (isSame && now !== null) input.value = String(now);
    else input.placeholder = isSame ? "not in this scene" : "differs";
    input.disabled = values.some((other) => other === null);
    const take = (number: number): void => {
      const isFit =
        Number.isFinite(number) &&
        number >= least &&
        number <= most &&
        !(knob.isWhole && !Number.isInteger(number));
      input.setAttribute("aria-invalid", String(!isFit));
      if (isFit) change((setup) => ({ ...setup, [knob.key]: number }));
      else complain(`${knob.label}: expected a number from ${short(least)} to ${short(most)}.`);
    };
    input.addEventListener("change", () =>
      take(input.value.trim() === "" ? NaN : Number(input.value)),
    );
    const more: Node[] = [];
    if (knob.isLogarithmic && now !== null) {
      more.push(slider(knob.key, knob.label, input, now, [least, most], take));
    }
    box.append(labelled(knob.label, input, more));
  }
  box.append(wind(hello, setups, change, complain));
  const settings = settingKnobs(hello, setups, change, complain, isShared);
  if (settings === undefined) return box;
  if (!isShared) return make("div", {}, box, settings);
  const folded = make("details", {}, make("summary", {}, "Settings of the methods"), settings);
  folded.dataset.knob = "settings";
  folded.open = isUnfolded;
  folded.addEventListener("toggle", () => (isUnfolded = folded.open));
  return make("div", {}, box, folded);
}

/** A logarithmic slider for a number input. */
function slider(
  key: string,
  label: string,
  input: HTMLInputElement,
  now: number,
  [least, most]: Range,
  take: (value: number) => void,
): HTMLInputElement {
  const slider = make("input", {
    type: "range",
    min: String(Math.log10(least)),
    max: String(Math.log10(most)),
    step: "0.25",
    "aria-label": `${label}, as a slider`,
  });
  slider.dataset.knob = `${key}-slider`;
  slider.value = String(Math.log10(Math.max(now, least)));
  const rounded = (): number => Number((10 ** Number(slider.value)).toPrecision(2));
  slider.addEventListener("input", () => (input.value = String(rounded())));
  slider.addEventListener("change", () => take(Math.min(most, Math.max(least, rounded()))));
  return slider;
}

/** The velocity of the air: three numbers in one input. */
function wind(
  hello: Hello,
  setups: Setup[],
  change: (turn: Turn) => void,
  complain: (sentence: string) => void,
): HTMLElement {
  const values = setups.map(
    (setup) =>
      setup.wind ?? hello.scenes.find((scene) => scene.name === setup.scene)?.wind ?? [0, 0, 0],
  );
  const input = make("input", { spellcheck: "false", autocomplete: "off" });
  input.dataset.knob = "wind";
  const text = values[0]?.join(", ") ?? "";
  if (values.every((other) => other.join(", ") === text)) input.value = text;
  else input.placeholder = "differs";
  const [least, most] = hello.limits.wind;
  input.addEventListener("change", () => {
    const found = input.value.split(/[,;\s]+/).filter((word) => word !== "").map(Number);
    const [x, y, z] = found;
    const isIn = (value: number): boolean => value >= least && value <= most;
    const isFit = found.length === 3 && found.every(isIn);
    input.setAttribute("aria-invalid", String(!isFit));
    if (isFit && x !== undefined && y !== undefined && z !== undefined)
      change((setup) => ({ ...setup, wind: [x, y, z] }));
    else complain(`Wind: expected three numbers from ${least} to ${most}: x, y, z.`);
  });
  return labelled("Wind x, y, z, m/s", input);
}

/** A knob for each setting that one of the methods declares; undefined if none does. */
function settingKnobs(
  hello: Hello,
  setups: Setup[],
  change: (turn: Turn) => void,
  complain: (sentence: string) => void,
  isShared: boolean,
): HTMLElement | undefined {
  const found = new Map<string, { setting: SettingChoice; values: string[]; owners: string[] }>();
  for (const setup of setups) {
    const method = methodOf(hello.methods, setup.method);
    for (const setting of method?.settings ?? []) {
      const known = found.get(setting.key) ?? { setting, values: [], owners: [] };
      if (method !== undefined) {
        known.values.push(valueOf(method, setup.method, setting));
        if (!known.owners.includes(method.id)) known.owners.push(method.id);
      }
      found.set(setting.key, known);
    }
  }
  if (found.size === 0) return undefined;
  const box = make("div", { class: "knobs" });
  for (const [key, { setting, values, owners }] of found) {
    const label = key.replaceAll("_", " ");
    const now = values[0] ?? setting.default;
    const isOne = values.every((other) => isSameValue(other, now));
    const set = (value: string): void =>
      change((setup) => ({
        ...setup,
        method: withSetting(hello.methods, setup.method, key, value),
      }));
    let input: HTMLInputElement | HTMLSelectElement;
    const more: Node[] = [];
    if (setting.values.kind === "word") {
      input = make("select");
      if (!isOne) input.append(make("option", { value: "" }, "differs"));
      for (const word of setting.values.words)
        input.append(make("option", { value: word }, word));
      input.value = isOne ? now : "";
      const select = input;
      select.addEventListener("change", () => {
        if (select.value !== "") set(select.value);
      });
    } else {
      const { range, is_optional: isOptional, is_whole: isWhole } = setting.values;
      const [least, most] = range;
      const number = make("input", {
        inputmode: "decimal",
        spellcheck: "false",
        autocomplete: "off",
      });
      if (isOne) number.value = now;
      else number.placeholder = "differs";
      const take = (value: number): void => {
        const isIn = value >= least && value <= most && !(isWhole && !Number.isInteger(value));
        const isFit = isIn || (isOptional && value === 0);
        number.setAttribute("aria-invalid", String(!isFit));
        if (isFit) set(String(value));
        else complain(`${label}: expected ${setting.allowed}.`);
      };
      number.addEventListener("change", () =>
        take(number.value.trim() === "" ? NaN : Number(number.value)),
      );
      const low = Math.max(least, LEAST);
      if (!isWhole && most / low >= WIDE && isOne)
        more.push(slider(`set-${key}`, label, number, Number(now), [low, most], take));
      input = number;
    }
    input.dataset.knob = `set-${key}`;
    const help = `${setting.help} (${setting.allowed})`;
    if (isShared) {
      input.title = `${owners.join(", ")}: ${help}`;
    } else {
      const text = make("p", { class: "help", id: `help-${++last}` }, help);
      input.setAttribute("aria-describedby", text.id);
      more.push(text);
    }
    box.append(labelled(label, input, more, isShared ? "" : "wide"));
  }
  return box;
}
