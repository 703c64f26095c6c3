// SPDX-License-Identifier: Apache-2.0
// Every text of the page in English and Chinese.

import { POWER_STATE_NAMES, type PowerState } from "./data/power";
import { BIT_NAMES, OPERATING_MODES } from "./data/tables";

export type Language = "en" | "zh";

const TEXTS = {
  overview: ["Overview", "总览"],
  axis: ["Axis", "轴"],
  scope: ["Scope", "示波器"],
  control: ["Control", "控制"],
  stop: ["STOP", "停止"],
  stop_hint: [
    "Quick stop of every axis of every bench (Ctrl + . at any time)",
    "所有台架的所有轴快速停机（随时按 Ctrl + .）",
  ],
  connected: ["connected", "已连接"],
  connecting: ["no connection", "未连接"],
  lost_banner: [
    "No connection to the gateway. The values shown are old. The page reconnects automatically.",
    "与网关的连接已断开，显示的是旧数据。页面会自动重新连接。",
  ],
  left_out: [
    "messages were dropped: this page could not keep up",
    "条消息被丢弃：本页处理速度低于接收速度",
  ],
  bench_silent: ["has sent nothing for", "无数据"],
  bench_gone: [
    "sends nothing: its axes cannot be commanded until it returns.",
    "无数据：无法控制其轴。恢复后页面自动继续。",
  ],
  another_run: ["bench restarted at", "台架已重新启动，时间"],
  taken_away: ["no longer controlled by this page", "不再由本页控制"],
  lost_by_silence: ["no longer controlled by this page; nobody took them:", "不再由本页控制，也未被接管："],
  was_taken: ["taken from this page, press 'Take it back' above first", "已被接管，请先按上方的“取回”"],
  take_back: ["Take it back", "取回"],
  now_by: ["now controlled by", "现由其控制："],
  session: ["session", "会话"],
  moves_on: ["Moving or applying torque under the control of this page; this continues after the page is closed", "在本页控制下运动或施加转矩，关闭页面后将继续"],
  moves_free: ["Moving or applying torque with no one in control (take control, or press STOP)", "正在运动或施加转矩且无人控制（请获取控制权或按停止）"],
  second_press: ["second press within 0.5 s ignored", "0.5 秒内的第二次按键已忽略"],
  no_axis: ["No such axis:", "不存在轴"],
  no_benches: ["No bench on this network yet. It appears here when its service starts.", "网络上尚无台架。服务启动后会显示在这里。"],
  no_rows: ["No axis matches the search and the filters.", "没有符合搜索和筛选条件的轴。"],
  search: ["Search", "搜索"],
  search_axes: ["Name or address", "名称或地址"],
  all_benches: ["All benches", "全部台架"],
  faulted: ["Faulted", "故障"],
  moving: ["Moving", "运动中"],
  owned: ["Owned", "已占用"],
  sort_by: ["Sort by", "排序"],
  axes: ["axes", "个轴"],
  chosen: ["selected", "已选"],
  choose: ["Select", "选择"],
  choose_shown: ["Select all axes shown", "选择所有显示的轴"],
  address: ["Axis", "轴"],
  name: ["Name", "名称"],
  state: ["State", "状态"],
  mode: ["Mode", "模式"],
  position: ["Position", "位置"],
  velocity: ["Velocity", "速度"],
  torque: ["Torque", "转矩"],
  error: ["Foll. error", "跟随误差"],
  trend: ["Position, 10 s", "位置 10 秒"],
  owner: ["Owner", "占用者"],
  fault: ["Fault", "故障"],
  age: ["Age", "时效"],
  enabled: ["Enabled", "已使能"],
  enabled_hint: ["Operation enabled", "运行使能"],
  homed: ["Homed", "已回零"],
  homed_hint: [
    "When this page saw the axis find home. ? = not seen in homing mode; other modes do not show it. Lost at a power cycle",
    "本页所见的回零时间。? = 未见该轴处于回零模式：其他模式下没有对象显示。断电重启后失效",
  ],
  limits: ["Limits", "限位"],
  limits_hint: ["Limit switches (60FDh bits 0 and 1) and internal limit active (6041h bit 11)", "限位开关（60FDh 位 0、1）和状态字位 11（内部限位有效）"],
  bit_11: ["bit 11", "位 11"],
  yes: ["yes", "是"],
  no: ["no", "否"],
  none: ["none", "无"],
  free: ["free", "空闲"],
  this_page: ["this page", "本页"],
  theme: ["Theme", "主题"],
  theme_auto: ["auto", "自动"],
  theme_light: ["light", "浅色"],
  theme_dark: ["dark", "深色"],
  language: ["Language", "语言"],
  units: ["Units", "单位"],
  units_user: ["UU", "UU"],
  units_axis: ["deg / mm", "° / mm"],
  window: ["Window", "时间窗"],
  pause_plots: ["Pause", "冻结"],
  go_on: ["Live", "实时"],
  reset_zoom: ["Reset zoom", "复位缩放"],
  plot_hint: [
    "Drag to pan, Shift + drag or Ctrl + wheel to zoom, double-click to reset; space pauses",
    "拖动平移，Shift + 拖动或 Ctrl + 滚轮缩放，双击恢复；空格键冻结",
  ],
  cursor: ["Cursor", "光标"],
  two_cursors: ["Cursors A, B", "光标 A、B"],
  two_cursors_hint: [
    "Two cursors and the differences between them. Click to move the nearer one; drag A and B, or use the arrow keys",
    "两个光标及其差值。单击移动较近的光标；拖动 A 和 B，或用方向键移动",
  ],
  time: ["Time", "时间"],
  minimum: ["Minimum", "最小值"],
  maximum: ["Maximum", "最大值"],
  mean: ["Mean", "平均值"],
  rise: ["Rise", "上升时间"],
  overshoot: ["Overshoot", "超调"],
  settling: ["Settling", "调节时间"],
  measures_hint: [
    "Between A and B. For a step: rise time from 10 % to 90 %, and settling time from the earlier cursor until the signal stays within 2 % of its final value",
    "A 与 B 之间。信号为阶跃时：上升时间为 10 % 至 90 %，调节时间从较早的光标起至保持在终值 2 % 以内",
  ],
  signal: ["Signal", "信号"],
  add_signal: ["Signals", "信号"],
  add: ["Add", "添加"],
  preset: ["Reset signals", "恢复初始"],
  no_signal: ["has no signal", "没有信号"],
  no_signals: ["No signals shown: add some with Signals.", "未显示信号：请通过“信号”添加。"],
  most_axes: ["Axes not shown; the limit of a scope is", "以下轴未显示，示波器最多显示的轴数为"],
  bad_link: ["Parts of the link cannot be read", "链接中有无法识别的部分"],
  move_up: ["Move up", "上移"],
  move_down: ["Move down", "下移"],
  print: ["Print", "打印"],
  open_recording: ["Open a recording", "打开记录"],
  open_recording_hint: ["MCAP or CSV file from vdrive record, up to 256 MiB; you can also drop a file here", "vdrive record 的 MCAP 或 CSV，最大 256 MiB；也可拖放文件到此处"],
  close_recording: ["Back to the benches", "返回台架"],
  trigger: ["Trigger", "触发"],
  trigger_single: ["single", "单次"],
  trigger_normal: ["normal", "普通"],
  condition: ["Condition", "条件"],
  when_rising: ["rises to", "上升至"],
  when_falling: ["falls to", "下降至"],
  when_above: ["is at or above", "不低于"],
  when_below: ["is at or below", "不高于"],
  when_bit_set: ["bit becomes 1", "位变为 1"],
  when_bit_cleared: ["bit becomes 0", "位变为 0"],
  when_event: ["event", "事件"],
  event_text: ["Text of the event", "事件文本"],
  level: ["Level", "电平"],
  before_trigger: ["before the trigger", "触发前"],
  arm: ["Arm", "启动"],
  disarm: ["Stop waiting", "停止等待"],
  trigger_waits: ["waiting", "等待中"],
  trigger_fills: ["triggered, recording the rest of the window", "已触发，等待后续数据"],
  trigger_finds_none: ["not found", "未找到"],
  triggered: ["Triggered at", "触发于"],
  every_tick: ["Every tick, from the black box", "从黑匣子取得每个周期"],
  every_tick_hint: ["The bench keeps 2 s before the trigger and 0.5 s after it, and they are shown as a recording; needs control", "试验台保存触发前 2 s 和触发后 0.5 s，并作为记录显示；需要控制权"],
  open_in_scope: ["Open in the scope", "在示波器中打开"],
  last_run: ["Last run", "上次运行"],
  marks: ["Marks", "标记"],
  mark_state: ["state", "状态"],
  mark_fault: ["fault", "故障"],
  mark_event: ["event", "事件"],
  go_to_event: ["Show the plots at this time", "在曲线中显示此时刻"],
  no_samples: ["this page has no samples of the axis from that time", "本页未收到该轴此时的数据"],
  tick: ["tick", "周期"],
  missed: ["ticks lost", "丢失周期"],
  statusword: ["Statusword 6041h", "状态字 6041h"],
  controlword: ["Controlword 6040h", "控制字 6040h"],
  controlword_source: ["read 5 times a second", "每秒读取 5 次"],
  bit: ["bit", "位"],
  power_machine: ["Power state machine", "电源状态机"],
  last_way: ["Last transitions", "最近转换"],
  no_way: ["no change yet", "尚无转换"],
  handshake: ["Set-points", "设定点"],
  bit4: ["4 new", "4 新设定"],
  bit12: ["12 ack", "12 应答"],
  bit10: ["10 reached", "10 到达"],
  handshake_hint: [
    "Bit 4 of the controlword is polled 5 times a second; bits 12 and 10 of the statusword are recorded in every tick",
    "控制字位 4 每秒读取 5 次；状态字位 12 和位 10 为每个周期的值",
  ],
  held: ["active + waiting", "执行中 + 等待"],
  held_hint: [
    "Set-points that the drive holds. ? = unknown: while bit 4 is 1, controlword and statusword do not show whether one is waiting",
    "驱动器持有的设定点。? = 位 4 为 1 时控制字和状态字无法说明是否有等待的设定点",
  ],
  any_state: ["any state", "任意状态"],
  accepted: ["accepted", "已接受"],
  ignored: ["ignored", "已忽略"],
  reached: ["reached", "已到达"],
  events: ["Events", "事件"],
  faults: ["Faults", "故障"],
  last_fault: ["Last fault", "最近故障"],
  fault_waits: ["The bench is recomputing the ticks around this fault.", "台架正在重新计算。"],
  writes: ["Objects written", "写入记录"],
  judge: ["Judge the master", "评判主站"],
  judge_hint: ["While this is open, the gateway judges the programs that command the axes of this bench", "展开期间，网关评判各程序对本台架各轴的操作"],
  judge_absent: ["This gateway cannot judge.", "该网关不支持评判。"],
  judge_waits: ["Waiting for the judge.", "等待评判。"],
  judge_none: ["No findings yet.", "尚无发现。"],
  judge_found: ["Findings, worst first:", "发现，最严重者在前："],
  severity_error: ["error", "错误"],
  severity_warning: ["warning", "警告"],
  severity_advice: ["advice", "建议"],
  no_events: ["No events yet.", "尚无事件。"],
  no_such_events: ["No event matches the filters.", "没有符合筛选条件的事件。"],
  search_events: ["Axis, kind or text", "轴、类型或文本"],
  level_of_event: ["Level", "级别"],
  all_levels: ["All levels", "所有级别"],
  from_level_3: ["Warnings and errors", "警告和错误"],
  from_level_4: ["Errors", "错误"],
  all_sessions: ["All sessions", "所有会话"],
  save_events: ["Save these events as CSV", "将这些事件保存为 CSV"],
  objects: ["Objects", "对象字典"],
  search_objects: ["Index, name or variable", "索引、名称或变量"],
  object: ["Object", "对象"],
  value: ["Value", "数值"],
  unit: ["Unit", "单位"],
  range: ["Range", "范围"],
  default_value: ["Default", "默认值"],
  access: ["Access", "访问"],
  write: ["Write", "写入"],
  edit: ["Edit", "编辑"],
  cancel: ["Cancel", "取消"],
  csv: ["CSV", "CSV"],
  png: ["PNG", "PNG"],
  plots: ["Plots", "曲线"],
  drive: ["Drive", "驱动器"],
  choose_axis: ["Select an axis in the overview.", "请在总览中选择一个轴。"],
  view_only: ["This gateway is view-only: start it with --control to command axes.", "网关仅供查看：以 --control 启动后方可控制。"],
  view_only_short: ["View only", "仅查看"],
  take: ["Take control", "获取控制权"],
  take_by_force: ["Take control from", "接管控制权："],
  has_had_it_since: ["in control since", "其持有自"],
  nothing_moves: ["None of its axes is moving.", "其各轴均未运动。"],
  moves_unknown: ["Motion unknown: for benches with many axes it is shown only in Overview and Control.", "轴数较多的台架，其运动情况仅在总览和控制视图中显示。"],
  moves_now: ["Moving now", "正在运动"],
  control_taken: ["control was taken from this page by", "本页的控制权已被接管："],
  release: ["Release control", "释放控制权"],
  you_hold: ["You have control", "您持有控制权"],
  held_by: ["Control is held by", "控制权持有者："],
  nobody_holds: ["Nobody has control", "无人持有控制权"],
  need_control: ["Take control to command axes.", "获取控制权后方可控制轴。"],
  control_lost: [
    "The connection to the gateway was lost, so control was lost too.",
    "与网关的连接已断开，控制权随之失去。",
  ],
  silence: ["Counts as lost after", "视为丢失的静默时间"],
  silence_hint: [
    "If the page that holds control stops for this long, it counts as a lost master. A hidden tab may freeze for seconds: with 10 s it keeps control.",
    "持有控制权的页面停止运行超过此时间即视为主站丢失。隐藏的标签页可能停顿数秒：10 秒可保留其控制权。",
  ],
  silence_of_holder: ["counts as lost after", "其静默时限"],
  on_loss: ["then the axes react by 6007h", "随后按 6007h"],
  axes_read: ["axes read so far", "个轴已读取"],
  abort_0: ["no reaction", "无反应"],
  abort_1: ["fault 8130h", "故障 8130h"],
  abort_2: ["voltage off", "切断电压"],
  abort_3: ["quick stop", "快速停机"],
  power: ["Power", "电源"],
  enable: ["Enable", "使能"],
  disable: ["Disable", "去使能"],
  reset: ["Reset fault", "故障复位"],
  motion: ["Motion", "运动"],
  move: ["Move", "移动"],
  move_to: ["Move to", "移动到"],
  moves: ["moving", "运动中"],
  home_found: ["home found", "已找到原点"],
  ended_at: ["ended at", "结束于"],
  other_set_point: ["another set-point,", "另一设定点"],
  by_halt: ["halt; Resume continues it", "暂停；按“继续”恢复"],
  by_software_limit: ["software limit (607Dh)", "软件限位 (607Dh)"],
  by_positive_limit: ["positive limit switch", "正限位开关"],
  by_negative_limit: ["negative limit switch", "负限位开关"],
  by_homing_error: ["homing error (bit 13)", "回零错误（位 13）"],
  by_interrupted: ["interrupted", "被中断"],
  by_lost: ["this page lost control and cannot see how the motion continued", "本页已失去控制权，无法看到后续情况"],
  relative: ["relative", "相对"],
  queue: ["queue", "排队"],
  acceleration: ["Acceleration", "加速度"],
  deceleration: ["Deceleration", "减速度"],
  as_set: ["unchanged", "保持设定"],
  halt: ["Halt", "暂停"],
  resume: ["Resume", "继续"],
  quick_stop: ["Quick stop", "快速停机"],
  home: ["Home", "回零"],
  homing_method: ["Homing method (6098h)", "回零方式 (6098h)"],
  to_limit_switch: ["limit switch", "限位开关"],
  to_home_switch: ["home switch", "原点开关"],
  to_hard_stop: ["mechanical stop", "机械挡块"],
  to_index_pulse: ["index pulse", "索引脉冲"],
  home_here: ["current position", "当前位置"],
  error_window: ["window 6065h", "窗口 6065h"],
  new_window: ["new", "新值"],
  no_value: ["No value given", "未输入数值"],
  jog: ["Jog", "点动"],
  jog_hint: ["Hold the button; the axis stops when you release it", "按住按钮运动，松开即停"],
  jog_minus: ["Jog in the negative direction", "负方向点动"],
  jog_plus: ["Jog in the positive direction", "正方向点动"],
  group_move: ["Group move", "多轴联动"],
  group_hint: ["All selected axes move on a straight line and arrive at the same time.", "所选各轴沿直线同时到达。"],
  chosen_axes: ["Selected axes", "所选轴"],
  none_chosen: ["No axis is selected. Select axes in the overview.", "未选择轴。请在总览中选择。"],
  remove_all: ["Remove all", "全部移除"],
  search_chosen: ["Search the selected axes", "搜索所选轴"],
  remove: ["Remove", "移除"],
  no_target: ["No target given", "未输入目标"],
  target: ["Target", "目标"],
  test_inputs: ["Test-bench inputs", "台架测试输入"],
  end_disturbances: ["End all", "全部清除"],
  load_torque: ["load torque", "负载转矩"],
  blocked_load: ["blocked load", "负载堵转"],
  over_current: ["over-current", "过流"],
  over_temperature: ["over-temperature", "过温"],
  encoder_failure: ["encoder failure", "编码器故障"],
  dc_link_loss: ["DC link loss", "母线掉电"],
  positive_limit: ["positive limit", "正限位"],
  negative_limit: ["negative limit", "负限位"],
  home_switch: ["home switch", "原点开关"],
  index_pulse: ["index pulse", "索引脉冲"],
  connection_loss: ["connection loss", "通信中断"],
  power_drop: ["power drop", "使能丢失"],
  frozen_feedback: ["frozen feedback", "反馈冻结"],
  modes: ["Operating mode", "运行模式"],
  mode_now: ["active (6061h)", "当前 (6061h)"],
  set_mode: ["Set the mode", "设置模式"],
  mode_streamed: ["In this mode, a program sends a set-point in every cycle.", "该模式的设定值由程序逐周期发送。"],
  trapezoidal: ["trapezoidal", "梯形"],
  limited_jerk: ["limited jerk", "限制加加速度"],
  homing_state: ["Homing", "回零状态"],
  homing_runs: ["in progress", "进行中"],
  homing_stands: ["not started, or interrupted", "未开始或被中断"],
  homing_attained: ["home found, not yet at standstill", "已找到原点，尚未停止"],
  homing_done: ["completed", "已完成"],
  homing_error_moves: ["error, still moving", "错误，仍在运动"],
  homing_error_stands: ["error, at standstill", "错误，已停止"],
  homing_other_mode: ["a different mode is active", "当前为其他模式"],
  memory: ["Memory", "存储"],
  store: ["Store parameters", "保存参数"],
  restore: ["Restore defaults", "恢复默认"],
  power_cycle: ["Power cycle", "断电重启"],
  clock: ["Clock of the bench", "台架时钟"],
  pause_clock: ["Pause", "停钟"],
  run_clock: ["Run", "运行"],
  rate: ["Rate", "速率"],
  set: ["Set", "设置"],
  step: ["Step", "步进"],
  ticks: ["ticks", "周期"],
  step_hint: ["A lock-step bench advances only by steps.", "锁步模式的台架仅随步进推进。"],
  done: ["done", "完成"],
  refused: ["refused", "被拒绝"],
  not_a_number: ["is not a number", "不是数字"],
  ambiguous_comma: ["ambiguous comma (decimal or thousands): use a decimal point", "逗号可表示小数或千位：请用小数点"],
  no_such_unit: ["has a unit that this field does not accept; accepted", "的单位不适用；可用"],
  fraction: ["is not a whole number, as this value must be", "含小数：此处只能为整数"],
  level_1: ["debug", "调试"],
  level_2: ["info", "信息"],
  level_3: ["warning", "警告"],
  level_4: ["error", "错误"],
  level_5: ["fatal", "严重"],
  back: ["Back to the overview", "返回总览"],
  paused: ["paused", "已暂停"],
} satisfies Record<string, readonly [string, string]>;

