// Builds the page from src/ and three.js, with the licence of three.js at its head.
//
//   node build.mjs                 lab.js, which the server gives
//   node build.mjs --file FILE     one file that needs no server; the engine is built by cargo for
//                                  wasm32-wasip1 (rustup target add wasm32-wasip1)
//   node build.mjs --check [FILE]  writes nothing, and fails if lab.js or the page in FILE differs
//                                  from the sources; the engine in FILE is not looked at

import { build } from "esbuild";
import { execFileSync } from "node:child_process";
import { readFile, writeFile } from "node:fs/promises";
import { constants, gzipSync } from "node:zlib";

const here = (name) => new URL(name, import.meta.url);
const read = (name) => readFile(here(name), "utf8");
const { version } = JSON.parse(await read("node_modules/three/package.json"));
const licence = (await read("node_modules/three/LICENSE")).trim();
const banner = `/*!
The page of drape lab, built from crates/lab/page by \`npm ci && npm run build\`.
It contains three.js ${version}:

${licence}
*/`;

async function bundle(entry, format, banner) {
  const built = await build({
    absWorkingDir: here(".").pathname,
    entryPoints: [entry],
    bundle: true,
    minify: true,
    format,
    target: "es2022",
    charset: "utf8",
    legalComments: "inline",
    banner: { js: banner },
    write: false,
  });
  return built.outputFiles[0].text;
}

/** What a page without a server may do: nothing outside itself. */
const POLICY =
  "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; " +
  "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'";

/** The page with all that it needs, without its engine. */
async function whole(script) {
  const inside = (text) => text.replaceAll("</script", "<\\/script");
  const worker = await bundle("src/worker.ts", "iife", "");
  const parts = {
    '<link rel="stylesheet" href="lab.css">': `<style>\n${await read("lab.css")}</style>`,
    '<script src="lab.js" type="module"></script>':
      `<meta http-equiv="Content-Security-Policy" content="${POLICY}">\n` +
      `<script type="text/plain" id="worker">${inside(worker)}</script>`,
    "</body>":
      `<script type="text/plain" id="engine">${HOLE}</script>\n` +
      `<script type="module">${inside(script)}</script>\n</body>`,
  };
  let page = await read("lab.html");
  for (const [place, part] of Object.entries(parts)) {
    if (!page.includes(place)) throw new Error(`lab.html has no ${place}`);
    page = page.replace(place, () => part);
  }
  return page;
}

/** Stands for the engine in a page. */
const HOLE = "[engine]";

function engine() {
  const cargo = process.env.CARGO ?? "cargo";
  const root = here("../../../").pathname;
  const simd = "target.wasm32-wasip1.rustflags=['-Ctarget-feature=+simd128']";
  const names = ["-p", "drape-lab-wasm", "--profile", "wasm", "--target", "wasm32-wasip1"];
  execFileSync(cargo, ["build", "-j2", ...names, "--config", simd], { cwd: root, stdio: "inherit" });
  const metadata = ["metadata", "--format-version", "1", "--no-deps"];
  const told = execFileSync(cargo, metadata, { cwd: root, maxBuffer: 1 << 28 });
  return `${JSON.parse(told).target_directory}/wasm32-wasip1/wasm/drape_lab_wasm.wasm`;
}

const [task, file] = process.argv.slice(2);
const script = await bundle("src/lab.ts", "esm", banner);
if (task === "--file") {
  const bytes = gzipSync(await readFile(engine()), { level: constants.Z_BEST_COMPRESSION });
  const page = await whole(script);
  await writeFile(file, page.replace(HOLE, () => bytes.toString("base64")));
} else if (task === "--check") {
  const fail = (sentence) => {
    console.error(`${sentence} in crates/lab/page`);
    process.exitCode = 1;
  };
  if (script !== (await read("lab.js")))
    fail("lab.js differs from its sources: run `npm ci && npm run build`");
  if (file !== undefined) {
    const text = await readFile(file, "utf8");
    const empty = text.replace(/(id="engine">)[A-Za-z0-9+/=]*/, (_, start) => start + HOLE);
    if (empty !== (await whole(script)))
      fail(`${file} differs from its sources: run \`npm ci && npm run file\``);
  }
} else {
  await writeFile(here("lab.js"), script);
}
