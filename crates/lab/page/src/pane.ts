// One pane: its picture, verdict, numbers, energies and knobs.

import { button, make, say, sentence, short } from "./dom";
import { type Turn, knobs } from "./knobs";
import type { Frame, Hello, Scenery, Setup, Status } from "./messages";
import { methodOf } from "./methods";
import { Plot } from "./plot";
import { type Camera, type Renderer, View } from "./view";

/** Bytes of positions that a pane remembers. */
const MEMORY = 24e6;

/** The picture and the numbers at a time. */
interface Moment {
  status: Status;
  positions: Float32Array;
  ghost: Float32Array | undefined;
}

/** The numbers to show next, perhaps without a picture. */
interface Sight {
  status: Status;
  positions: Float32Array | undefined;
  ghost: Float32Array | undefined;
}

/** How far a key moves a particle that is led, in points of the picture. */
const STRIDE = 20;
const ARROWS: Record<string, [number, number]> = {
  ArrowLeft: [-STRIDE, 0],
  ArrowRight: [STRIDE, 0],
  ArrowUp: [0, -STRIDE],
  ArrowDown: [0, STRIDE],
};

/** Size of a vector; null if it is no number. */
function size(vector: (number | null)[]): number | null {
  return vector.includes(null) ? null : Math.hypot(...(vector as number[]));
}

const NAMES: Record<string, string> = {
  stable: "stable",
  locked: "locked",
  gained_energy: "gains energy",
  diverged: "diverged",
  unknown: "could not tell",
  refused: "refused",
};

/** The meanings of the causes in the ledger. */
const CAUSES: Record<string, string> = {
  damping: "damping of the springs",
  inertia: "inertia, numerical",
  impact: "impacts on obstacles",
  gaps: "forces of another time, numerical",
  residual: "residual of the solve",
  constraint: "pins and contacts",
  correction: "corrections of positions",
};

/** What a pane asks of the page. */
export interface Wishes {
  change(index: number, turn: Turn): void;
  remove(index: number): void;
  repeat(index: number): void;
  complain(sentence: string): void;
  /** Leads a particle of all panes; its way since it was gripped is in m. */
  lead(particle: number, by: [number, number, number]): void;
  letGo(): void;
  /** The address of the line that decides a verdict; empty if there is none. */
  place(decides: string): string;
  /** Opens the lesson on a method. */
  lesson(id: string): void;
}

export class PaneView {
  readonly element: HTMLElement;
  run = -1;
  /** Whether no step will follow. */
  isOver = false;
  private title = make("h2");
  private scene = "";
  private canvas: HTMLCanvasElement;
  private verdict = make("div", { class: "verdict" });
  private kind = make("strong", {}, "waiting");
  private how = make("span");
  private reason = make("p");
  private why = make("p");
  private numbers = make("dl");
  private cells = new Map<string, HTMLElement>();
  private plotted: HTMLCanvasElement;
  private plot: Plot;
  private range = make("p", { class: "help" });
  private legend = make("table");
  private legendKey = "";
  private causes = make("table");
  private own = make("details");
  private view: View;
  private history: Moment[] = [];
  private frame: Frame | undefined;
  private ghost: Frame | undefined;
  private ghostNote = make("p", { class: "help" });
  private decides = make("a", { target: "_blank", rel: "noopener" }, "The line that decides");
  private taught = "";
  private lesson = button("", () => this.wishes.lesson(this.taught), { class: "link", hidden: "" });
  /** The particle that is led, with its way in points of the picture. */
  private led: { particle: number; right: number; down: number } | undefined;
  private isDirty = false;
  /** The moment that the next picture shows. */
  private next: Sight | undefined;
  private isAwaited = false;
  private duration = 1;
  private shown: Status | undefined;
  private removeButton: HTMLButtonElement;

