// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "terminal/interrupt.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::process {

class PrivateBench;

}  // namespace vdrive::process

namespace vdrive::tool {

/// The private benches of a command. They are in lock-step.
struct PrivateBenches {
  /// How messages reach a bench.
  enum class Wire : std::uint8_t {
    local,  ///< directly: the bench is in this process
    dds,    ///< over DDS: the bench is a vdrived on a domain that no other program uses
  };

  Wire wire = Wire::local;
  bool names_wire = false;      ///< the command line has --over
  std::string configuration{};  ///< file; empty = the demo bench
  std::string service{};        ///< DDS: the service program; empty = found next to the tool or in
                                ///< PATH
  std::string journal{};        ///< file that the bench writes; empty = none

  /// Declares --over, --config and --service.
  void declare(Arguments& arguments);

  /// Declares --journal.
  void declare_journal(Arguments& arguments);

  /// @throws UsageError for an option that a private bench does not have, an unusable
  ///         configuration, or a missing service.
  void check(const GlobalOptions& options) const;

  /// @return the command-line arguments for these benches.
  [[nodiscard]] std::vector<std::string> arguments() const;
};

/// A bench that only this program reaches, with a session on it, which a signal interrupts.
class PrivateSession {
 public:
  /// @throws NotRun if it cannot be started.
  PrivateSession(const PrivateBenches& benches, const GlobalOptions& options, Interrupt& interrupt);
  ~PrivateSession();
  PrivateSession(const PrivateSession&) = delete;
  PrivateSession& operator=(const PrivateSession&) = delete;

  [[nodiscard]] client::Session& session() noexcept { return *session_; }

 private:
  void open(const PrivateBenches& benches, const GlobalOptions& options);
  void open_local(const PrivateBenches& benches, client::SessionOptions options);
  void open_over_dds(const PrivateBenches& benches, client::SessionOptions options);

  Interrupt& interrupt_;
  std::optional<bench::Bench> bench_;
  std::unique_ptr<process::PrivateBench> service_;
  std::optional<client::Session> session_;  ///< after its bench, so that it ends first
};

}  // namespace vdrive::tool
