// SPDX-License-Identifier: Apache-2.0
// Moves axis 1 of bench 1 to 10000 user units with nothing but the IDL and a DDS implementation: no
// vdrive library. This one is in C with Cyclone DDS; the steps are those of docs/reference/wire.md,
// "From nothing to a move". For a bench in real time: raw_dds [DOMAIN]
#include "vdrive_messages.h"  // what idlc makes of idl/vdrive_messages.idl

#include <dds/dds.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A service is on loopback unless its configuration names other interfaces. CYCLONEDDS_URI takes
// precedence.
static const char kLoopback[] =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/>"
    "</Interfaces></General></Domain></CycloneDDS>";

enum { kBench = 1, kTarget = 10000, kReached = 0x1637 };

static dds_entity_t participant;
static dds_entity_t benches, statuses, command_replies, replies;  // readers
static dds_entity_t commands, requests;                           // writers
static uint64_t incarnation, session;  // this run of the service; our session
static uint32_t epoch;                 // proves that we hold the axis
static uint64_t sequence, commanded;   // number of the last frame; of the last with a command
static uint16_t axis = 1, awaited;     // our axis; the statusword that we wait for
static vdrive_msg_Request request = {.bench = kBench};  // the pending one
static vdrive_msg_AxisStatus shown;                     // last status of our axis

static void fail(const char* what) {
  fprintf(stderr, "raw_dds: %s\n", what);
  exit(EXIT_FAILURE);
}

static dds_entity_t checked(dds_entity_t result) {
  if (result < 0) fail(dds_strretcode(-result));
  return result;
}

// The three kinds of topics: a queue, the last value (also for late joiners), a stream.
typedef enum Kind { kQueue, kLastValue, kStream } Kind;

static dds_qos_t* quality(Kind kind) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(
      qos, kind == kStream ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(
      qos, kind == kLastValue ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, kind == kQueue ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST,
                   kind == kStream ? 64 : 1);
  return qos;
}

static dds_entity_t reader(const char* name, const dds_topic_descriptor_t* type, Kind kind) {
  const dds_entity_t topic = checked(dds_create_topic(participant, type, name, NULL, NULL));
  return checked(dds_create_reader(participant, topic, quality(kind), NULL));
}

static dds_entity_t writer(const char* name, const dds_topic_descriptor_t* type) {
  const dds_entity_t topic = checked(dds_create_topic(participant, type, name, NULL, NULL));
  return checked(dds_create_writer(participant, topic, quality(kQueue), NULL));
}

// Takes a sample into *sample; false if there is none yet. Returns the loan of the previous one.
static bool take(dds_entity_t from, void** sample) {
  dds_sample_info_t info;
  if (*sample != NULL) dds_return_loan(from, sample, 1);
  *sample = NULL;
  return checked(dds_take(from, sample, &info, 1, 1)) == 1 && info.valid_data;
}

static void wait_until(bool (*done)(void), int seconds, const char* what) {
  const dds_time_t deadline = dds_time() + DDS_SECS(seconds);
  for (; !done(); dds_sleepfor(DDS_MSECS(5))) {
    if (dds_time() > deadline) fail(what);
  }
  printf("%s\n", what);
}

// 1. The service reads our topics.
static bool service_receives(void) {
  dds_publication_matched_status_t command, request;
  checked(dds_get_publication_matched_status(commands, &command));
  checked(dds_get_publication_matched_status(requests, &request));
  return command.current_count > 0 && request.current_count > 0;
}

// 2. The bench describes itself, also to readers that join late.
static bool bench_found(void) {
  static void* sample = NULL;
  while (take(benches, &sample)) {
    const vdrive_msg_BenchDescription* part = sample;
    if (part->bench == kBench && part->alive) incarnation = part->incarnation;
  }
  return incarnation != 0;
}

// 3. A request, and the reply that names its client and number. The very first reply may be lost,
// so a request not answered within a second is sent again.
static bool answered(void) {
  static void* sample = NULL;
  static int looks = 0;
  if (looks++ % 200 == 0) {
    ++request.request_id;
    checked(dds_write(requests, &request));
  }
  while (take(replies, &sample)) {  // the replies to all clients arrive here
    const vdrive_msg_Reply* reply = sample;
    if (reply->client != session || reply->request_id != request.request_id) continue;
    if (reply->reason != vdrive_msg_REASON_NONE) fail("the request was refused");
    epoch = reply->epoch;
    looks = 0;
    return true;
  }
  return false;
}

