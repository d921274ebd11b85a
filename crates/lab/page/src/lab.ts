// The page: connects to the engine, keeps the set-up in the address, and shows the panes.

import * as address from "./address";
import { button, byId, make, say, sentence as asSentence } from "./dom";
import { PREFIX, Shelf } from "./files";
import { type Turn, knobs } from "./knobs";
import { Lessons } from "./lessons";
import { connect } from "./link";
import {
  type Hello,
  type Reply,
  type Request,
  type SceneChoice,
  type Setup,
  readFrame,
} from "./messages";
import { PaneView, type Wishes } from "./pane";
import { Camera, Renderer } from "./view";

/** Characters of a scene that the dialog shows; the file holds all of it. */
const SHOWN = 20_000;

/** How much nearer or farther a button brings the cameras. */
const NEARER = 1.3;

/** Lets a link save a text. */
function saveAs(id: string, text: string, name: string): void {
  const link = byId<HTMLAnchorElement>(id);
  URL.revokeObjectURL(link.href);
  link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  link.download = name;
}

class Lab {
  private state = address.read(location.hash) ?? address.opening();
  private hello: Hello | undefined;
  private link = connect({
    text: (message) => this.hear(JSON.parse(message) as Reply),
    bytes: (message) => {
      const frame = readFrame(message);
      if (frame !== undefined) this.panes[frame.pane]?.take(frame);
    },
    complain: (sentence) => this.complain(sentence),
  });
  private panes: PaneView[] = [];
  private camera = new Camera();
  private renderer = Renderer.make();
  private isPlaying = false;
  /** Whether a new set-up plays at once. */
  private wantsPlay = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  private isLive = true;
  private message = byId("message");
  private time = make("output", { id: "clock" }, "t = 0.00 s");
  private play = button("Play", () => this.toggle(), { class: "main", id: "play" });
  private rate = make("select", { id: "rate", "aria-label": "Speed" });
  private wait = make("input", { type: "checkbox", id: "wait" });
  private back = make("input", {
    type: "range",
    min: "0",
    max: "1",
    step: "any",
    id: "back",
    "aria-label": "Look back in time",
  });
  private ghost = make("input", { type: "checkbox", id: "ghost" });
  private keep = make("input", { type: "checkbox", id: "keep" });
  private files = new Shelf();
  /** The last file that was given; the panes show its scene once the server has read it. */
  private awaited: string | undefined;
  /** Whether files were given again to a new server, whose panes stay as they are. */
  private isAgain = false;
  private chooser = make("input", {
    type: "file",
    id: "chooser",
    accept: ".json,.obj",
    multiple: "",
    hidden: "",
  });
  private add = button("Add a pane", () => this.addPane(), { id: "add" });

  private lessons = new Lessons(byId("lesson"), {
    send: (request) => this.send(request),
    remember: (id) => this.rememberLesson(id),
    open: (panes) => this.openLesson(panes),
  });

  private wishes: Wishes = {
    change: (index, turn) => {
      this.state.panes = this.state.panes.map((setup, i) => (i === index ? turn(setup) : setup));
      this.openSoon();
    },
    remove: (index) => {
      this.state.panes.splice(index, 1);
      this.open();
    },
    repeat: (index) => this.send({ do: "repeat", pane: index }),
    complain: (sentence) => this.complain(sentence),
    lead: (particle, by) => {
      this.goLive();
      this.wantsPlay = true;
      this.send({ do: "lead", particle, by });
    },
    letGo: () => this.send({ do: "let_go" }),
    place: (decides) => this.link.place(decides),
    lesson: (id) => this.lessons.visit(id),
  };

