// SPDX-License-Identifier: Apache-2.0
// Written from the schemas of the gateway and the tables of the core, not by hand:
//   VDRIVE_WRITE_PAGE_TABLES=1 gateway_parts_test --gtest_filter='PageTables.*'

export const BENCH_DESCRIPTION = {
  "properties": {
    "axes": {
      "items": {
        "properties": {
          "app_speed_limit": {
            "type": "integer"
          },
          "axis": {
            "type": "integer"
          },
          "name": {
            "type": "string"
          },
          "supported_drive_modes": {
            "type": "integer"
          },
          "topic": {
            "type": "string"
          },
          "unit": {
            "properties": {
              "kind": {
                "type": "string"
              },
              "name": {
                "type": "string"
              },
              "per": {
                "type": "number"
              }
            },
            "required": [
              "kind",
              "name",
              "per"
            ],
            "type": "object"
          },
          "user_position_lower_limit": {
            "type": "integer"
          },
          "user_position_upper_limit": {
            "type": "integer"
          }
        },
        "required": [
          "axis",
          "name",
          "topic",
          "unit",
          "supported_drive_modes",
          "user_position_lower_limit",
          "user_position_upper_limit",
          "app_speed_limit"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "bench": {
      "type": "integer"
    },
    "clock_mode": {
      "type": "string"
    },
    "dictionary_version": {
      "type": "string"
    },
    "incarnation": {
      "type": "string"
    },
    "name": {
      "type": "string"
    },
    "period_us": {
      "type": "integer"
    },
    "service_version": {
      "type": "string"
    }
  },
  "required": [
    "bench",
    "name",
    "clock_mode",
    "period_us",
    "dictionary_version",
    "service_version",
    "incarnation",
    "axes"
  ],
  "type": "object"
} as const;

export const BENCH_STATE = {
  "properties": {
    "age_ms": {
      "type": "integer"
    },
    "alive": {
      "type": "boolean"
    },
    "bench": {
      "type": "integer"
    },
    "clock_mode": {
      "type": "string"
    },
    "longest_silence_us": {
      "type": "integer"
    },
    "owners": {
      "items": {
        "properties": {
          "name": {
            "type": "string"
          },
          "session": {
            "type": "string"
          }
        },
        "required": [
          "session",
          "name"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "rate": {
      "type": "number"
    },
    "takings": {
      "items": {
        "properties": {
          "axis": {
            "type": "integer"
          },
          "by": {
            "type": "string"
          },
          "from": {
            "type": "string"
          },
          "tick": {
            "type": "integer"
          }
        },
        "required": [
          "axis",
          "from",
          "by",
          "tick"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "tick": {
      "type": "integer"
    },
    "time_ns": {
      "type": "string"
    },
    "wire_starts": {
      "type": "integer"
    }
  },
  "required": [
    "bench",
    "tick",
    "time_ns",
    "rate",
    "clock_mode",
    "wire_starts",
    "longest_silence_us",
    "alive",
    "age_ms",
    "owners",
    "takings"
  ],
  "type": "object"
} as const;

export const CONTROL = {
  "properties": {
    "enabled": {
      "type": "boolean"
    },
    "holder": {
      "type": "string"
    },
    "name": {
      "type": "string"
    },
    "session": {
      "type": "string"
    },
    "silence_ms": {
      "type": "integer"
    },
    "taken_at_ns": {
      "type": "string"
    },
    "you": {
      "type": "boolean"
    }
  },
  "required": [
    "enabled",
    "holder",
    "you",
    "name",
    "session",
    "taken_at_ns",
    "silence_ms"
  ],
  "type": "object"
} as const;

export const DICTIONARY = {
  "properties": {
    "controlword_bits": {
      "items": {
        "properties": {
          "bits": {
            "items": {
              "type": "string"
            },
            "type": "array"
          },
          "mode": {
            "type": "integer"
          }
        },
        "required": [
          "mode",
          "bits"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "disturbances": {
      "items": {
        "properties": {
          "kind": {
            "type": "string"
          },
          "maximum": {
            "type": "integer"
          },
          "minimum": {
            "type": "integer"
          },
          "name": {
            "type": "string"
          },
          "object": {
            "type": "string"
          }
        },
        "required": [
          "name",
          "object",
          "kind",
          "minimum",
          "maximum"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "error_codes": {
      "items": {
        "properties": {
          "code": {
            "type": "integer"
          },
          "name": {
            "type": "string"
          }
        },
        "required": [
          "code",
          "name"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "homing_methods": {
      "items": {
        "properties": {
          "direction": {
            "type": "integer"
          },
          "hard_stop": {
            "type": "boolean"
          },
          "home_switch": {
            "type": "boolean"
          },
          "index_pulse": {
            "type": "boolean"
          },
          "limit_switch": {
            "type": "boolean"
          },
          "method": {
            "type": "integer"
          }
        },
        "required": [
          "method",
          "direction",
          "limit_switch",
          "home_switch",
          "hard_stop",
          "index_pulse"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "modes": {
      "items": {
        "properties": {
          "commands_torque": {
            "type": "boolean"
          },
          "mode": {
            "type": "integer"
          },
          "name": {
            "type": "string"
          }
        },
        "required": [
          "mode",
          "name",
          "commands_torque"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "objects": {
      "items": {
        "properties": {
          "access": {
            "type": "string"
          },
          "category": {
            "type": "string"
          },
          "default": {
            "type": "integer"
          },
          "effect": {
            "type": "string"
          },
          "index": {
            "type": "string"
          },
          "maximum": {
            "type": "integer"
          },
          "minimum": {
            "type": "integer"
          },
          "name": {
            "type": "string"
          },
          "storage": {
            "type": "string"
          },
          "sub_index": {
            "type": "integer"
          },
          "title": {
            "type": "string"
          },
          "title_zh": {
            "type": "string"
          },
          "type": {
            "type": "string"
          },
          "unit": {
            "type": "string"
          }
        },
        "required": [
          "index",
          "sub_index",
          "name",
          "title",
          "title_zh",
          "category",
          "type",
          "access",
          "minimum",
          "maximum",
          "default",
          "unit",
          "storage",
          "effect"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "statusword_bits": {
      "items": {
        "properties": {
          "bits": {
            "items": {
              "type": "string"
            },
            "type": "array"
          },
          "mode": {
            "type": "integer"
          }
        },
        "required": [
          "mode",
          "bits"
        ],
        "type": "object"
      },
      "type": "array"
    },
    "version": {
      "type": "string"
    }
  },
  "required": [
    "version",
    "objects",
    "modes",
    "error_codes",
    "statusword_bits",
    "controlword_bits",
    "disturbances",
    "homing_methods"
  ],
  "type": "object"
} as const;

export const POWER_STATES = [
  {
    "mask": 79,
    "name": "Switch on disabled",
    "state": "switch_on_disabled",
    "value": 64
  },
  {
    "mask": 111,
    "name": "Ready to switch on",
    "state": "ready_to_switch_on",
    "value": 33
  },
  {
    "mask": 111,
    "name": "Switched on",
    "state": "switched_on",
    "value": 35
  },
  {
    "mask": 111,
    "name": "Operation enabled",
    "state": "operation_enabled",
    "value": 39
  },
  {
    "mask": 111,
    "name": "Quick stop active",
    "state": "quick_stop_active",
    "value": 7
  },
  {
    "mask": 79,
    "name": "Fault reaction active",
    "state": "fault_reaction_active",
    "value": 15
  },
  {
    "mask": 79,
    "name": "Fault",
    "state": "fault",
    "value": 8
  },
  {
    "mask": 0,
    "name": "Not ready to switch on",
    "state": "not_ready_to_switch_on",
    "value": 0
  }
] as const;

export const TRANSITIONS = [
  {
    "from": "not_ready_to_switch_on",
    "number": 1,
    "to": "switch_on_disabled"
  },
  {
    "from": "switch_on_disabled",
    "number": 2,
    "to": "ready_to_switch_on"
  },
  {
    "from": "ready_to_switch_on",
    "number": 3,
    "to": "switched_on"
  },
  {
    "from": "switched_on",
    "number": 4,
    "to": "operation_enabled"
  },
  {
    "from": "operation_enabled",
    "number": 5,
    "to": "switched_on"
  },
  {
    "from": "switched_on",
    "number": 6,
    "to": "ready_to_switch_on"
  },
  {
    "from": "ready_to_switch_on",
    "number": 7,
    "to": "switch_on_disabled"
  },
  {
    "from": "operation_enabled",
    "number": 8,
    "to": "ready_to_switch_on"
  },
  {
    "from": "operation_enabled",
    "number": 9,
    "to": "switch_on_disabled"
  },
  {
    "from": "switched_on",
    "number": 10,
    "to": "switch_on_disabled"
  },
  {
    "from": "operation_enabled",
    "number": 11,
    "to": "quick_stop_active"
  },
  {
    "from": "quick_stop_active",
    "number": 12,
    "to": "switch_on_disabled"
  },
  {
    "from": "not_ready_to_switch_on",
    "number": 13,
    "to": "fault_reaction_active"
  },
  {
    "from": "switch_on_disabled",
    "number": 13,
    "to": "fault_reaction_active"
  },
  {
    "from": "ready_to_switch_on",
    "number": 13,
    "to": "fault_reaction_active"
  },
  {
    "from": "switched_on",
    "number": 13,
    "to": "fault_reaction_active"
  },
  {
    "from": "operation_enabled",
    "number": 13,
    "to": "fault_reaction_active"
  },
  {
    "from": "quick_stop_active",
    "number": 13,
    "to": "fault_reaction_active"
  },
  {
    "from": "fault_reaction_active",
    "number": 14,
    "to": "fault"
  },
  {
    "from": "fault",
    "number": 15,
    "to": "switch_on_disabled"
  },
  {
    "from": "quick_stop_active",
    "number": 16,
    "to": "operation_enabled"
  }
] as const;

export const OPERATING_MODES = [
  {
    "mode": 0,
    "name": "none",
    "name_zh": "无"
  },
  {
    "mode": 1,
    "name": "profile position",
    "name_zh": "轮廓位置"
  },
  {
    "mode": 2,
    "name": "velocity",
    "name_zh": "速度"
  },
  {
    "mode": 3,
    "name": "profile velocity",
    "name_zh": "轮廓速度"
  },
  {
    "mode": 4,
    "name": "profile torque",
    "name_zh": "轮廓转矩"
  },
  {
    "mode": 6,
    "name": "homing",
    "name_zh": "回零"
  },
  {
    "mode": 7,
    "name": "interpolated position",
    "name_zh": "插补位置"
  },
  {
    "mode": 8,
    "name": "cyclic synchronous position",
    "name_zh": "周期同步位置"
  },
  {
    "mode": 9,
    "name": "cyclic synchronous velocity",
    "name_zh": "周期同步速度"
  },
  {
    "mode": 10,
    "name": "cyclic synchronous torque",
    "name_zh": "周期同步转矩"
  }
] as const;

export const BIT_NAMES = [
  {
    "name": "bit 12",
    "name_zh": "位 12"
  },
  {
    "name": "change set immediately",
    "name_zh": "立即更改"
  },
  {
    "name": "enable interpolation",
    "name_zh": "使能插补"
  },
  {
    "name": "enable operation",
    "name_zh": "使能运行"
  },
  {
    "name": "enable ramp",
    "name_zh": "使能斜坡"
  },
  {
    "name": "enable voltage",
    "name_zh": "使能电压"
  },
  {
    "name": "fault",
    "name_zh": "故障"
  },
  {
    "name": "fault reset",
    "name_zh": "故障复位"
  },
  {
    "name": "following error",
    "name_zh": "跟随误差"
  },
  {
    "name": "follows command",
    "name_zh": "跟随指令"
  },
  {
    "name": "halt",
    "name_zh": "暂停"
  },
  {
    "name": "homing attained",
    "name_zh": "回零完成"
  },
  {
    "name": "homing error",
    "name_zh": "回零错误"
  },
  {
    "name": "internal limit active",
    "name_zh": "内部限制有效"
  },
  {
    "name": "interpolation active",
    "name_zh": "插补有效"
  },
  {
    "name": "new set-point",
    "name_zh": "新设定点"
  },
  {
    "name": "operation enabled",
    "name_zh": "运行使能"
  },
  {
    "name": "quick stop",
    "name_zh": "快速停机（0 有效）"
  },
  {
    "name": "ready to switch on",
    "name_zh": "准备接通"
  },
  {
    "name": "reference ramp",
    "name_zh": "斜坡给定"
  },
  {
    "name": "relative",
    "name_zh": "相对"
  },
  {
    "name": "remote",
    "name_zh": "远程"
  },
  {
    "name": "set-point acknowledge",
    "name_zh": "设定点应答"
  },
  {
    "name": "speed zero",
    "name_zh": "零速"
  },
  {
    "name": "start homing",
    "name_zh": "开始回零"
  },
  {
    "name": "switch on",
    "name_zh": "接通"
  },
  {
    "name": "switch on disabled",
    "name_zh": "禁止接通"
  },
  {
    "name": "switched on",
    "name_zh": "已接通"
  },
  {
    "name": "target reached",
    "name_zh": "到达目标"
  },
  {
    "name": "unlock ramp",
    "name_zh": "解锁斜坡"
  },
  {
    "name": "voltage enabled",
    "name_zh": "电压使能"
  },
  {
    "name": "warning",
    "name_zh": "警告"
  }
] as const;
