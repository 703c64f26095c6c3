// SPDX-License-Identifier: Apache-2.0
#include "execution/connection.hpp"

#include "output/record.hpp"
#include "terminal/keys.hpp"

#include <chrono>

namespace vdrive::tool {

client::SessionOptions session_options(const GlobalOptions& options) {
  client::SessionOptions session;
  session.domain = options.domain;
  session.interfaces = options.interfaces;
  session.peers = options.peers;
  session.discovery_servers = options.discovery_servers;
  session.security = options.security;
  session.bus = options.bus;
  if (options.ends_at_silence) session.patience = session.silence;
  if (options.timeout) {
    session.find_timeout = std::chrono::ceil<std::chrono::milliseconds>(*options.timeout);
  } else if (!options.security.empty()) {
    session.find_timeout = client::SessionOptions::kFindTimeoutOfClosedMode;
  }
  return session;
}

ExitCode finish(const client::Outcome& outcome, const Interrupt& interrupt, bool is_json,
                Terminal& terminal) {
  terminal.end_live();
  if (interrupt.happened()) return ExitCode::interrupted;
  // The reader of a pipe has gone: that ends the stream and is not an error.
  if (!terminal.is_open() && !terminal.write_failure()) return ExitCode::ok;
  if (outcome) return ExitCode::ok;
  terminal.print_error("vdrive: " + outcome.message());
  if (is_json && outcome.kind() == client::OutcomeKind::not_found) {
    Record record;
    add_outcome(record, outcome);
    print(record, {terminal, is_json, false});
  }
  return exit_code_of(outcome.kind());
}

ExitCode report_usage(const std::string& message, bool is_json, Terminal& terminal) {
  print({{"outcome", "usage"}, {"message", message}}, {terminal, is_json, false});
  terminal.print_error("vdrive: " + message);
  return ExitCode::usage;
}

void leave_screen_before_exit(Interrupt& interrupt, Terminal& terminal) {
  interrupt.before_exit([&terminal] {
    terminal.leave_screen_at_once();
    KeyInput::restore_at_once();
  });
}

}  // namespace vdrive::tool
