// SPDX-License-Identifier: Apache-2.0
#include "base/works_for.hpp"

#include "vdrive/worked_for.hpp"

namespace vdrive {
namespace {

const char*& name_of_work() noexcept {
  thread_local const char* name = "vdrive";
  return name;
}

}  // namespace

const char* worked_for() noexcept {
  return name_of_work();
}

namespace service {

WorksFor::WorksFor(const char* name) noexcept : outer_(name_of_work()) {
  name_of_work() = name;
}

WorksFor::~WorksFor() {
  name_of_work() = outer_;
}

}  // namespace service
}  // namespace vdrive
