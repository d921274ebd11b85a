// The panel of lessons: a list, and one lesson with its question. The server marks answers.

import { button, make, say, short } from "./dom";
import type { Lesson, LessonReply, LessonRequest, Setup } from "./messages";

/** Size of the curve, in its own units. */
const WIDE = 320;
const HIGH = 150;
const EDGE = { left: 34, right: 8, top: 8, bottom: 26 };

/** What the panel asks of the page. */
export interface LessonWishes {
  send(request: LessonRequest): void;
  /** The lesson that the address names from now on; none if undefined. */
  remember(id: string | undefined): void;
  /** Opens the panes of a lesson. */
  open(panes: Setup[]): void;
}

const SVG = "http://www.w3.org/2000/svg";

function draw(name: string, attributes: Record<string, string | number>, text = ""): SVGElement {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.textContent = text;
  return element;
}

/** The factor by which a step multiplies the motion, over the step, both logarithmic. */
function curve(radii: [number, number][], step: number): SVGElement {
  const picture = draw("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, class: "curve", role: "img" });
  picture.setAttribute(
    "aria-label",
    "Factor by which a step multiplies the motion, over the step size; the table below has the numbers",
  );
  const first = radii[0]?.[0] ?? 1;
  const last = radii[radii.length - 1]?.[0] ?? 10;
  const [low, high] = [0.1, 10];
  const across = (h: number): number =>
    EDGE.left +
    ((WIDE - EDGE.left - EDGE.right) * Math.log(h / first)) / Math.log(last / first);
  const up = (factor: number): number => {
    const held = Math.min(high, Math.max(low, factor));
    return EDGE.top + ((HIGH - EDGE.top - EDGE.bottom) * Math.log(high / held)) / Math.log(high / low);
  };
  for (const factor of [0.1, 1, 10]) {
    const y = up(factor);
    const kind = factor === 1 ? "one" : "grid";
    picture.append(
      draw("line", { x1: EDGE.left, x2: WIDE - EDGE.right, y1: y, y2: y, class: kind }),
      draw("text", { x: EDGE.left - 4, y: y + 4, "text-anchor": "end" }, String(factor)),
    );
  }
  const x = across(step);
  picture.append(
    draw("line", { x1: x, x2: x, y1: EDGE.top, y2: HIGH - EDGE.bottom, class: "grid" }),
    draw("text", { x, y: HIGH - EDGE.bottom + 12, "text-anchor": "middle" }, `h = ${short(step)} s`),
    draw("text", { x: EDGE.left, y: HIGH - 3 }, `${short(first)} s`),
    draw("text", { x: WIDE - EDGE.right, y: HIGH - 3, "text-anchor": "end" }, `${short(last)} s`),
    draw("polyline", {
      points: radii.map(([h, factor]) => `${across(h).toFixed(1)},${up(factor).toFixed(1)}`).join(" "),
      class: "line",
    }),
  );
  return picture;
}

/** Some of the points as a table. */
function table(radii: [number, number][]): HTMLElement {
  const some = radii.filter((_, n) => n % 5 === 0);
  const rows = some.map(([h, factor]) =>
    make("tr", {}, make("th", { scope: "row" }, `${short(h)} s`), make("td", {}, short(factor))),
  );
  return make("table", {}, ...rows);
}

/** Reads a number as a person writes it; a decimal comma is fine. */
export function number(text: string): number {
  const trimmed = text.trim().replace("−", "-").replace(",", ".");
  return trimmed === "" ? NaN : Number(trimmed);
}

export class Lessons {
  private select = make("select", { id: "lesson-choice" });
  private body = make("div", { id: "lesson-body" });
  private toggle: HTMLButtonElement;
  private shown: Lesson | undefined;
  /** Whether the next lesson that comes opens its panes. */
  private opens = false;
  private hasList = false;

  constructor(
    private panel: HTMLElement,
    private wishes: LessonWishes,
  ) {
    this.toggle = button("Lessons", () => this.turn(), {
      id: "lessons",
      "aria-expanded": "false",
      "aria-controls": panel.id,
    });
    this.select.addEventListener("change", () => {
      if (this.select.value !== "") this.choose(this.select.value);
    });
    panel.append(
      make(
        "div",
        { class: "head" },
        make("h2", {}, "Lessons"),
        button("Close", () => {
          this.turn();
          this.toggle.focus();
        }, { id: "lesson-close" }),
      ),
      make("label", { for: "lesson-choice" }, "Lesson"),
      this.select,
      this.body,
    );
  }

  /** The button that opens and closes the panel. */
  get opener(): HTMLButtonElement {
    return this.toggle;
  }

  /** Shows the lesson that the address names; with its panes if the address has none. */
  restore(id: string | undefined, opensPanes: boolean): void {
    if (id === undefined) return;
    this.ask();
    this.expand(true);
    if (this.shown?.id === id && !opensPanes) return;
    this.opens = opensPanes;
    this.wishes.send({ do: "lesson", id });
  }

  /** Shows the lesson on a method beside the present panes. */
  visit(id: string): void {
    this.restore(id, false);
    this.wishes.remember(id);
    this.select.focus();
  }

  /** After the server was lost, the panel asks again for all messages that it still needs. */
  forget(): void {
    this.hasList = false;
  }

  hear(reply: LessonReply): void {
    switch (reply.tell) {
      case "lessons":
        this.select.replaceChildren(
          make("option", { value: "" }, "Choose a lesson"),
          ...reply.lessons.map(({ id, title }) => make("option", { value: id }, `${id}: ${title}`)),
        );
        this.select.value = this.shown?.id ?? "";
        break;
      case "lesson":
        this.shown = reply.lesson;
        this.select.value = reply.lesson.id;
        this.show(reply.lesson);
        this.wishes.remember(reply.lesson.id);
        if (this.opens) this.wishes.open(reply.lesson.panes);
        this.opens = false;
        break;
      case "marked": {
        const mark = document.getElementById("lesson-mark");
        if (mark === null || reply.lesson !== this.shown?.id) return;
        mark.className = reply.right ? "right" : "wrong";
        say(mark, reply.sentence);
      }
    }
  }

  private ask(): void {
    if (this.hasList) return;
    this.hasList = true;
    this.wishes.send({ do: "lessons" });
  }

  private expand(isOpen: boolean): void {
    this.panel.hidden = !isOpen;
    this.toggle.setAttribute("aria-expanded", String(isOpen));
  }

  private turn(): void {
    const isOpen = this.panel.hidden !== false;
    this.expand(isOpen);
    if (isOpen) {
      this.ask();
      this.select.focus();
      this.wishes.remember(this.shown?.id);
    } else this.wishes.remember(undefined);
  }

  private choose(id: string): void {
    this.opens = true;
    this.wishes.send({ do: "lesson", id });
  }

  private show(lesson: Lesson): void {
    const input = make("input", {
      id: "lesson-answer",
      inputmode: "decimal",
      autocomplete: "off",
      spellcheck: "false",
    });
    const mark = make("p", { id: "lesson-mark", role: "status", "aria-live": "polite" });
    const form = make(
      "form",
      {},
      make(
        "label",
        { for: "lesson-answer" },
        lesson.unit === "" ? "Your answer" : `Your answer, ${lesson.unit}`,
      ),
      make("div", { class: "answer" }, input, make("button", { id: "lesson-check" }, "Check")),
      mark,
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const value = number(input.value);
      const isNumber = Number.isFinite(value);
      input.setAttribute("aria-invalid", String(!isNumber));
      if (isNumber) this.wishes.send({ do: "answer", lesson: lesson.id, value });
      else {
        mark.className = "wrong";
        say(mark, "Expected a number, such as 0.05.");
      }
    });
    const setting = lesson.panes[0];
    const heading = (text: string): HTMLElement => make("h3", {}, text);
    this.body.replaceChildren(
      make("h3", { class: "title" }, lesson.title),
      make("p", {}, lesson.idea),
      button("Open the panes of this lesson", () => this.wishes.open(lesson.panes), {
        id: "lesson-open",
      }),
      heading("Question"),
      make("p", {}, lesson.question),
      make("p", { class: "help" }, lesson.way),
      form,
      heading("Try next"),
      make("p", {}, lesson.attempt),
      heading("Equations"),
      make("pre", { tabindex: "0" }, lesson.equation),
      make("p", { class: "help" }, lesson.equation_file),
      heading("Code"),
      make("pre", { tabindex: "0" }, lesson.code),
      make("p", { class: "help" }, lesson.code_file),
      heading("What a step does"),
      make(
        "p",
        { class: "help" },
        "The factor by which a step multiplies the motion in the long run, over the step size: above 1 the motion grows.",
      ),
      curve(lesson.radii, setting?.step ?? 1),
      make("details", {}, make("summary", {}, "As numbers"), table(lesson.radii)),
      heading("Repeat"),
      make("pre", { class: "wrap", tabindex: "0" }, lesson.repeat),
      make(
        "p",
        { class: "help" },
        lesson.file === null
          ? "The scene comes with drape."
          : `The command reads ${lesson.file}: the button Repeat of the first pane saves it.`,
      ),
      make("pre", { class: "wrap", tabindex: "0" }, `drape lab --setup lesson=${lesson.id}`),
      make("p", { class: "help" }, "This one draws the lesson and its panes again."),
      heading("Read on"),
      make(
        "p",
        {},
        "Documentation: ",
        make("code", {}, `cargo doc --open -p ${lesson.docs}`),
        ". Study: ",
        make("code", {}, `drape experiment ${lesson.study}`),
        ".",
      ),
    );
  }
}