  constructor(
    readonly index: number,
    renderer: Renderer | undefined,
    camera: Camera,
    private wishes: Wishes,
  ) {
    this.canvas = make("canvas", { class: "view", tabindex: "0", role: "img" });
    this.plotted = make("canvas", {
      class: "plot",
      role: "img",
      "aria-label": "Energies over time; the table below has their present values",
    });
    this.plot = new Plot(this.plotted);
    this.view = new View(renderer, this.canvas, camera);
    this.lead();
    camera.steer(this.canvas);
    camera.onChange(() => (this.isDirty = true));
    this.removeButton = button("Remove", () => wishes.remove(index));
    const buttons = make(
      "span",
      { class: "buttons" },
      button("Repeat", () => wishes.repeat(index)),
      this.removeButton,
    );
    this.decides.hidden = true;
    this.verdict.append(
      make("p", {}, this.kind, " ", this.how),
      this.reason,
      this.why,
      make("p", { class: "ways" }, this.decides, this.lesson),
    );
    for (const [key, label, kind] of [
      ["time", "time", ""],
      ["step", "steps", ""],
      ["behind", "behind the clock", ""],
      ["speed", "times real time", ""],
      ["micros", "µs a step", ""],
      ["theta", "h²k/m", ""],
      ["cg", "CG iterations a step", "wide"],
      ["stretch", "greatest stretch", "wide"],
      ["momentum", "momentum, kg m/s", "wide"],
      ["angular", "angular momentum, kg m²/s", "wide"],
      ["distance", "off the reference", "wide"],
    ] as const) {
      const cell = make("dd", { class: kind }, "–");
      this.cells.set(key, cell);
      this.numbers.append(make("dt", { class: kind }, label), cell);
    }
    const ledger = make("details", {}, make("summary", {}, "What changed the energy"), this.causes);
    this.element = make(
      "article",
      { class: "pane", "aria-label": `Pane ${index + 1}` },
      make("div", { class: "head" }, this.title, buttons),
      renderer === undefined
        ? make(
            "p",
            { class: "help" },
            "This browser has no WebGL 2, so there is no picture; the numbers below are all there.",
          )
        : this.canvas,
      this.verdict,
      this.numbers,
      this.ghostNote,
      this.plotted,
      this.range,
      this.legend,
      ledger,
      this.own,
    );
  }

  /** Shows the knobs of a set-up. */
  configure(hello: Hello, setup: Setup, isAlone: boolean): void {
    say(this.title, setup.method);
    this.scene = setup.scene;
    this.isOver = false;
    this.removeButton.disabled = isAlone;
    this.removeButton.setAttribute("aria-label", `Remove ${setup.method}`);
    this.canvas.setAttribute(
      "aria-label",
      `The cloth with ${setup.method}; arrow keys turn it, g grips its lowest particle`,
    );
    const isOpen = this.own.open;
    this.own.replaceChildren(make("summary", {}, "Knobs of this pane"));
    const change = (turn: Turn): void => this.wishes.change(this.index, turn);
    const complain = (sentence: string): void => this.wishes.complain(sentence);
    this.own.append(knobs(hello, [setup], change, complain, false));
    const method = methodOf(hello.methods, setup.method);
    this.taught = method?.has_lesson === true ? method.id : "";
    this.lesson.hidden = this.taught === "";
    say(this.lesson, `Lesson on ${this.taught}`);
    if (method !== undefined)
      this.own.append(make("p", { class: "help" }, `${method.name}. ${method.theory}`));
    this.own.open = isOpen;
  }

  begin(scenery: Scenery): void {
    this.duration = scenery.duration;
    // The cloth goes on after a change.
    if (scenery.run === this.run) return;
    this.run = scenery.run;
    this.isOver = false;
    this.history = [];
    this.plot.clear();
    this.frame = undefined;
    this.ghost = undefined;
    this.next = undefined;
    this.release();
    this.view.set(scenery, this.scene);
  }

  take(frame: Frame): void {
    if (frame.run !== this.run) return;
    if (frame.isGhost) this.ghost = frame;
    else this.frame = frame;
  }

