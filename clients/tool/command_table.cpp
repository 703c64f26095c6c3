// SPDX-License-Identifier: Apache-2.0
#include "command_table.hpp"

#include <array>

namespace vdrive::tool {

// Each row is defined in the file of its command: kMove in commands/move.cpp, the rows of commands
// that take only axes in commands/power.cpp.
extern const CommandRow kList;
extern const CommandRow kStatus;
extern const CommandRow kDescribe;
extern const CommandRow kWatch;
extern const CommandRow kEvents;
extern const CommandRow kEnable;
extern const CommandRow kDisable;
extern const CommandRow kReset;
extern const CommandRow kQuickStop;
extern const CommandRow kStop;
extern const CommandRow kPowerCycle;
extern const CommandRow kMove;
extern const CommandRow kHome;
extern const CommandRow kVelocity;
extern const CommandRow kTorque;
extern const CommandRow kJog;
extern const CommandRow kHalt;
extern const CommandRow kResume;
extern const CommandRow kRead;
extern const CommandRow kWrite;
extern const CommandRow kDictionary;
extern const CommandRow kStore;
extern const CommandRow kRestore;
extern const CommandRow kDisturb;
extern const CommandRow kStep;
extern const CommandRow kRate;
extern const CommandRow kSnapshot;
extern const CommandRow kFaults;
extern const CommandRow kRun;
extern const CommandRow kTest;
extern const CommandRow kExpect;
extern const CommandRow kWait;
extern const CommandRow kShell;
extern const CommandRow kRecord;
extern const CommandRow kConvert;
extern const CommandRow kPlot;
extern const CommandRow kJudge;
extern const CommandRow kDoctor;
extern const CommandRow kBench;
extern const CommandRow kDemo;
extern const CommandRow kCompletion;

namespace {

constexpr std::array kCommands{
    &kList,   &kStatus,    &kDescribe, &kWatch,      &kEvents, &kEnable,    &kDisable,
    &kReset,  &kQuickStop, &kStop,     &kPowerCycle, &kMove,   &kHome,      &kVelocity,
    &kTorque, &kJog,       &kHalt,     &kResume,     &kRead,   &kWrite,     &kDictionary,
    &kStore,  &kRestore,   &kDisturb,  &kStep,       &kRate,   &kSnapshot,  &kFaults,
    &kRun,    &kTest,      &kExpect,   &kWait,       &kShell,  &kRecord,    &kConvert,
    &kPlot,   &kJudge,     &kDoctor,   &kBench,      &kDemo,   &kCompletion};

}  // namespace

CommandTable commands() {
  return kCommands;
}

}  // namespace vdrive::tool