  constructor() {
    if (!this.wantsPlay)
      this.inform("Paused, because your system asks for little motion. Press Play.");
    for (const rate of [0.05, 0.1, 0.25, 0.5, 1, 2, 5]) {
      this.rate.append(
        make("option", { value: String(rate) }, rate === 1 ? "real time" : `${rate} × real time`),
      );
    }
    this.rate.addEventListener("change", () => {
      this.state.rate = Number(this.rate.value);
      this.remember();
      this.send({ do: "rate", rate: this.state.rate });
    });
    this.wait.addEventListener("change", () => {
      this.state.wait = this.wait.checked;
      this.remember();
      this.send({ do: "wait", wait: this.state.wait });
    });
    this.ghost.addEventListener("change", () => {
      this.state.ghost = this.ghost.checked;
      this.remember();
      this.send({ do: "ghost", on: this.state.ghost });
    });
    this.keep.addEventListener("change", () => {
      this.state.keep = this.keep.checked;
      this.remember();
    });
    this.acceptFiles();
    this.back.addEventListener("input", () => this.lookBack(Number(this.back.value)));
    byId("bar").append(
      this.play,
      button("Step", () => this.step(), { id: "step" }),
      button("Restart", () => this.restart(), { id: "restart" }),
      this.time,
      this.back,
    );
    byId("options").append(
      this.rate,
      make("label", { class: "inline" }, this.wait, "wait for slow panes"),
      make("label", { class: "inline" }, this.ghost, "reference"),
      make("label", { class: "inline" }, this.keep, "go on after a change"),
    );
    byId("tools").append(
      button("Closer", () => this.camera.move(0, 0, 1 / NEARER), { id: "closer" }),
      button("Farther", () => this.camera.move(0, 0, NEARER), { id: "farther" }),
      button("Open a file", () => this.chooser.click(), { id: "open" }),
      this.chooser,
      this.add,
      this.lessons.opener,
    );
    // A small screen shows the panes first.
    byId<HTMLDetailsElement>("fold").open = !matchMedia("(max-width: 600px)").matches;
    byId("copy").addEventListener(
      "click",
      () => void navigator.clipboard.writeText(byId("command").textContent ?? ""),
    );
    byId("copy-way").addEventListener(
      "click",
      () => void navigator.clipboard.writeText(byId("way-command").textContent ?? ""),
    );
    byId("close").addEventListener("click", () => byId<HTMLDialogElement>("repeat").close());
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("hashchange", () => {
      const state = address.read(location.hash);
      if (state === undefined || address.write(state) === address.write(this.state)) return;
      this.state = state;
      this.begin();
    });
    addEventListener("resize", () => this.refresh(true));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.refresh(true));
    this.camera.onChange(() => requestAnimationFrame(() => this.refresh(false)));
  }

  private complain(sentence: string): void {
    this.message.className = "";
    say(this.message, sentence);
  }

  /** Shows a notice that reports no fault. */
  private inform(sentence: string): void {
    this.message.className = "help";
    say(this.message, sentence);
  }

  /** Takes files that are dropped anywhere on the page, or chosen. */
  private acceptFiles(): void {
    const take = (files: FileList | null | undefined): void => {
      if (files !== null && files !== undefined && files.length > 0) void this.takeFiles([...files]);
    };
    addEventListener("dragover", (event) => {
      event.preventDefault();
      document.body.classList.add("dropping");
    });
    addEventListener("dragleave", () => document.body.classList.remove("dropping"));
    addEventListener("drop", (event) => {
      event.preventDefault();
      document.body.classList.remove("dropping");
      take(event.dataTransfer?.files);
    });
    this.chooser.addEventListener("change", () => {
      take(this.chooser.files);
      this.chooser.value = "";
    });
  }

  private async takeFiles(files: File[]): Promise<void> {
    if (this.hello === undefined) return;
    this.complain("");
    const { limits } = this.hello;
    const last = await this.files.take(
      files,
      limits,
      (bytes) => this.link.bytes(bytes),
      (sentence) => this.complain(sentence),
    );
    this.isAgain = false;
    this.awaited = last;
  }

  /** Shows the scene of a file that the server has read. */
  private takeScene(scene: SceneChoice, notes: string[]): void {
    if (this.hello === undefined) return;
    const others = this.hello.scenes.filter((known) => known.name !== scene.name);
    this.hello.scenes = [...others, scene];
    if (this.awaited === undefined || scene.name !== PREFIX + this.awaited) return;
    this.awaited = undefined;
    const isShown = this.state.panes.some((setup) => setup.scene === scene.name);
    if (!isShown && !this.isAgain)
      this.state.panes = this.state.panes.map(({ method }) => ({ scene: scene.name, method }));
    this.begin();
    if (notes.length > 0) this.inform(notes.map(asSentence).join(" "));
  }

  private send(request: Request): void {
    this.link.text(JSON.stringify(request));
  }

  private hear(reply: Reply): void {
    switch (reply.tell) {
      case "hello":
        this.hello = reply;
        if (this.message.textContent?.startsWith("The lab does not answer")) this.complain("");
        this.lessons.forget();
        // A server that was started anew has no files.
        this.awaited = this.files.giveAll((bytes) => this.link.bytes(bytes));
        this.isAgain = true;
        if (this.awaited === undefined) this.begin();
        break;
      case "lessons":
      case "lesson":
      case "marked":
        this.lessons.hear(reply);
        break;
      case "dropped":
        this.takeScene(reply.scene, reply.notes);
        break;
      case "scenery":
        this.panes[reply.pane]?.begin(reply);
        break;
      case "status":
        this.panes[reply.pane]?.tell(reply, this.isLive);
        this.progress(reply.numbers.time);
        this.showClock();
        break;
      case "clock":
        this.isPlaying = reply.playing;
        this.showClock();
        break;
      case "repeat": {
        const { command, file, mesh, scene, note, way } = reply.repeat;
        say(byId("note"), note);
        say(byId("command"), command);
        const beside = mesh === null ? "" : ` It must stand beside ${mesh}.`;
        say(
          byId("file"),
          file === null
            ? "The scene comes with drape."
            : `The command reads ${file}: save the scene first.${beside}`,
        );
        say(byId("scene"), scene.length > SHOWN ? `${scene.slice(0, SHOWN)}…` : scene);
        saveAs("save", scene, file ?? "scene.json");
        byId("way").hidden = way === null;
        if (way !== null) {
          say(byId("way-command"), way.command);
          saveAs("save-way", way.scene, way.file);
        }
        byId<HTMLDialogElement>("repeat").showModal();
        break;
      }
      case "refused":
        this.complain(reply.sentence);
        if (this.awaited !== undefined && reply.sentence.includes(this.awaited)) {
          this.files.forget(this.awaited);
          this.awaited = undefined;
          if (this.isAgain) this.open();
        }
    }
  }

  /** Opens what the address names: panes, a lesson, or both. A lesson alone brings its panes. */
  private begin(): void {
    const { lesson, panes } = this.state;
    const isAlone = panes.length === 0;
    if (isAlone) this.state.panes = address.opening().panes;
    this.lessons.restore(lesson, isAlone);
    this.open();
  }

  private rememberLesson(id: string | undefined): void {
    if (id === undefined) delete this.state.lesson;
    else this.state.lesson = id;
    this.remember();
  }

  private openLesson(panes: Setup[]): void {
    this.state.panes = panes.map((setup) => ({ ...setup }));
    this.complain("");
    this.open();
  }

  /** Writes the set-up into the address. */
  private remember(): void {
    history.replaceState(null, "", `#${address.write(this.state)}`);
  }

  /** Opens once the focus has moved on from a knob that was changed. */
  private openSoon(): void {
    setTimeout(() => this.open(this.state.keep));
  }

  /** Begins again with the present set-up, or lets the panes go on with it. */
  private open(keep = false): void {
    if (this.hello === undefined) return;
    const { hello, state } = this;
    const active = document.activeElement;
    const knob = active instanceof HTMLElement ? active.dataset.knob : undefined;
    const place = active?.closest("#shared, .pane");
    state.panes.length = Math.min(state.panes.length, hello.limits.panes);
    this.remember();
    const holder = byId("panes");
    while (this.panes.length > state.panes.length) this.panes.pop()?.element.remove();
    while (this.panes.length < state.panes.length) {
      const pane = new PaneView(this.panes.length, this.renderer, this.camera, this.wishes);
      this.panes.push(pane);
      holder.append(pane.element);
    }
    this.panes.forEach((pane, i) => {
      const setup = state.panes[i];
      if (setup !== undefined) pane.configure(hello, setup, state.panes.length === 1);
    });
    const change = (turn: Turn): void => {
      this.state.panes = this.state.panes.map(turn);
      this.openSoon();
    };
    byId("shared").replaceChildren(
      knobs(hello, state.panes, change, (sentence) => this.complain(sentence), true),
    );
    this.add.disabled = state.panes.length >= hello.limits.panes;
    if (![...this.rate.options].some((option) => Number(option.value) === state.rate)) {
      this.rate.append(make("option", { value: String(state.rate) }, `${state.rate} × real time`));
    }
    this.rate.value = String(state.rate);
    this.wait.checked = state.wait;
    this.ghost.checked = state.ghost;
    this.keep.checked = state.keep;
    this.goLive();
    this.send({ do: "rate", rate: state.rate });
    this.send({ do: "wait", wait: state.wait });
    this.send({ do: "ghost", on: state.ghost });
    if (!keep) this.camera.forget();
    this.send({ do: "open", panes: state.panes, keep });
    const missing = state.panes.find((setup) => !this.files.has(setup.scene));
    if (missing !== undefined) {
      const name = missing.scene.slice(PREFIX.length);
      this.complain(`This link needs the file ${name} again: drop it here or open it.`);
    }
    if (this.wantsPlay) this.send({ do: "play" });
    this.isPlaying = this.wantsPlay;
    if (!keep) this.back.dataset.latest = "0";
    this.showClock();
    // The knobs were made anew: the focus stays where it was.
    if (knob !== undefined) place?.querySelector<HTMLElement>(`[data-knob="${knob}"]`)?.focus();
  }

  private addPane(): void {
    const last = this.state.panes[this.state.panes.length - 1];
    if (last === undefined) return;
    this.state.panes.push({ ...last, method: "baraff-witkin" });
    this.open();
  }

  private isOver(): boolean {
    return this.panes.length > 0 && this.panes.every((pane) => pane.isOver);
  }

  private toggle(): void {
    if (this.isPlaying) {
      this.wantsPlay = false;
      this.send({ do: "pause" });
    } else if (this.isOver()) this.restart();
    else {
      this.wantsPlay = true;
      this.complain("");
      this.goLive();
      this.send({ do: "play" });
    }
  }

  private step(): void {
    this.wantsPlay = false;
    this.complain("");
    this.goLive();
    this.send({ do: "step" });
  }

  private restart(): void {
    this.complain("");
    this.wantsPlay = true;
    this.back.dataset.latest = "0";
    this.goLive();
    this.send({ do: "restart" });
    this.send({ do: "play" });
  }

  private lookBack(time: number): void {
    this.isLive = false;
    if (this.isPlaying) this.send({ do: "pause" });
    this.wantsPlay = false;
    for (const pane of this.panes) pane.lookBack(time);
    say(this.time, `t = ${time.toFixed(2)} s`);
  }

  private goLive(): void {
    if (this.isLive) return;
    this.isLive = true;
    for (const pane of this.panes) pane.live();
  }

  private progress(time: number): void {
    const latest = Math.max(time, 0);
    if (!this.isLive) return;
    const duration = Math.max(...this.state.panes.map((setup) => this.durationOf(setup)));
    this.back.max = String(duration);
    const known = latest < 1e-12 ? 0 : Math.max(latest, Number(this.back.dataset.latest ?? 0));
    this.back.dataset.latest = String(known);
    this.back.value = String(known);
    say(this.time, `t = ${known.toFixed(2)} s`);
  }

  private durationOf(setup: Setup): number {
    return (
      setup.duration ??
      this.hello?.scenes.find((scene) => scene.name === setup.scene)?.duration ??
      1
    );
  }

  private showClock(): void {
    say(this.play, this.isPlaying ? "Pause" : this.isOver() ? "Play again" : "Play");
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    const isTyping = target.matches("input, select, textarea, button, a, summary");
    if (
      isTyping ||
      event.ctrlKey ||
      event.metaKey ||
      event.altKey ||
      byId<HTMLDialogElement>("repeat").open
    )
      return;
    if (event.key === " ") this.toggle();
    else if (event.key === ".") this.step();
    else if (event.key === "r") this.restart();
    else return;
    event.preventDefault();
  }

  private refresh(isForced: boolean): void {
    for (const pane of this.panes) pane.refresh(isForced);
  }
}

new Lab();
