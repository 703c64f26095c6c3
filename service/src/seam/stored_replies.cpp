// SPDX-License-Identifier: Apache-2.0
#include "seam/stored_replies.hpp"

namespace vdrive::service {
namespace {

void copy_head(const msg::CommandReply& from, msg::CommandReply& to) {
  to.bench = from.bench;
  to.incarnation = from.incarnation;
  to.session = from.session;
  to.sequence_number = from.sequence_number;
  to.tick = from.tick;
}

void copy_head(const msg::Reply& from, msg::Reply& to) {
  to.client = from.client;
  to.request_id = from.request_id;
  to.bench = from.bench;
  to.incarnation = from.incarnation;
  to.reason = from.reason;
  to.refused_axis = from.refused_axis;
  to.owner_session = from.owner_session;
  to.tick = from.tick;
  to.epoch = from.epoch;
  to.last_sequence = from.last_sequence;
  to.missing_stepper = from.missing_stepper;
  to.snapshot = from.snapshot;
}

}  // namespace

void StoredCommandReply::keep(const msg::CommandReply& reply) {
  copy_head(reply, head_);
  refusals_.assign(reply.refusals);
  ignored_set_points_.assign(reply.ignored_set_points);
}

void StoredCommandReply::show(msg::CommandReply& reply) const {
  copy_head(head_, reply);
  reply.refusals.assign(refusals_.items().begin(), refusals_.items().end());
  const auto ignored = ignored_set_points_.items();
  reply.ignored_set_points.assign(ignored.begin(), ignored.end());
}

void StoredReply::keep(const msg::Reply& reply) {
  copy_head(reply, head_);
  objects_.assign(reply.objects);
}

void StoredReply::show(msg::Reply& reply) const {
  copy_head(head_, reply);
  reply.objects.assign(objects_.items().begin(), objects_.items().end());
}

}  // namespace vdrive::service
