// Scenes and meshes from a person's disk. The page keeps them, so that it can give them again to a
// server that was started anew.

import type { Limits } from "./messages";

/** Prefix of a file's name where the name of a scene is expected. */
export const PREFIX = "file:";

/** A file as a message: the length of its name, the name, the content. */
function message(name: string, content: Uint8Array): Uint8Array<ArrayBuffer> {
  const own = new TextEncoder().encode(name);
  const bytes = new Uint8Array(4 + own.length + content.length);
  new DataView(bytes.buffer).setUint32(0, own.length, true);
  bytes.set(own, 4);
  bytes.set(content, 4 + own.length);
  return bytes;
}

/** Scenes come after the meshes that they read. */
function order(names: string[]): string[] {
  const isMesh = (name: string): boolean => /\.obj$/i.test(name);
  return [...names.filter(isMesh), ...names.filter((name) => !isMesh(name))];
}

export class Shelf {
  private contents = new Map<string, Uint8Array>();

  has(scene: string): boolean {
    return !scene.startsWith(PREFIX) || this.contents.has(scene.slice(PREFIX.length));
  }

  /** Takes files and gives them to the server. Returns the name of the last; it is the scene. */
  async take(
    files: File[],
    limits: Limits,
    send: (bytes: Uint8Array<ArrayBuffer>) => void,
    complain: (sentence: string) => void,
  ): Promise<string | undefined> {
    const names: string[] = [];
    for (const file of files) {
      const most = Math.max(limits.file_bytes, limits.mesh_bytes);
      if (file.size > most) {
        complain(`${file.name} is ${file.size} bytes long; expected at most ${most} bytes.`);
        return undefined;
      }
      try {
        this.contents.set(file.name, new Uint8Array(await file.arrayBuffer()));
        names.push(file.name);
      } catch {
        complain(`${file.name} cannot be read; expected a file, not a folder.`);
        return undefined;
      }
    }
    return this.give(order(names), send);
  }

  /** Forgets a file that was refused. */
  forget(name: string): void {
    this.contents.delete(name);
  }

  /** Gives all files again. Returns the name of the last. */
  giveAll(send: (bytes: Uint8Array<ArrayBuffer>) => void): string | undefined {
    return this.give(order([...this.contents.keys()]), send);
  }

  private give(
    names: string[],
    send: (bytes: Uint8Array<ArrayBuffer>) => void,
  ): string | undefined {
    for (const name of names) {
      const content = this.contents.get(name);
      if (content !== undefined) send(message(name, content));
    }
    return names[names.length - 1];
  }
}
