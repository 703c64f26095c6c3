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

/// What the benches are that a command makes for itself. They are in lock-step.
struct PrivateBenches {
  /// What carries the messages of a bench.
  enum class Wire : std::uint8_t {
    local,  ///< none: the bench is in this process
    dds,    ///< it is a vdrived on a domain that no other program uses
  };

  Wire wire = Wire::local;
  bool names_wire = false;      ///< the command line does
  std::string configuration{};  ///< file; empty = the demo bench
  std::string service{};        ///< over DDS: the program; empty = found beside the tool or in PATH
  std::string journal{};        ///< file that the bench writes; empty = none

  /// --over, --config and --service.
  void declare(Arguments& arguments);

  /// --journal.
  void declare_journal(Arguments& arguments);

  /// @throws UsageError for an option that such a bench does not have, for a configuration that
  ///         cannot be used, and where there is no service.
  void check(const GlobalOptions& options) const;

  /// @return what a command line has for them.
  [[nodiscard]] std::vector<std::string> arguments() const;
};

/// A bench that only this program reaches, and a session with it, which a signal interrupts.
class PrivateSession {
 public:
  /// @throws NotRun where it cannot be started.
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
  std::optional<client::Session> session_;  ///< behind its bench: it ends first
};

}  // namespace vdrive::tool
