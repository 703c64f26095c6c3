// SPDX-License-Identifier: Apache-2.0
#include "seam/stored_replies.hpp"

#include "vdrive_messages_description.hpp"

#include <type_traits>

namespace vdrive::service {
namespace {

/// Copies every member except the sequences.
template <typename Message>
void copy_head(const Message& from, Message& to) {
  wire::for_each_member<Message>([&]<typename Value>(const wire::Member<Message, Value>& member) {
    if constexpr (std::is_trivially_copyable_v<Value>) to.*member.pointer = from.*member.pointer;
  });
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