  /** Lets a person lead a particle by mouse, finger and keys. Comes before the camera. */
  private lead(): void {
    const { canvas } = this;
    const finish = (): void => {
      if (this.led === undefined) return;
      this.release();
      this.wishes.letGo();
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (this.led !== undefined || this.isOver || event.button !== 0) return;
      const isTouch = event.pointerType === "touch";
      const particle = this.view.pick(event.offsetX, event.offsetY, isTouch);
      if (particle === undefined) return;
      event.stopImmediatePropagation();
      canvas.setPointerCapture(event.pointerId);
      this.beginLead(particle);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (this.led === undefined || !canvas.hasPointerCapture(event.pointerId)) return;
      event.stopImmediatePropagation();
      this.moveLed(event.movementX, event.movementY);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, finish);
    // A finger that leads a particle does not scroll the page.
    canvas.addEventListener(
      "touchstart",
      (event) => {
        if (this.led !== undefined) event.preventDefault();
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const arrow = ARROWS[event.key];
      if (event.key === "g" && this.led !== undefined) finish();
      else if (event.key === "g" && !this.isOver) {
        const particle = this.view.lowest();
        if (particle !== undefined) this.beginLead(particle);
      } else if (event.key === "Escape" && this.led !== undefined) finish();
      else if (arrow !== undefined && this.led !== undefined) this.moveLed(...arrow);
      else return;
      event.preventDefault();
      event.stopImmediatePropagation();
    });
    canvas.addEventListener("blur", finish);
  }

  private beginLead(particle: number): void {
    this.led = { particle, right: 0, down: 0 };
    this.canvas.dataset.led = String(particle);
    this.view.grip(particle);
    this.wishes.lead(particle, [0, 0, 0]);
  }

  private moveLed(right: number, down: number): void {
    if (this.led === undefined) return;
    this.led.right += right;
    this.led.down += down;
    const { particle } = this.led;
    this.wishes.lead(particle, this.view.way(particle, this.led.right, this.led.down));
  }

  private release(): void {
    this.led = undefined;
    delete this.canvas.dataset.led;
    this.view.grip(undefined);
  }

  /** Takes numbers; `isLive` unless a person looks back. */
  tell(status: Status, isLive: boolean): void {
    if (status.phase.kind === "refused") {
      this.run = status.run;
      this.history = [];
      this.isOver = true;
      this.next = undefined;
      this.speak("refused", "", status.phase.sentence, "", "");
      return;
    }
    if (status.run !== this.run) return;
    this.isOver = status.phase.kind === "ended" || status.phase.kind === "diverged";
    this.plot.add(status.numbers);
    const positions = this.frame?.positions;
    const isNow = this.ghost?.time === status.numbers.time && status.distance !== null;
    const ghost = isNow ? this.ghost?.positions : undefined;
    if (positions !== undefined) {
      const last = this.history[this.history.length - 1];
      if (last !== undefined && last.status.numbers.time >= status.numbers.time) this.history.pop();
      this.history.push({ status, positions, ghost });
      const most = Math.max(50, Math.min(1500, MEMORY / positions.byteLength));
      if (this.history.length > most) this.history = this.history.filter((_, i) => i % 2 === 0);
    }
    if (isLive) this.displaySoon({ status, positions, ghost });
  }

  /** Shows the last of all messages before a picture: a slow browser leaves some out, and messages
   *  do not pile up. */
  private displaySoon(sight: Sight): void {
    this.next = sight;
    if (this.isAwaited) return;
    this.isAwaited = true;
    requestAnimationFrame(() => {
      this.isAwaited = false;
      const { next } = this;
      this.next = undefined;
      if (next !== undefined) this.display(next.status, next.positions, next.ghost);
    });
  }

