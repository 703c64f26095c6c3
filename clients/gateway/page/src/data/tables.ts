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
    "name": "none"
  },
  {
    "mode": 1,
    "name": "profile position"
  },
  {
    "mode": 2,
    "name": "velocity"
  },
  {
    "mode": 3,
    "name": "profile velocity"
  },
  {
    "mode": 4,
    "name": "profile torque"
  },
  {
    "mode": 6,
    "name": "homing"
  },
  {
    "mode": 7,
    "name": "interpolated position"
  },
  {
    "mode": 8,
    "name": "cyclic synchronous position"
  },
  {
    "mode": 9,
    "name": "cyclic synchronous velocity"
  },
  {
    "mode": 10,
    "name": "cyclic synchronous torque"
  }
] as const;

export const BIT_NAMES = [
  "bit 12",
  "change set immediately",
  "enable interpolation",
  "enable operation",
  "enable ramp",
  "enable voltage",
  "fault",
  "fault reset",
  "following error",
  "follows command",
  "halt",
  "homing attained",
  "homing error",
  "internal limit active",
  "interpolation active",
  "new set-point",
  "operation enabled",
  "quick stop",
  "ready to switch on",
  "reference ramp",
  "relative",
  "remote",
  "set-point acknowledge",
  "speed zero",
  "start homing",
  "switch on",
  "switch on disabled",
  "switched on",
  "target reached",
  "unlock ramp",
  "voltage enabled",
  "warning"
] as const;
