// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import ts from "typescript";
import { foxgloveLayout, scriptOf, scriptTopic } from "../foxglove_layout";

const layout = JSON.parse(JSON.stringify(foxgloveLayout())) as {
  configById: Record<string, { paths?: { value: string }[] }>;
  userNodes: Record<string, { sourceCode: string }>;
  layout: unknown;
};

/** A script of the layout as Foxglove runs it. */
function run(source: string): { output: string; inputs: string[]; script: (event: object) => Record<string, unknown> | undefined } {
  const { outputText } = ts.transpileModule(source, { compilerOptions: { module: ts.ModuleKind.CommonJS, target: ts.ScriptTarget.ES2022 } });
  const made: Record<string, unknown> = {};
  new Function("exports", outputText)(made);
  return { output: made["output"] as string, inputs: made["inputs"] as string[], script: made["default"] as never };
}

const STATUS = {
  ds402_statusword: 0x1637, op_mode_actual: 1, load_position_actual_value: 1024, position_demand_value: 2048,
  load_velocity_actual_value: -4096, velocity_demand_value: 0, load_position_error_value: 0, torque_actual_value: -123,
};
const described = (unit: object) => ({ topic: "/bench1/description", message: { axes: [{ topic: "axis1", unit }] } });

test("each panel of the layout has a place in it, once", () => {
  const places: string[] = [];
  const visit = (node: unknown): void => {
    if (typeof node === "string") places.push(node);
    else for (const key of ["first", "second"]) visit((node as Record<string, unknown>)[key]);
  };
  visit(layout.layout);
  assert.deepEqual(places.sort(), Object.keys(layout.configById).sort());
});

test("the script of an axis gives names for state and mode, and values in its unit", () => {
  const { output, script } = run(scriptOf("axis1"));
  assert.equal(output, scriptTopic("axis1"));
  assert.equal(script({ topic: "/bench1/axis1/status", message: STATUS })?.["position"], 1024, "UU before the unit is known");
  assert.equal(script(described({ kind: "rotary", name: "deg", per: 4096 })), undefined);
  // A quarter of a turn, and one turn per second backwards.
  assert.deepEqual(script({ topic: "/bench1/axis1/status", message: STATUS }), {
    power_state: "Operation enabled", mode: "profile position", unit: "deg", position: 90, position_demand: 180,
    velocity: -360, velocity_demand: 0, following_error: 0, torque_percent: -12.3,
  });
  script(described({ kind: "linear", name: "mm", per: 1000 }));
  assert.equal(script({ topic: "/bench1/axis1/status", message: STATUS })?.["position"], 1.024);
});

test("panels show what the scripts give", () => {
  for (const { sourceCode } of Object.values(layout.userNodes)) {
    const { output, inputs, script } = run(sourceCode);
    const given = Object.keys(script({ topic: inputs[0], message: STATUS }) ?? {});
    const shown = Object.values(layout.configById).flatMap(({ paths = [] }) => paths.map(({ value }) => value));
    const own = shown.filter((value) => value.startsWith(`${output}.`));
    assert.ok(own.length > 5);
    for (const value of own) assert.ok(given.includes(value.slice(output.length + 1)), value);
  }
});