  /** Shows the last moment that is not later than a time. */
  lookBack(time: number): void {
    this.next = undefined;
    let found = this.history[0];
    for (const moment of this.history)
      if (moment.status.numbers.time <= time + 1e-9) found = moment;
    if (found !== undefined) this.display(found.status, found.positions, found.ghost);
  }

  live(): void {
    const last = this.history[this.history.length - 1];
    if (last !== undefined) this.display(last.status, last.positions, last.ghost);
  }

  private speak(kind: string, how: string, reason: string, why: string, decides: string): void {
    this.verdict.className = `verdict ${kind}`;
    say(this.kind, NAMES[kind] ?? kind);
    say(this.how, how);
    say(this.reason, sentence(reason));
    say(this.why, why);
    const place = this.wishes.place(decides);
    this.decides.hidden = place === "";
    if (place !== "" && this.decides.getAttribute("href") !== place) this.decides.href = place;
  }

  private display(
    status: Status,
    positions: Float32Array | undefined,
    ghost: Float32Array | undefined,
  ): void {
    this.shown = status;
    const { numbers, verdict } = status;
    if (verdict !== null) {
      const how = verdict.is_final ? `(after ${numbers.step} steps)` : "so far";
      this.speak(verdict.kind, how, verdict.reason, verdict.why, verdict.decides);
    }
    const cells: Record<string, string> = {
      time: `${numbers.time.toFixed(3)} s`,
      step: String(numbers.step),
      behind: `${status.behind.toFixed(2)} s`,
      speed: numbers.step === 0 ? "–" : short(numbers.times_real_time),
      micros: numbers.micros === 0 ? "–" : short(numbers.micros),
      cg: numbers.step === 0 ? "–" : short(numbers.all_cg_iterations / numbers.step),
      theta: short(numbers.theta),
      stretch: numbers.stretch === null ? "–" : `${short(100 * numbers.stretch)} %`,
      momentum: short(size(numbers.momentum)),
      angular: short(size(numbers.angular_momentum)),
      distance: status.distance === null ? "–" : `${short(1000 * status.distance)} mm`,
    };
    say(this.ghostNote, status.ghost === null ? "" : `No reference: ${status.ghost}.`);
    for (const [key, text] of Object.entries(cells)) {
      const cell = this.cells.get(key);
      if (cell !== undefined) say(cell, text);
    }
    this.list(numbers.energy);
    if (numbers.causes === null) {
      if (this.causes.textContent === "")
        this.causes.append(make("caption", { class: "help" }, "This method does not tell."));
    } else {
      const rows = Object.entries(numbers.causes).map(([key, value]) =>
        make(
          "tr",
          {},
          make("th", { scope: "row" }, CAUSES[key] ?? key),
          make("td", {}, `${short(value)} J`),
        ),
      );
      this.causes.replaceChildren(...rows);
    }
    this.view.showGhost(ghost);
    if (positions !== undefined) this.view.show(positions, numbers.offsets);
    say(this.range, this.plot.draw(this.duration));
  }

  private list(energy: [string, number | null][]): void {
    const key = energy.map(([name]) => name).join();
    if (key !== this.legendKey) {
      this.legendKey = key;
      this.legend.replaceChildren(
        ...energy.map(([name], n) => {
          const swatch = make("span", { class: "swatch" });
          swatch.style.background = this.plot.colour(n, energy.length);
          return make("tr", {}, make("th", { scope: "row" }, swatch, `${name} energy`), make("td"));
        }),
      );
    }
    energy.forEach(([, value], n) => {
      const cell = this.legend.rows[n]?.cells[1];
      if (cell !== undefined) say(cell, `${short(value)} J`);
    });
  }

  /** Draws again, after the camera, the window or the colours changed. */
  refresh(isForced: boolean): void {
    if (!this.isDirty && !isForced) return;
    this.isDirty = false;
    this.view.draw();
    if (isForced) {
      this.legendKey = "";
      if (this.shown !== undefined) this.list(this.shown.numbers.energy);
      say(this.range, this.plot.draw(this.duration));
    }
  }
}
