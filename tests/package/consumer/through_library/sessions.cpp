// SPDX-License-Identifier: Apache-2.0
#include "sessions.hpp"

#include <vdrive/client/session.hpp>

#include <stdexcept>

std::string problem_of_domain(unsigned domain) {
  try {
    const vdrive::client::Session session({.domain = domain});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}
