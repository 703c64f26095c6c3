// SPDX-License-Identifier: Apache-2.0
// A user's program against the installed package. It runs without a network: the session is given
// a domain that does not exist, which must be refused by name.
#include <vdrive/client/session.hpp>
#include <vdrive/dictionary/dictionary.hpp>

#include <iostream>
#include <stdexcept>

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
