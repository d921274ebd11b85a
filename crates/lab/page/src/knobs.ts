// Knobs: the same ones for all panes together and for each pane.

import { make, short } from "./dom";
import type { Hello, Range, SceneChoice, Setup } from "./messages";

/** What a knob does to a set-up, as it stands by then. */
export type Turn = (setup: Setup) => Setup;

type NumberKey = "stiffness" | "damping" | "step" | "duration" | "particles";

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
];

let last = 0;

function labelled(label: string, input: HTMLElement, more: Node[] = [], kind = ""): HTMLElement {
  input.id = `knob-${++last}`;
  return make("div", { class: kind }, make("label", { for: input.id }, label), input, ...more);
}

/**
 * Knobs for some panes. `change` is called with what a person asks for, `complain` with
 * a sentence if a value is out of its range.
 */
export function knobs(
  hello: Hello,
  setups: Setup[],
  change: (turn: Turn) => void,
  complain: (sentence: string) => void,
): HTMLElement {
  const box = make("div", { class: "knobs" });
  const first = setups[0];
  if (first === undefined) return box;
  const isShared = setups.length > 1;
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

  if (!isShared) {
    const list = make("datalist", { id: `methods-${++last}` });
    for (const method of hello.methods) {
      list.append(make("option", { value: method.id }, method.name));
      for (const preset of method.presets)
        list.append(make("option", { value: `${method.id}:${preset}` }));
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
      const slider = make("input", {
        type: "range",
        min: String(Math.log10(least)),
        max: String(Math.log10(most)),
        step: "0.25",
        "aria-label": `${knob.label}, as a slider`,
      });
      slider.dataset.knob = `${knob.key}-slider`;
      slider.value = String(Math.log10(now));
      const rounded = (): number => Number((10 ** Number(slider.value)).toPrecision(2));
      slider.addEventListener("input", () => (input.value = String(rounded())));
      slider.addEventListener("change", () => take(Math.min(most, Math.max(least, rounded()))));
      more.push(slider);
    }
    box.append(labelled(knob.label, input, more));
  }
  return box;
}
