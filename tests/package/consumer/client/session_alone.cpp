// SPDX-License-Identifier: Apache-2.0
#include <vdrive/client/session.hpp>

vdrive::client::Outcome enable(vdrive::client::Session& session) {
  auto axis = session.axis("1.1");
  return axis ? axis->enable() : axis.outcome();
}
