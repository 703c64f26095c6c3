// SPDX-License-Identifier: Apache-2.0
#include "support/test_domain.hpp"

#include "private_domain.hpp"

namespace vdrive::test {

std::uint32_t test_domain() {
  static const process::PrivateDomain domain;
  return domain.number();
}

}  // namespace vdrive::test
