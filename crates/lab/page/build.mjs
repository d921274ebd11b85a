// Builds lab.js from src/ and three.js, with the licence of three.js at its head. With --check it
// writes nothing and fails if the committed file differs.

import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";

const file = new URL("lab.js", import.meta.url);
const licence = await readFile(new URL("node_modules/three/LICENSE", import.meta.url), "utf8");
const { version } = JSON.parse(
  await readFile(new URL("node_modules/three/package.json", import.meta.url), "utf8"),
);
const banner = `/*!
The page of drape lab, built from crates/lab/page by \`npm ci && npm run build\`.
It contains three.js ${version}:

${licence.trim()}
*/`;
const built = await build({
  absWorkingDir: new URL(".", import.meta.url).pathname,
  entryPoints: ["src/lab.ts"],
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  charset: "utf8",
  legalComments: "inline",
  banner: { js: banner },
  write: false,
});
const text = built.outputFiles[0].text;
if (process.argv.includes("--check")) {
  if (text !== (await readFile(file, "utf8"))) {
    console.error(
      "lab.js differs from its sources: run `npm ci && npm run build` in crates/lab/page",
    );
    process.exit(1);
  }
} else {
  await writeFile(file, text);
}
