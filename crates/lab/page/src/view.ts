// Pictures of the panes. One WebGL context draws all of them, one after the other, and each is
// copied to the canvas of its pane: browsers allow few contexts.

import {
  AmbientLight,
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  DynamicDrawUsage,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  PerspectiveCamera,
  Points,
  PointsMaterial,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import type { Scenery } from "./messages";

const CLOTH = { light: 0x2f6fb3, dark: 0x6aa5e0 };
const LINES = { light: 0x17395c, dark: 0xcfe3f7 };
const SOLID = { light: 0xb9a184, dark: 0x8d7a63 };
const PIN = { light: 0xb3141d, dark: 0xff8f92 };
const GHOST = { light: 0x1b2126, dark: 0xffffff };
/** Points of the picture around a particle in which it can be gripped. */
const REACH = { mouse: 12, touch: 26 };

const dark = matchMedia("(prefers-color-scheme: dark)");

/** Pictures in a row that must cut a cloth off before its frame grows. */
const PATIENCE = 3;
/** A cloth nearer to the edge of the picture than this, over half its width, counts as cut off. */
const EDGE = 0.04;
/** By how much a frame grows at a time, and how often at most. */
const GROWTH = { factor: 1.04, most: 80 };
/** Particles that are checked for that. */
const SAMPLE = 500;
/** A cloth that is farther away than this, over the size of the scene, has exploded. */
const EXPLODED = 6;
/** The usual distance of the cameras. A person who comes closer wants to see a part. */
const USUAL = 2.1;

/** The part of space that pictures show. Panes with the same scene share one. */
class Framing {
  center = new Vector3();
  size = 1;
  /** The size at the start. */
  private start: number;

  constructor(private box: Box3) {
    this.box.getCenter(this.center);
    const extent = this.box.getSize(new Vector3());
    this.size = Math.max(extent.x, extent.y, extent.z, 1e-3);
    this.start = this.size;
  }

  isBlownUpBy(cloth: Box3): boolean {
    return !this.box.clone().expandByScalar(EXPLODED * this.start).containsBox(cloth);
  }

  /** Looks at the middle of all that was seen, and grows until all of it is in the picture. */
  grow(cloth: Box3, isEnough: () => boolean): void {
    this.box.union(cloth).getCenter(this.center);
    for (let n = 0; n < GROWTH.most && !isEnough(); n++) this.size *= GROWTH.factor;
  }
}

/** The place of all cameras. They are linked, so every pane has the same view. */
export class Camera {
  /** Degrees around the vertical axis and above the horizon. */
  turn = -55;
  rise = 18;
  /** Distance over the size of the scene. */
  distance = USUAL;
  private listeners: (() => void)[] = [];
  private frames = new Map<string, Framing>();

  /** The frame of a scene; the start of its first cloth decides what it shows. */
  frame(scene: string, box: () => Box3): Framing {
    const known = this.frames.get(scene) ?? new Framing(box());
    this.frames.set(scene, known);
    return known;
  }

  /** Forgets all frames: other scenes come. */
  forget(): void {
    this.frames.clear();
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  move(turn: number, rise: number, factor: number): void {
    this.turn += turn;
    this.rise = Math.max(-85, Math.min(85, this.rise + rise));
    this.distance = Math.max(0.3, Math.min(10, this.distance * factor));
    this.tell();
  }

  /** Says that every picture must be drawn again. */
  tell(): void {
    for (const listener of this.listeners) listener();
  }

  /** Lets a canvas turn it by mouse, finger, wheel and keys. */
  steer(canvas: HTMLCanvasElement): void {
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!canvas.hasPointerCapture(event.pointerId)) return;
      this.move(-0.4 * event.movementX, 0.3 * event.movementY, 1);
    });
    canvas.addEventListener(
      "wheel",
      (event) => {
        // Without a key the wheel scrolls the page.
        if (!event.ctrlKey && !event.shiftKey) return;
        event.preventDefault();
        this.move(0, 0, Math.exp(0.002 * (event.deltaY || event.deltaX)));
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => {
      const moves: Record<string, [number, number, number]> = {
        ArrowLeft: [-5, 0, 1],
        ArrowRight: [5, 0, 1],
        ArrowUp: [0, 5, 1],
        ArrowDown: [0, -5, 1],
        "+": [0, 0, 1 / 1.15],
        "=": [0, 0, 1 / 1.15],
        "-": [0, 0, 1.15],
      };
      const move = moves[event.key];
      if (move === undefined || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      this.move(...move);
    });
  }
}

/** The one WebGL context; undefined where the browser has none. */
export class Renderer {
  private constructor(readonly gl: WebGLRenderer) {}

  static make(): Renderer | undefined {
    try {
      const gl = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
      gl.setPixelRatio(1);
      return new Renderer(gl);
    } catch {
      return undefined;
    }
  }
}

/** The cloth and obstacles of one pane. */
export class View {
  private scene = new Scene();
  private camera = new PerspectiveCamera(35, 4 / 3, 0.01, 1000);
  private positions = new BufferAttribute(new Float32Array(0), 3);
  private geometry = new BufferGeometry();
  private cloth = new MeshLambertMaterial({ side: DoubleSide });
  private lines = new LineBasicMaterial();
  private solid = new MeshLambertMaterial({ side: DoubleSide });
  private pin = new PointsMaterial({ size: 7, sizeAttenuation: false });
  private mark = new PointsMaterial({ size: 13, sizeAttenuation: false });
  private wire = new LineBasicMaterial({ transparent: true, opacity: 0.45, depthTest: false });
  private ghostPositions = new BufferAttribute(new Float32Array(0), 3);
  private ghost: LineSegments | undefined;
  private marked: Points | undefined;
  private contents = new Group();
  private moving: Group[] = [];
  private fabric: Mesh | undefined;
  private frame: Framing | undefined;
  /** Whether a picture of this run was drawn. */
  private isShown = false;
  /** Pictures in a row that cut the cloth off. */
  private outside = 0;

  constructor(
    private renderer: Renderer | undefined,
    private canvas: HTMLCanvasElement,
    private linked: Camera,
  ) {
    this.camera.up.set(0, 0, 1);
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(-1, -2, 3);
    this.scene.add(new AmbientLight(0xffffff, 1.3), sun, this.contents);
  }

  /** Takes the parts of a new run of a scene that never change. */
  set(scenery: Scenery, name: string): void {
    this.contents.clear();
    this.geometry.dispose();
    this.geometry = new BufferGeometry();
    this.positions = new BufferAttribute(new Float32Array(3 * scenery.particles), 3);
    this.positions.setUsage(DynamicDrawUsage);
    this.geometry.setAttribute("position", this.positions);
    this.geometry.setIndex(scenery.triangles);
    const part = (index: number[]): BufferGeometry => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", this.positions);
      geometry.setIndex(index);
      return geometry;
    };
    this.fabric = new Mesh(this.geometry, this.cloth);
    const parts = [
      this.fabric,
      new LineSegments(part(scenery.lines), this.lines),
      new Points(part(scenery.pins), this.pin),
    ];
    for (const object of parts) {
      object.frustumCulled = false;
      this.contents.add(object);
    }
    this.ghostPositions = new BufferAttribute(new Float32Array(3 * scenery.particles), 3);
    this.ghostPositions.setUsage(DynamicDrawUsage);
    const wires = new BufferGeometry();
    wires.setAttribute("position", this.ghostPositions);
    wires.setIndex(scenery.lines);
    this.ghost = new LineSegments(wires, this.wire);
    this.ghost.visible = false;
    this.marked = new Points(part([]), this.mark);
    for (const object of [this.ghost, this.marked]) {
      object.frustumCulled = false;
      object.renderOrder = 1;
      this.contents.add(object);
    }
    this.moving = [];
    for (const solid of scenery.solids) {
      const geometry = new BufferGeometry();
      geometry.setAttribute(
        "position",
        new BufferAttribute(new Float32Array(solid.points.flat()), 3),
      );
      geometry.setIndex(solid.triangles);
      geometry.computeVertexNormals();
      const group = new Group();
      group.add(new Mesh(geometry, this.solid));
      this.contents.add(group);
      if (solid.is_moving) this.moving.push(group);
    }
    // Not from the first picture: a busy browser draws it late, and by then the cloth may have
    // exploded.
    const [low, high] = scenery.extent;
    const start = new Box3(new Vector3(...low), new Vector3(...high));
    this.frame = this.linked.frame(name, () => View.around(start));
    this.isShown = false;
    this.outside = 0;
  }

  /** Shows these positions. */
  show(positions: Float32Array, offsets: [number, number, number][]): void {
    if (positions.length !== this.positions.array.length) return;
    (this.positions.array as Float32Array).set(positions);
    this.positions.needsUpdate = true;
    this.follow(positions);
    this.moving.forEach((group, i) => group.position.set(...(offsets[i] ?? [0, 0, 0])));
    this.draw();
  }

  /** Lays a reference over the cloth, or takes it away. The next picture shows it. */
  showGhost(positions: Float32Array | undefined): void {
    if (this.ghost === undefined) return;
    this.ghost.visible = positions?.length === this.ghostPositions.array.length;
    if (!this.ghost.visible || positions === undefined) return;
    (this.ghostPositions.array as Float32Array).set(positions);
    this.ghostPositions.needsUpdate = true;
  }

  /** Marks the particle that is led, or none. The next picture shows it. */
  grip(particle: number | undefined): void {
    this.marked?.geometry.setIndex(particle === undefined ? [] : [particle]);
  }

  /** A particle's place on the canvas, in points from its upper left corner, and its depth, m. */
  private project(particle: number): { x: number; y: number; depth: number } {
    const box = this.canvas.getBoundingClientRect();
    const place = new Vector3().fromBufferAttribute(this.positions, particle);
    const depth = -place.clone().applyMatrix4(this.camera.matrixWorldInverse).z;
    place.project(this.camera);
    return { x: (0.5 + 0.5 * place.x) * box.width, y: (0.5 - 0.5 * place.y) * box.height, depth };
  }

  /** The particle under a place of the canvas, in points; of several the foremost. */
  pick(x: number, y: number, isTouch: boolean): number | undefined {
    const reach = isTouch ? REACH.touch : REACH.mouse;
    let found: { particle: number; cost: number } | undefined;
    for (let particle = 0; particle < this.positions.count; particle++) {
      const at = this.project(particle);
      const off = Math.hypot(at.x - x, at.y - y);
      if (off > reach || at.depth <= 0) continue;
      // Near the pointer first; a particle behind the cloth only if it is much nearer there.
      const cost = off / reach + at.depth / (this.frame?.size ?? 1);
      if (found === undefined || cost < found.cost) found = { particle, cost };
    }
    return found?.particle;
  }

  /** The lowest particle: what the keyboard grips. */
  lowest(): number | undefined {
    let found: number | undefined;
    for (let particle = 0; particle < this.positions.count; particle++)
      if (found === undefined || this.positions.getZ(particle) < this.positions.getZ(found))
        found = particle;
    return found;
  }

  /** A way on the canvas, in points to the right and down, as one in the scene at a particle's
   *  depth, m. */
  way(particle: number, right: number, down: number): [number, number, number] {
    const height = this.canvas.getBoundingClientRect().height || 1;
    const angle = (this.camera.fov * Math.PI) / 360;
    const scale = (2 * Math.tan(angle) * this.project(particle).depth) / height;
    const axes = [new Vector3(), new Vector3(), new Vector3()] as const;
    this.camera.matrixWorld.extractBasis(...axes);
    const way = axes[0].multiplyScalar(right * scale).addScaledVector(axes[1], -down * scale);
    return [way.x, way.y, way.z];
  }

  /** The space in which a cloth will move that begins here. */
  private static around(cloth: Box3): Box3 {
    const extent = cloth.getSize(new Vector3());
    const size = Math.max(extent.x, extent.y, extent.z, 1e-3);
    const box = cloth.clone();
    // A sheet that starts flat will fall by about its own size.
    if (extent.z < 0.3 * size) box.min.z -= 0.75 * size;
    return box;
  }

  /** Whether the last picture's camera sees all of the cloth. */
  private seesAll(): boolean {
    const count = this.positions.count;
    const point = new Vector3();
    for (let i = 0; i < count; i += Math.ceil(count / SAMPLE)) {
      point.fromBufferAttribute(this.positions, i).project(this.camera);
      if (Math.max(Math.abs(point.x), Math.abs(point.y)) > 1 - EDGE) return false;
    }
    return true;
  }

  /** Lets the frame grow with a cloth that leaves it. */
  private follow(positions: Float32Array): void {
    const { frame } = this;
    if (frame === undefined) return;
    const cloth = new Box3().setFromArray(positions);
    const isFirst = !this.isShown;
    this.isShown = true;
    const hasExploded = frame.isBlownUpBy(cloth);
    // Of a cloth that has exploded only the wires say something.
    if (this.fabric !== undefined) this.fabric.visible = !hasExploded;
    const isLed = (this.marked?.geometry.index?.count ?? 0) > 0;
    const mayGrow = !isFirst && !hasExploded && !isLed && this.linked.distance >= USUAL;
    this.outside = mayGrow && !this.seesAll() ? this.outside + 1 : 0;
    if (this.outside < PATIENCE) return;
    this.outside = 0;
    frame.grow(cloth, () => {
      this.aim(frame);
      return this.seesAll();
    });
    this.linked.tell();
  }

  /** Lets the camera show a frame. */
  private aim({ center, size } = { center: new Vector3(), size: 1 }): void {
    const turn = (this.linked.turn * Math.PI) / 180;
    const rise = (this.linked.rise * Math.PI) / 180;
    const distance = this.linked.distance * size * 1.25;
    this.camera.position.set(
      center.x + distance * Math.cos(rise) * Math.cos(turn),
      center.y + distance * Math.cos(rise) * Math.sin(turn),
      center.z + distance * Math.sin(rise),
    );
    this.camera.lookAt(center);
    this.camera.near = distance * 0.01;
    this.camera.far = distance * 100;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  /** Draws the present positions. */
  draw(): void {
    const { renderer, canvas } = this;
    const box = canvas.getBoundingClientRect();
    const scale = Math.min(devicePixelRatio, 2);
    const [width, height] = [Math.round(box.width * scale), Math.round(box.height * scale)];
    if (renderer === undefined || width === 0 || height === 0) return;
    if (canvas.width !== width || canvas.height !== height)
      [canvas.width, canvas.height] = [width, height];
    const scheme = dark.matches ? "dark" : "light";
    this.cloth.color = new Color(CLOTH[scheme]);
    this.lines.color = new Color(LINES[scheme]);
    this.solid.color = new Color(SOLID[scheme]);
    this.pin.color = new Color(PIN[scheme]);
    this.mark.color = new Color(PIN[scheme]);
    this.wire.color = new Color(GHOST[scheme]);
    if (this.geometry.index !== null && this.geometry.index.count > 0)
      this.geometry.computeVertexNormals();
    this.camera.aspect = width / height;
    this.aim(this.frame);
    renderer.gl.setSize(width, height, false);
    renderer.gl.render(this.scene, this.camera);
    const context = canvas.getContext("2d");
    context?.clearRect(0, 0, width, height);
    context?.drawImage(renderer.gl.domElement, 0, 0);
  }
}
