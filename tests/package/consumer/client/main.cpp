// SPDX-License-Identifier: Apache-2.0
// A user's program with the installed package. It runs without a network: the session gets a domain
// that does not exist, and the refusal must name it.
#ifdef WITH_BENCH
#include <vdrive/bench/bench.hpp>
#endif
#include <vdrive/client.hpp>
#include <vdrive/dictionary/dictionary.hpp>

#include <iostream>
#include <stdexcept>
#include <string>

// Compiled, never called: options as a program would write them, without a warning.
vdrive::client::Outcome move(vdrive::client::Session& session) {
  vdrive::client::Axis axis = session.axis("1.1").value();
  return axis.move_to(10000,
                      {.velocity = 20000, .call = {.until = vdrive::client::Until::in_force}});
}

int main() {
  if (!vdrive::find_object("ds402_statusword")) {
    std::cerr << "the dictionary has no statusword\n";
    return 1;
  }
#ifdef WITH_BENCH
  const vdrive::bench::Bench bench;
  if (!bench.session().axis("1.1")) {
    std::cerr << "the bench of this process has no axis 1.1\n";
    return 1;
  }
#endif
  try {
    const vdrive::client::Session session({.domain = 1000});
  } catch (const std::runtime_error& error) {
    std::cout << error.what() << '\n';
    return std::string(error.what()).find("domain 1000") != std::string::npos ? 0 : 1;
  }
  std::cerr << "a session on domain 1000 was accepted\n";
  return 1;
}
