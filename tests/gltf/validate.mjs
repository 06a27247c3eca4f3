// Usage: node validate.mjs FOLDER FILE…   with gltf-validator in FOLDER/node_modules
// Fails where Khronos' validator has an error or a warning; infos and hints are only printed.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, resolve } from "node:path";

const [folder, ...files] = process.argv.slice(2);
const validator = createRequire(resolve(folder, "package.json"))("gltf-validator");
let faults = 0;
for (const file of files) {
  const beside = async uri => new Uint8Array(readFileSync(resolve(dirname(file), decodeURIComponent(uri))));
  const options = { uri: file, maxIssues: 100, externalResourceFunction: beside };
  const { issues, info } = await validator.validateBytes(new Uint8Array(readFileSync(file)), options);
  console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos, ` +
    `${issues.numHints} hints; ${info?.totalVertexCount} vertices, ${info?.maxInfluences} influences`);
  for (const { severity, code, message, pointer } of issues.messages)
    console.log(`  ${["error", "warning", "info", "hint"][severity]} ${code}: ${message} (${pointer})`);
  faults += issues.numErrors + issues.numWarnings;
}
process.exit(faults === 0 && files.length > 0 ? 0 : 1);
