// Runs Khronos' glTF validator: node validate_glb.mjs FOLDER_WITH_node_modules FILE.glb
// Prints every issue. Exit code 0: no errors and no warnings; 1: some; 77: the validator is not installed.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const [folder, file] = process.argv.slice(2);
let validator;
try {
  validator = createRequire(join(folder, 'package.json'))('gltf-validator');
} catch {
  console.log(`SKIPPED: gltf-validator is not installed in ${folder}`);
  process.exit(77);
}
const bytes = new Uint8Array(readFileSync(file));
const report = await validator.validateBytes(bytes, { maxIssues: 100, writeTimestamp: false });
for (const issue of report.issues.messages) {
  console.log(`${issue.code} (severity ${issue.severity}): ${issue.message} ${issue.pointer ?? ''}`);
}
process.exit(report.issues.numErrors + report.issues.numWarnings > 0 ? 1 : 0);
