// SPDX-License-Identifier: Apache-2.0
// Compares the documents of YAML files with the schemas of Kubernetes and of the Prometheus
// operator:
//
//   node judge.mjs FILE...
//
// Values are checked against the schemas. The schemas permit unknown keys, such as misspelt ones;
// these are refused by TypeScript, with types generated from the same schemas. Prints a line for
// each mistake, or the number of documents if there is none.
import {execFileSync} from "node:child_process";
import {readFileSync, writeFileSync} from "node:fs";
import {parseAllDocuments} from "yaml";

/// The module of the packages that contains a kind. The core API has no group.
function moduleOf({apiVersion, kind}) {
  const [version, group] = apiVersion.split("/").reverse();
  const home = group === "monitoring.coreos.com" ? "@kubernetes-models/prometheus-operator" : "kubernetes-models";
  return [home, group, version, kind].filter(Boolean).join("/");
}

const mistakes = [];
const places = []; // of the lines in the program
let program = "";
for (const file of process.argv.slice(2)) {
  for (const parsed of parseAllDocuments(readFileSync(file, "utf8"))) {
    for (const error of parsed.errors) mistakes.push(`${file}: ${error.message}`);
    const document = parsed.toJS();
    if (document === null) continue;
    const place = `${file}: ${document.kind} ${document.metadata?.name}`;
    try {
      const model = await import(moduleOf(document)).then((module) => module[document.kind] ?? module.default[document.kind]);
      new model(document).validate();
    } catch (error) {
      mistakes.push(`${place}: ${error.message}`);
      continue;
    }
    program += `{const it: import("${moduleOf(document)}").I${document.kind} = ${JSON.stringify(document)}}\n`;
    places.push(place);
  }
}

writeFileSync("documents.ts", program);
try {
  execFileSync("node", ["node_modules/typescript/bin/tsc", "--noEmit", "--strict", "--skipLibCheck", "--module", "nodenext", "--pretty", "false", "documents.ts"]);
} catch (error) {
  for (const [, line, text] of error.stdout.toString().matchAll(/^documents\.ts\((\d+),.*: (.*)$/gm)) {
    mistakes.push(`${places[line - 1]}: ${text}`);
  }
  if (mistakes.length === 0) mistakes.push(error.stdout.toString());
}
for (const mistake of mistakes) console.log(mistake);
if (mistakes.length === 0) console.log(`${places.length} documents`);
process.exit(mistakes.length === 0 ? 0 : 1);
