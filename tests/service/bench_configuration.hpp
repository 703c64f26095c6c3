// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "support/test_domain.hpp"

#include <spdlog/spdlog.h>

#include <cstddef>

namespace vdrive::test {

/// @return the configuration of a service on the domain of this test that logs warnings only.
inline service::Configuration configuration(service::ClockMode clock, std::size_t axes) {
  spdlog::set_level(spdlog::level::warn);
  service::Configuration with;
  with.clock = clock;
  with.network.domain = test_domain();
  with.axes = service::default_axes(axes);
  return with;
}

}  // namespace vdrive::test
