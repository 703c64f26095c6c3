// SPDX-License-Identifier: Apache-2.0
//
// Faults on demand, for testing how a program handles them: every fault that the bench can inject
// (5E01h to 5E05h), what the axis shows, and how to recover.
//
//   vdrived &
//   05_test_bench_with_faults [domain]
#include <vdrive/client.hpp>

#include <array>
#include <iostream>
#include <string>
#include <string_view>

using namespace vdrive::client;

namespace {

struct Fault {
  std::string_view name;
  Disturbance disturbance;
  std::uint16_t error_code;  // expected in 603Fh
};

constexpr std::array kFaults{
    Fault{"over-current", Disturbance::over_current, 0x2310},
    Fault{"over-temperature", Disturbance::over_temperature, 0x4310},
    Fault{"encoder failure", Disturbance::encoder_failure, 0x7305},
    Fault{"loss of the DC link", Disturbance::dc_link_loss, 0x3220},
    Fault{"blocked load, hence a following error", Disturbance::blocked_load, 0x8611},
};

/// @return whether the axis failed with the fault and recovered.
bool survives(Axis& axis, const Fault& fault) {
  if (!axis.enable() || !axis.disturb(fault.disturbance)) return false;

  // The move ends with `failed`, and its message names the fault.
  const Outcome ended = axis.move_by(100'000);
  std::cout << fault.name << ": " << ended.message() << '\n';
  const auto broken = axis.status();
  if (ended.kind() == OutcomeKind::ok || !broken || broken->status.error_code != fault.error_code) {
    return false;
  }

  // While the cause persists, the axis refuses a reset; a blocked load is not a persistent cause.
  const Outcome early = axis.reset_fault();
  if (!early) std::cout << "  too early: " << early.message() << '\n';

  if (!axis.disturb(fault.disturbance, 0)) return false;
  if (const Outcome reset = axis.reset_fault(); !reset) {
    std::cerr << reset.message() << '\n';
    return false;
  }
  // Nothing moves automatically after a reset: enable, then move.
  return axis.enable() && axis.move_to(0);
}

}  // namespace

int main(int argc, char** argv) {
  SessionOptions options;
  if (argc > 1) options.domain = static_cast<std::uint32_t>(std::stoul(argv[1]));
  Session session(options);

  auto axis = session.axis("1.1");
  if (!axis) {
    std::cerr << axis.outcome().message() << '\n';
    return 1;
  }
  for (const Fault& fault : kFaults) {
    if (!survives(*axis, fault)) {
      std::cerr << fault.name << " did not go as it should\n";
      return 1;
    }
  }
  std::cout << kFaults.size() << " faults survived\n";
  return axis->disable() ? 0 : 1;
}