static void ask(uint32_t kind, const char* what) {
  request.client = request.session = session;
  request.kind = kind;
  request.axes._buffer = &axis;
  request.axes._length = request.axes._maximum = 1;
  wait_until(answered, 10, what);
}

// 4. A frame. Without a command it is a keep-alive.
static void send_frame(vdrive_msg_AxisCommand* command) {
  vdrive_msg_CommandFrame frame = {.bench = kBench,
                                   .incarnation = incarnation,
                                   .session = session,
                                   .epoch = epoch,
                                   .sequence_number = ++sequence};
  if (command != NULL) {
    command->axis = axis;
    frame.axes._buffer = command;
    frame.axes._length = frame.axes._maximum = 1;
    commanded = sequence;
  }
  checked(dds_write(commands, &frame));
}

// 5. The status of the axis. Each check, every 5 ms, sends a keep-alive for the watchdog.
static bool status_shown(void) {
  static void* reply = NULL;
  static void* sample = NULL;
  send_frame(NULL);
  while (take(command_replies, &reply)) {  // unsolicited: something was refused or ignored
    if (((vdrive_msg_CommandReply*)reply)->session == session) fail("a command was refused");
  }
  while (take(statuses, &sample)) {
    const vdrive_msg_StatusFrame* frame = sample;
    for (uint32_t i = 0; frame->incarnation == incarnation && i < frame->axes._length; ++i) {
      if (frame->axes._buffer[i].axis == axis) shown = frame->axes._buffer[i];
    }
  }
  if (awaited == kReached && shown.load_position_actual_value != kTarget) return false;
  return shown.last_sequence >= commanded && shown.ds402_statusword == awaited;
}

static void send_controlword(uint16_t controlword, uint16_t statusword, const char* what) {
  vdrive_msg_AxisCommand command = {.members = vdrive_msg_HAS_DS402_CONTROLWORD,
                                    .ds402_controlword = controlword};
  send_frame(&command);
  awaited = statusword;
  wait_until(status_shown, 20, what);
}

int main(int argc, char** argv) {
  const dds_domainid_t domain = argc > 1 ? (dds_domainid_t)atoi(argv[1]) : 0;
  const char* config = getenv("CYCLONEDDS_URI");
  checked(dds_create_domain(domain, config != NULL ? config : kLoopback));
  participant = checked(dds_create_participant(domain, NULL, NULL));
  dds_guid_t guid;
  checked(dds_get_guid(participant, &guid));
  memcpy(&session, guid.v, sizeof session);  // a number that no other session has
  benches = reader("vdrive/v1/bench", &vdrive_msg_BenchDescription_desc, kLastValue);
  statuses = reader("vdrive/v1/status", &vdrive_msg_StatusFrame_desc, kStream);
  command_replies = reader("vdrive/v1/command_reply", &vdrive_msg_CommandReply_desc, kQueue);
  replies = reader("vdrive/v1/reply", &vdrive_msg_Reply_desc, kQueue);  // last: see wire.md
  commands = writer("vdrive/v1/command", &vdrive_msg_CommandFrame_desc);
  requests = writer("vdrive/v1/request", &vdrive_msg_Request_desc);
  wait_until(service_receives, 10, "service found");
  wait_until(bench_found, 10, "bench found");
  ask(vdrive_msg_REQUEST_ACQUIRE, "axis acquired");
  send_controlword(0x06, 0x231, "ready to switch on");
  vdrive_msg_AxisCommand move = {
      .members = vdrive_msg_HAS_OP_MODE_CMD | vdrive_msg_HAS_POSITION_USER_TARGET_VALUE,
      .op_mode_cmd = 1,
      .position_user_target_value = kTarget};
  send_frame(&move);  // only writes the objects; bit 4 of 003Fh starts the move
  send_controlword(0x0F, 0x637, "operation enabled");
  send_controlword(0x3F, kReached, "target reached");
  printf("position %" PRId32 "\n", shown.load_position_actual_value);
  send_controlword(0x06, 0x231, "disabled");
  ask(vdrive_msg_REQUEST_RELEASE, "axis released");
  return EXIT_SUCCESS;
}
