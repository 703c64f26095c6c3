// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "control_keeper.hpp"
#include "reports.hpp"
#include "vdrive/client/session.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::bridge {

/// Keeps control of all axes of a bench for a session. want() may be called from any thread, keep()
/// only from the thread that may wait for the bench.
class BenchControl final : private ControlledBench {
 public:
  struct Options {
    std::string label;  ///< name of the bench in reports
    ControlRemedies remedies{};
    /// For bridges in which nobody can ask for control: control is wanted from the beginning and is
    /// regained after a loss, as on a real drive when its local operator leaves.
    bool is_automatic = false;
  };

  /// @param session, reports must outlive this
  /// @param axes all axes of a bench
  BenchControl(client::Session& session, Reports& reports, std::vector<client::AxisId> axes,
               Options options);

  /// As ControlKeeper::want().
  void want(bool wanted) { keeper_.want(wanted); }

  [[nodiscard]] bool is_automatic() const noexcept { return options_.is_automatic; }

  /// Takes control if that is due, which waits for the bench.
  /// @param axes their newest state
  /// @return their state after control was taken; nothing if it was not.
  std::optional<client::Observation> keep(std::span<const client::AxisSnapshot> axes);

 private:
  client::Outcome acquire() override { return session_.acquire(axes_); }

  std::optional<client::Observation> observe() override;
  std::string name_of(std::uint64_t session) override;

  void report(Severity severity, const std::string& text) override {
    reports_.report(severity, options_.label, text);
  }

  client::Session& session_;
  Reports& reports_;
  const std::vector<client::AxisId> axes_;
  const Options options_;
  ControlKeeper keeper_;
};

}  // namespace vdrive::bridge
