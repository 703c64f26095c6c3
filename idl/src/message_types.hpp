// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive_messagesPubSubTypes.h"

#include <mutex>

namespace vdrive::wire {

/// Generated support class of a message type.
template <typename Message>
struct SupportOf;

template <>
struct SupportOf<msg::CommandFrame> {
  using Type = msg::CommandFramePubSubType;
};

template <>
struct SupportOf<msg::CommandReply> {
  using Type = msg::CommandReplyPubSubType;
};

template <>
struct SupportOf<msg::Request> {
  using Type = msg::RequestPubSubType;
};

template <>
struct SupportOf<msg::Reply> {
  using Type = msg::ReplyPubSubType;
};

template <>
struct SupportOf<msg::StatusFrame> {
  using Type = msg::StatusFramePubSubType;
};

template <>
struct SupportOf<msg::AxisStatus> {
  using Type = msg::AxisStatusPubSubType;
};

template <>
struct SupportOf<msg::AxisParameters> {
  using Type = msg::AxisParametersPubSubType;
};

template <>
struct SupportOf<msg::Event> {
  using Type = msg::EventPubSubType;
};

template <>
struct SupportOf<msg::BenchDescription> {
  using Type = msg::BenchDescriptionPubSubType;
};

template <>
struct SupportOf<msg::BenchState> {
  using Type = msg::BenchStatePubSubType;
};

/// The generated support class, made fit for a network of strangers: no type objects on the wire,
/// no exception out of a malformed payload, and one key computation at a time (the generated one
/// shares a buffer between the writer and the reader of a participant).
template <typename Message>
class MessageType final : public SupportOf<Message>::Type {
 public:
  MessageType() {
    this->auto_fill_type_object(false);
    this->auto_fill_type_information(false);
    // Readers drop what is larger than this without a report. A message that exceeds a bound of
    // the type by less gets an answer with the reason.
    this->m_typeSize *= 2;
  }

  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    try {
      return SupportOf<Message>::Type::deserialize(payload, data);
    } catch (...) {  // unknown encapsulation, absurd length: the sample is dropped
      return false;
    }
  }

  bool getKey(void* data, eprosima::fastrtps::rtps::InstanceHandle_t* handle,
              bool force_md5) override {
    const std::lock_guard lock(mutex_);
    return SupportOf<Message>::Type::getKey(data, handle, force_md5);
  }

 private:
  std::mutex mutex_;
};

}  // namespace vdrive::wire
