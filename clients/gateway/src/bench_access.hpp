// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "directory.hpp"
#include "jogs.hpp"
#include "services.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::gateway {

/// The session towards the benches of the connection that holds control.
struct HeldSession {
  std::uint64_t id = 0;
  SessionPointer session;      ///< for calls
  std::shared_ptr<Jogs> jogs;  ///< the axes that it jogs
};

/// The parameters that a client asked for, and what went wrong.
struct ParameterAnswer {
  std::vector<Parameter> parameters;
  std::vector<std::string> complaints;  ///< each a sentence
};

/// What the parts of the hub ask of benches. Any thread; all but end() wait for the benches.
class BenchAccess {
 public:
  virtual ~BenchAccess() = default;

  /// Makes the session of a connection that takes control. @throws std::exception
  [[nodiscard]] virtual HeldSession open() = 0;

  /// Ends it, and does not wait.
  /// @param is_graceful what it jogs stops, and its axes are given back as they are; otherwise it
  ///        stops sending, and the axes react by 6007h
  virtual void end(HeldSession held, bool is_graceful) = 0;

  /// Carries a service out.
  /// @param own the session of the connection; null when it does not hold control
  /// @throws ProtocolError when the request is wrong
  [[nodiscard]] virtual CallAnswer call(const ServiceRow& row, const SessionPointer& own,
                                        const Json& request) = 0;

  [[nodiscard]] virtual ParameterAnswer read(const BenchList& benches,
                                             const std::vector<std::string>& names) = 0;

  /// @param own the session of the connection
  [[nodiscard]] virtual ParameterAnswer write(const SessionPointer& own, const BenchList& benches,
                                              const std::vector<ParameterChange>& changes) = 0;
};

}  // namespace vdrive::gateway
