# SPDX-License-Identifier: Apache-2.0
"""States, modes, bits, errors and reasons as enumerations, made from the tables of the drive.

Their members for a type checker are in _enums.pyi, which a test compares with these.
"""
import enum

from . import _vdrive

_KINDS = {
    "PowerState": (enum.IntEnum, "States of the power drive system (CiA 402), see Status.power_state."),
    "OperatingMode": (enum.IntEnum, "Operating modes, 6060h and 6061h: compare Status.op_mode_actual."),
    "Statusword": (enum.IntFlag, "Bits of the statusword 6041h, for Status.shows() and Status.statusword."),
    "ErrorCode": (enum.IntEnum, "Errors of the drive, 603Fh: compare Status.error_code."),
    "Reason": (enum.IntEnum, "Why a call was refused: compare Error.code."),
}
for _name, _members in _vdrive.enum_tables().items():
    _kind, _text = _KINDS[_name]
    globals()[_name] = _kind(_name, _members, module="vdrive")
    globals()[_name].__doc__ = _text
