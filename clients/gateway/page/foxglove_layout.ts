// SPDX-License-Identifier: Apache-2.0
// A layout of Foxglove and Lichtblick for two axes: state and mode by name, plots in the unit of the axis and in UU,
// events. The build writes it next to the page.

import { OPERATING_MODES, POWER_STATES } from "./src/data/tables";

/** The default names that a bench gives its axes (`vdrived --axes 2`). */
const BENCH = "/bench1";
const AXES = ["axis1", "axis2"];
const WINDOW_S = 10;

const SCRIPT_TYPES = `
type Output = {
  power_state: string;
  mode: string;
  unit: string;
  position: number;
  position_demand: number;
  velocity: number;
  velocity_demand: number;
  following_error: number;
  torque_percent: number;
};
`;

export function scriptTopic(axis: string): string {
  return `/vdrive/${axis}`;
}

/** No topic has names and scaled values, so a script of the layout derives them from the status and the description
 *  of the bench. */
export function scriptOf(axis: string): string {
  const states = POWER_STATES.map(({ name, mask, value }) => ({ name, mask, value }));
  const modes = Object.fromEntries(OPERATING_MODES.map(({ mode, name }) => [mode, name]));
  return `// Names and scaled values of one axis.
export const inputs = ["${BENCH}/${axis}/status", "${BENCH}/description"];
export const output = "${scriptTopic(axis)}";
${SCRIPT_TYPES}
const STATES: { name: string; mask: number; value: number }[] = ${JSON.stringify(states)};
const MODES: Record<number, string> = ${JSON.stringify(modes)};
const PER_TURN: Record<string, number> = { deg: 360, rad: 2 * Math.PI, rev: 1 };
let unit = { kind: "", name: "UU", per: 1 };

export default function script(event: any): Output | undefined {
  if (event.topic === "${BENCH}/description") {
    unit = event.message.axes.find((axis: any) => axis.topic === "${axis}")?.unit ?? unit;
    return undefined;
  }
  const status = event.message;
  const factor = (unit.kind === "rotary" ? PER_TURN[unit.name] ?? 1 : 1) / unit.per;
  const state = STATES.find(({ mask, value }) => (status.ds402_statusword & mask) === value);
  return {
    power_state: state?.name ?? "",
    mode: MODES[status.op_mode_actual] ?? String(status.op_mode_actual),
    unit: unit.name,
    position: status.load_position_actual_value * factor,
    position_demand: status.position_demand_value * factor,
    velocity: status.load_velocity_actual_value * factor,
    velocity_demand: status.velocity_demand_value * factor,
    following_error: status.load_position_error_value * factor,
    torque_percent: status.torque_actual_value / 10,
  };
}
`;
}

interface Path {
  value: string;
  enabled: boolean;
  timestampMethod: "receiveTime";
  label: string;
}

const path = (value: string, label: string): Path => ({ value, enabled: true, timestampMethod: "receiveTime", label });

function plot(title: string, paths: Path[]): object {
  return {
    foxglovePanelTitle: title,
    paths,
    xAxisVal: "timestamp",
    isSynced: true,
    showLegend: true,
    legendDisplay: "floating",
    showXAxisLabels: true,
    showYAxisLabels: true,
    followingViewWidth: WINDOW_S,
  };
}

/** Panels stacked vertically, of equal height. */
function stack(panels: string[]): unknown {
  const [first, ...rest] = panels;
  return rest.length === 0 ? first : { direction: "column", first, second: stack(rest), splitPercentage: 100 / panels.length };
}

export function foxgloveLayout(): object {
  const configById: Record<string, object> = {};
  const states = AXES.flatMap((axis) => [path(`${scriptTopic(axis)}.power_state`, `${axis} state`), path(`${scriptTopic(axis)}.mode`, `${axis} mode`)]);
  configById["StateTransitions!state"] = { foxglovePanelTitle: "State and mode", paths: states, isSynced: true };
  configById["RosOut!events"] = { foxglovePanelTitle: "Events", topicToRender: `${BENCH}/events`, minLogLevel: 1, searchTerms: [] };
  const columns = AXES.map((axis) => {
    const scaled = (members: string[]) => members.map((member) => path(`${scriptTopic(axis)}.${member}`, member));
    const raw = (members: string[]) => members.map((member) => path(`${BENCH}/${axis}/status.${member}`, member));
    const plots = {
      [`Plot!${axis}_position`]: plot(`${axis}: position [unit of the axis]`, scaled(["position_demand", "position"])),
      [`Plot!${axis}_velocity`]: plot(`${axis}: velocity [unit/s]`, scaled(["velocity_demand", "velocity"])),
      [`Plot!${axis}_torque`]: plot(`${axis}: torque [% of rated]`, scaled(["torque_percent"])),
      [`Plot!${axis}_uu`]: plot(`${axis}: position and following error [UU]`, raw(["position_demand_value", "load_position_actual_value", "load_position_error_value"])),
    };
    Object.assign(configById, plots);
    return stack(Object.keys(plots));
  });
  return {
    configById,
    globalVariables: {},
    userNodes: Object.fromEntries(AXES.map((axis) => [`vdrive-${axis}`, { name: `vdrive ${axis}`, sourceCode: scriptOf(axis) }])),
    playbackConfig: { speed: 1 },
    layout: {
      direction: "column",
      first: "StateTransitions!state",
      second: {
        direction: "column",
        first: { direction: "row", first: columns[0], second: columns[1] },
        second: "RosOut!events",
        splitPercentage: 78,
      },
      splitPercentage: 18,
    },
  };
}
