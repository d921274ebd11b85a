// Energies over time, as lines.

import { short } from "./dom";
import type { Numbers } from "./messages";

/** Points that are kept; older ones are thinned out, so that memory stays flat. */
const MOST = 600;

/** Colours that differ in lightness too. */
const COLOURS = {
  light: ["#0b57a4", "#8a4b00", "#0a6b3d", "#8b1a8f", "#5a5f00", "#006d75", "#1b2126"],
  dark: ["#7db8f5", "#f3b55f", "#6fd6a0", "#e59bea", "#d9dc6b", "#6fd9e2", "#e8edf1"],
};

/** The energies of a run. */
export class Plot {
  private times: number[] = [];
  private values: number[][] = [];
  private names: string[] = [];

  constructor(private canvas: HTMLCanvasElement) {}

  clear(): void {
    this.times = [];
    this.values = [];
  }

  /** Colour of the energy with this number; that of the total is the colour of text. */
  colour(index: number, count: number): string {
    const colours = matchMedia("(prefers-color-scheme: dark)").matches
      ? COLOURS.dark
      : COLOURS.light;
    const last = colours.length - 1;
    return colours[index === count - 1 ? last : index % last] ?? "";
  }

  add(numbers: Numbers): void {
    const last = this.times[this.times.length - 1];
    if (last !== undefined && numbers.time <= last) return;
    this.names = numbers.energy.map(([name]) => name);
    this.times.push(numbers.time);
    this.values.push(numbers.energy.map(([, value]) => value ?? NaN));
    if (this.times.length > MOST) {
      const keep = (_: unknown, i: number): boolean => i % 2 === 0;
      this.times = this.times.filter(keep);
      this.values = this.values.filter(keep);
    }
  }

  /** Draws all energies until a time, s, and says what the picture spans. */
  draw(until: number): string {
    const box = this.canvas.getBoundingClientRect();
    const scale = Math.min(devicePixelRatio, 2);
    const [width, height] = [Math.round(box.width * scale), Math.round(box.height * scale)];
    const context = this.canvas.getContext("2d");
    if (context === null || width === 0) return "";
    if (this.canvas.width !== width || this.canvas.height !== height) {
      [this.canvas.width, this.canvas.height] = [width, height];
    }
    context.clearRect(0, 0, width, height);
    const finite = this.values.flat().filter(Number.isFinite);
    if (finite.length === 0) return "";
    // An energy that explodes must not flatten all that came before.
    const start = this.values[0]?.filter(Number.isFinite) ?? [];
    const usual = Math.max(1e-9, ...start.map(Math.abs));
    const bound = Math.max(5 * usual, 20);
    const low = Math.max(-bound, Math.min(0, ...finite));
    const high = Math.min(bound, Math.max(0, ...finite));
    const place = (value: number): number =>
      height - 4 - ((value - low) / (high - low || 1)) * (height - 8);
    const style = getComputedStyle(this.canvas);
    context.strokeStyle = style.color;
    context.globalAlpha = 0.4;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(0, place(0));
    context.lineTo(width, place(0));
    context.stroke();
    context.globalAlpha = 1;
    context.lineWidth = 1.5 * scale;
    this.names.forEach((_, n) => {
      context.strokeStyle = this.colour(n, this.names.length);
      context.beginPath();
      this.times.forEach((time, i) => {
        const value = this.values[i]?.[n] ?? NaN;
        if (Number.isFinite(value)) context.lineTo((time / until) * width, place(value));
      });
      context.stroke();
    });
    return `From ${short(low)} to ${short(high)} J, over ${short(until)} s.`;
  }
}
