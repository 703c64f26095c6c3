// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_access.hpp"
#include "client_table.hpp"
#include "control_desk.hpp"
#include "hub_server.hpp"
#include "worker.hpp"

namespace vdrive::gateway {

/// Handles service calls: checks the right, selects the thread that carries them out, and answers.
/// Used in the server's thread.
class ServiceCalls {
 public:
  /// @param access outlives this object, as do the other parameters
  ServiceCalls(BenchAccess& access, HubServer& server, ClientTable& clients, ControlDesk& control)
      : access_(access), server_(server), clients_(clients), control_(control) {}

  /// @param id of an open connection
  void handle(ConnectionId id, const CallService& call);

 private:
  using Answer = Jogs::Answer;

  void route(ConnectionId id, const ServiceRow& row, Json request, const Answer& answer);
  void jog(const Json& request, const Answer& answer);
  void carry_out(ConnectionId id, const ServiceRow& row, Json request, const Answer& answer);

  BenchAccess& access_;
  HubServer& server_;
  ClientTable& clients_;
  ControlDesk& control_;
  bridge::Worker stops_;  ///< halts and quick stops of all clients; last: its jobs use the members
                          ///< above
};

}  // namespace vdrive::gateway
