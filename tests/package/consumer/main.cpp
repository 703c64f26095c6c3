// SPDX-License-Identifier: Apache-2.0
// A user's program against the installed package. It runs without a network: the session is given
// a domain that does not exist, which must be refused by name.
#include <vdrive/client.hpp>
#include <vdrive/dictionary/dictionary.hpp>

#include <iostream>
#include <stdexcept>

// Compiled, never called: options as a program writes them, without a warning.
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
  try {
    const vdrive::client::Session session({.domain = 1000});
  } catch (const std::runtime_error& error) {
    std::cout << "refused as it should be: " << error.what() << '\n';
    return 0;
  }
  std::cerr << "a session on domain 1000 was accepted\n";
  return 1;
}