export type TextKey = keyof typeof TEXTS;

/** The Chinese names of states; the English ones come from the core. */
const STATES: Record<PowerState, string> = {
  not_ready_to_switch_on: "未准备好接通",
  switch_on_disabled: "禁止接通",
  ready_to_switch_on: "准备接通",
  switched_on: "已接通",
  operation_enabled: "运行使能",
  quick_stop_active: "快速停机",
  fault_reaction_active: "故障反应",
  fault: "故障",
};

let chosen: Language = "en";

export function setLanguage(language: Language): void {
  chosen = language;
  document.documentElement.lang = language === "zh" ? "zh-CN" : "en";
}

export function language(): Language {
  return chosen;
}

function pick(pair: readonly [string, string]): string {
  return chosen === "en" ? pair[0] : pair[1];
}

export function t(key: TextKey): string {
  return pick(TEXTS[key]);
}

export function isTextKey(key: string): key is TextKey {
  return key in TEXTS;
}

/** Services whose button has a text with a different name. */
const SERVICES: Record<string, TextKey> = {
  take_control: "take",
  release_control: "release",
  move_group: "group_move",
  pause: "pause_clock",
  disturb: "test_inputs",
};

/** @param service such as "/quick_stop" */
export function serviceName(service: string): string {
  const name = service.slice(1);
  const key = SERVICES[name] ?? name;
  return isTextKey(key) ? t(key) : name.replaceAll("_", " ");
}

const CLOCKS: Record<string, string> = { realtime: "实时", lockstep: "锁步", freerun: "自由运行" };

export function clockName(mode: string): string {
  return chosen === "zh" ? (CLOCKS[mode] ?? mode) : mode;
}

/** @param object of the dictionary with this name; a member without an object is shown by its own name */
export function signalName(member: string, object: { title: string; title_zh: string } | undefined): string {
  return object === undefined ? member.replaceAll("_", " ") : pick([object.title, object.title_zh]);
}

export function stateName(state: PowerState): string {
  return pick([POWER_STATE_NAMES[state], STATES[state]]);
}

/** @param name from the gateway; names of a newer gateway remain English */
export function bitName(name: string): string {
  const row = BIT_NAMES.find((candidate) => candidate.name === name);
  return row === undefined ? name : pick([row.name, row.name_zh]);
}

export function modeName(mode: number): string {
  const row = OPERATING_MODES.find((candidate) => candidate.mode === mode);
  return row === undefined ? String(mode) : pick([row.name, row.name_zh]);
}
