// Checks GLB files with the Khronos validator: node benchmarks/validate_gltf.js FILE.glb ...
// Needs the npm package gltf-validator, here or in a folder named by NODE_PATH.
"use strict";
const fs = require("fs");

let validator;
try {
  validator = require("gltf-validator");
} catch {
  console.log("skipped: the npm package gltf-validator is not installed");
  process.exit(0);
}

(async () => {
  let worst = 0;
  for (const file of process.argv.slice(2)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
    const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
    console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, `
      + `${numHints} hints; ${report.info.totalVertexCount} vertices`);
    for (const message of messages.slice(0, 10)) console.log("  " + message.pointer, message.message);
    worst = Math.max(worst, numErrors);
  }
  process.exit(worst ? 1 : 0);
})();
