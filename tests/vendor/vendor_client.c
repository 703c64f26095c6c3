// SPDX-License-Identifier: Apache-2.0
// A client with Cyclone DDS: acquires an axis, enables it and runs the manual's example "absolute
// position mode, forward", row by row.
//
//   vendor_client DOMAIN BENCH AXIS
//
// In lock-step it advances the time itself and reads the status from the replies; in real time it
// follows the status topic and keeps its session alive. Prints a line for each row. Exit code 0:
// every row showed the values of the manual; 1: a line on standard error names what was missing.
#include "vdrive_messages.h"

#include <dds/dds.h>

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const dds_duration_t kPatience = DDS_SECS(10);    // for an answer
static const dds_duration_t kAgain = DDS_MSECS(500);     // before the first request is repeated
static const dds_duration_t kKeepAlive = DDS_MSECS(20);  // the watchdog allows 500 ms
static const uint64_t kTicksPerStep = 10;
static const dds_duration_t kLongestMove = DDS_SECS(60);  // skipped ticks make it longer
static const int32_t kDepth = 1024;

// A reader and a wait set for its samples.
typedef struct Inbox {
  dds_entity_t reader;
  dds_entity_t waitset;
} Inbox;

typedef struct Client {
  uint32_t bench;
  uint16_t axis;
  uint64_t incarnation;
  uint64_t id;  // of client and session
  uint32_t epoch;
  uint64_t requests;
  uint64_t frames;
  bool lockstep;
  dds_entity_t participant;
  dds_entity_t requester;
  dds_entity_t commander;
  Inbox benches;
  Inbox statuses;
  Inbox command_replies;
  Inbox replies;
  vdrive_msg_AxisStatus now;
} Client;

static void fail(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fputs("vendor_client: ", stderr);
  vfprintf(stderr, format, arguments);
  fputc('\n', stderr);
  va_end(arguments);
  exit(EXIT_FAILURE);
}

static dds_entity_t checked(dds_entity_t result, const char* what) {
  if (result < 0) {
    fail("%s: %s", what, dds_strretcode(-result));
  }
  return result;
}

// ---- topics -------------------------------------------------------------------------------------

typedef enum Quality { kQueue, kStream, kState } Quality;

static dds_qos_t* qos_of(Quality quality) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos,
                       quality == kStream ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE,
                       DDS_SECS(1));
  dds_qset_durability(qos,
                      quality == kState ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  if (quality == kQueue) {
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    dds_qset_resource_limits(qos, kDepth, 1, kDepth);
  } else {
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, quality == kStream ? 64 : 1);
  }
  return qos;
}

static dds_entity_t topic(const Client* client, const char* name,
                          const dds_topic_descriptor_t* type) {
  return checked(dds_create_topic(client->participant, type, name, NULL, NULL), name);
}

static Inbox subscribe(const Client* client, const char* name, const dds_topic_descriptor_t* type,
                       Quality quality) {
  dds_qos_t* qos = qos_of(quality);
  Inbox inbox;
  inbox.reader =
      checked(dds_create_reader(client->participant, topic(client, name, type), qos, NULL), name);
  inbox.waitset = checked(dds_create_waitset(client->participant), "waitset");
  checked(dds_set_status_mask(inbox.reader, DDS_DATA_AVAILABLE_STATUS), "status mask");
  checked(dds_waitset_attach(inbox.waitset, inbox.reader, 0), "attach");
  dds_delete_qos(qos);
  return inbox;
}

static dds_entity_t publish(const Client* client, const char* name,
                            const dds_topic_descriptor_t* type) {
  dds_qos_t* qos = qos_of(kQueue);
  const dds_entity_t writer =
      checked(dds_create_writer(client->participant, topic(client, name, type), qos, NULL), name);
  dds_delete_qos(qos);
  return writer;
}

static void wait_for_reader(const Client* client, dds_entity_t writer) {
  const dds_entity_t waitset = checked(dds_create_waitset(client->participant), "waitset");
  checked(dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS), "status mask");
  checked(dds_waitset_attach(waitset, writer, 0), "attach");
  if (dds_waitset_wait(waitset, NULL, 0, kPatience) < 1) {
    fail("no service reads what is written");
  }
  dds_delete(waitset);
}

// Takes the next sample within `patience`. Return the loan in *sample with dds_return_loan.
static bool take(const Inbox* inbox, dds_duration_t patience, void** sample) {
  const dds_time_t deadline = dds_time() + patience;
  for (;;) {
    dds_sample_info_t info;
    *sample = NULL;
    const int32_t count = checked(dds_take(inbox->reader, sample, &info, 1, 1), "take");
    if (count == 1 && info.valid_data) {
      return true;
    }
    if (count == 1) {
      dds_return_loan(inbox->reader, sample, count);
    } else if (dds_waitset_wait_until(inbox->waitset, NULL, 0, deadline) < 1) {
      return false;
    }
  }
}

// ---- requests -----------------------------------------------------------------------------------

static void find_bench(Client* client) {
  void* sample;
  while (client->incarnation == 0) {
    if (!take(&client->benches, kPatience, &sample)) {
      fail("no bench %" PRIu32, client->bench);
    }
    const vdrive_msg_BenchDescription* part = sample;
    if (part->bench == client->bench && part->alive) {
      client->incarnation = part->incarnation;
      client->lockstep = part->clock_mode == vdrive_msg_CLOCK_MODE_LOCKSTEP;
      printf("bench %" PRIu32 " \"%s\": %" PRIu32 " axes, %s\n", part->bench, part->name,
             part->axis_count, client->lockstep ? "lock-step" : "real time");
    }
    dds_return_loan(client->benches.reader, &sample, 1);
  }
}

// Waits for the reply to the last request. Return it with dds_return_loan.
static vdrive_msg_Reply* wait_for_reply(const Client* client, dds_duration_t patience) {
  void* sample;
  while (take(&client->replies, patience, &sample)) {
    vdrive_msg_Reply* reply = sample;
    if (reply->client == client->id && reply->request_id == client->requests) {
      return reply;
    }
    dds_return_loan(client->replies.reader, &sample, 1);
  }
  return NULL;
}

// Sends a request and waits for the reply. The very first reply may be lost, so the first request
// is repeated; later ones are sent once.
static vdrive_msg_Reply* exchange(Client* client, vdrive_msg_Request* request, const char* what) {
  const dds_time_t deadline = dds_time() + kPatience;
  const dds_duration_t patience = client->requests == 0 ? kAgain : kPatience;
  vdrive_msg_Reply* reply = NULL;
  request->client = client->id;
  request->bench = client->bench;
  request->incarnation = client->incarnation;
  request->session = client->id;
  while (reply == NULL && dds_time() < deadline) {
    request->request_id = ++client->requests;
    checked(dds_write(client->requester, request), what);
    reply = wait_for_reply(client, patience);
  }
  if (reply == NULL) {
    fail("%s: no reply", what);
  } else if (reply->reason != vdrive_msg_REASON_NONE) {
    fail("%s: refused with reason %" PRIu32, what, reply->reason);
  }
  return reply;
}

static void hand_back(const Client* client, vdrive_msg_Reply* reply) {
  void* sample = reply;
  dds_return_loan(client->replies.reader, &sample, 1);
}

static void request_for_axis(Client* client, uint32_t kind, const char* what) {
  vdrive_msg_Request request = {.kind = kind};
  request.axes._buffer = &client->axis;
  request.axes._length = request.axes._maximum = 1;
  vdrive_msg_Reply* reply = exchange(client, &request, what);
  client->epoch = reply->epoch;
  hand_back(client, reply);
}

static int64_t read_object(Client* client, uint16_t index) {
  vdrive_msg_ObjectAccess object = {.axis = client->axis, .index = index};
  vdrive_msg_Request request = {.kind = vdrive_msg_REQUEST_READ};
  request.objects._buffer = &object;
  request.objects._length = request.objects._maximum = 1;
  vdrive_msg_Reply* reply = exchange(client, &request, "read");
  if (reply->objects._length != 1 || reply->objects._buffer[0].abort_code != 0) {
    fail("object %04" PRIX16 "h cannot be read", index);
  }
  const int64_t value = reply->objects._buffer[0].value;
  hand_back(client, reply);
  return value;
}

// ---- frames and status --------------------------------------------------------------------------

static void send_frame(Client* client, vdrive_msg_AxisCommand* command, uint32_t flags) {
  vdrive_msg_CommandFrame frame = {.bench = client->bench,
                                   .incarnation = client->incarnation,
                                   .session = client->id,
                                   .epoch = client->epoch,
                                   .sequence_number = ++client->frames,
                                   .flags = flags};
  if (command != NULL) {
    command->axis = client->axis;
    frame.axes._buffer = command;
    frame.axes._length = frame.axes._maximum = 1;
  }
  checked(dds_write(client->commander, &frame), "frame");
}

// Waits for the reply to the last frame. @return the tick in which the frame takes effect; 0 if no
// reply arrived
static uint64_t wait_until_applied(const Client* client, dds_duration_t patience) {
  void* sample;
  while (take(&client->command_replies, patience, &sample)) {
    const vdrive_msg_CommandReply* reply = sample;
    const bool mine = reply->session == client->id && reply->sequence_number == client->frames;
    const uint64_t tick = reply->tick;
    if (mine && (reply->refusals._length != 0 || reply->ignored_set_points._length != 0)) {
      fail("frame %" PRIu64 " was refused or ignored", client->frames);
    }
    dds_return_loan(client->command_replies.reader, &sample, 1);
    if (mine) {
      return tick;
    }
  }
  return 0;
}

// Here, too, the first reply may be lost: send keep-alives that request one until it arrives.
static void open_command_replies(Client* client) {
  const dds_time_t deadline = dds_time() + kPatience;
  do {
    send_frame(client, NULL, vdrive_msg_FRAME_WANT_REPLY);
    if (dds_time() > deadline) {
      fail("no reply to a frame");
    }
  } while (wait_until_applied(client, kKeepAlive) == 0);
}

static void note(Client* client, const vdrive_msg_AxisStatus* status) {
  client->now = *status;
}

static void step(Client* client, uint64_t ticks) {
  vdrive_msg_Request request = {
      .kind = vdrive_msg_REQUEST_STEP, .ticks = ticks, .last_sequence = client->frames};
  request.axes._buffer = &client->axis;
  request.axes._length = request.axes._maximum = 1;
  vdrive_msg_Reply* reply = exchange(client, &request, "step");
  if (reply->statuses._length != 1) {
    fail("step without status");
  }
  note(client, &reply->statuses._buffer[0]);
  hand_back(client, reply);
}

// Waits for the next status frame with the axis and keeps the session alive while waiting.
static void follow(Client* client) {
  const dds_time_t deadline = dds_time() + kPatience;
  void* sample;
  for (bool seen = false; !seen;) {
    if (dds_time() > deadline) {
      fail("the status fell silent");
    }
    if (!take(&client->statuses, kKeepAlive, &sample)) {
      send_frame(client, NULL, 0);
      continue;
    }
    const vdrive_msg_StatusFrame* frame = sample;
    for (uint32_t i = 0; i < frame->axes._length && frame->bench == client->bench; ++i) {
      if (frame->axes._buffer[i].axis == client->axis) {
        note(client, &frame->axes._buffer[i]);
        seen = true;
      }
    }
    dds_return_loan(client->statuses.reader, &sample, 1);
  }
}

// Advances by `ticks` in lock-step; otherwise waits for the next status.
static void observe(Client* client, uint64_t ticks) {
  static dds_time_t last_frame = 0;
  if (client->lockstep) {
    step(client, ticks);
    return;
  }
  if (dds_time() - last_frame > kKeepAlive) {
    last_frame = dds_time();
    send_frame(client, NULL, 0);
  }
  follow(client);
}

static void command(Client* client, vdrive_msg_AxisCommand* command) {
  send_frame(client, command, vdrive_msg_FRAME_WANT_REPLY);
  const uint64_t tick = wait_until_applied(client, kPatience);
  if (tick == 0) {
    fail("frame %" PRIu64 ": no reply", client->frames);
  }
  do {
    observe(client, 1);
  } while (client->now.tick < tick);
}

static void controlword(Client* client, const char* row, uint16_t word, uint16_t statusword) {
  vdrive_msg_AxisCommand frame = {.members = vdrive_msg_HAS_DS402_CONTROLWORD,
                                  .ds402_controlword = word};
  command(client, &frame);
  printf("%s: 6040h = 0x%02" PRIX16 ", 6041h = 0x%" PRIX16 "\n", row, word,
         client->now.ds402_statusword);
  if (client->now.ds402_statusword != statusword) {
    fail("%s: 6041h is not 0x%" PRIX16, row, statusword);
  }
}

// ---- the example --------------------------------------------------------------------------------

static void set_mode(Client* client) {
  vdrive_msg_AxisCommand mode = {.members = vdrive_msg_HAS_OP_MODE_CMD, .op_mode_cmd = 1};
  command(client, &mode);
  printf("2 profile position mode: 6061h = %" PRId8 "\n", client->now.op_mode_actual);
  if (client->now.op_mode_actual != 1) {
    fail("row 2: 6061h is not 1");
  }
}

static void set_target(Client* client) {
  vdrive_msg_AxisCommand target = {
      .members = vdrive_msg_HAS_POSITION_USER_TARGET_VALUE | vdrive_msg_HAS_PROFILE_VELOCITY |
                 vdrive_msg_HAS_PROFILE_ACC | vdrive_msg_HAS_PROFILE_DEC,
      .position_user_target_value = 10000,
      .profile_velocity = 1000,
      .profile_acc = 6000,
      .profile_dec = 6000};
  command(client, &target);
  printf("3 to 6 target 10000, 1000 UU/s, 6000 UU/s2: tick %" PRIu64 "\n", client->now.tick);
}

// 6041h is 0x1237 during the move and 0x1637 at the target.
static void wait_for_arrival(Client* client) {
  const dds_time_t deadline = dds_time() + kLongestMove;
  while (client->now.ds402_statusword == 0x1237 && dds_time() < deadline) {
    observe(client, kTicksPerStep);
  }
  if (client->now.ds402_statusword != 0x1637) {
    fail("row 9: 6041h is 0x%" PRIX16, client->now.ds402_statusword);
  }
  while (client->now.load_position_actual_value != 10000 && dds_time() < deadline) {
    observe(client, kTicksPerStep);
  }
  printf("9 arrived: 6041h = 0x%" PRIX16 ", 6062h = %" PRId32 ", 6064h = %" PRId32 "\n",
         client->now.ds402_statusword, client->now.position_demand_value,
         client->now.load_position_actual_value);
  if (read_object(client, 0x6064) != 10000 || read_object(client, 0x607A) != 10000) {
    fail("row 9: 6064h is not 10000");
  }
}

// An axis whose last client was killed is in a fault.
static void reset_fault(Client* client) {
  observe(client, 1);
  if ((client->now.ds402_statusword & 0x8) != 0) {
    controlword(client, "0 fault reset", 0x80, 0x250);
  }
}

static void run_example(Client* client) {
  reset_fault(client);
  controlword(client, "1 disable", 0x06, 0x231);
  set_mode(client);
  set_target(client);
  controlword(client, "7 switch on", 0x07, 0x233);
  controlword(client, "7 enable", 0x0F, 0x637);
  controlword(client, "8 start", 0x3F, 0x1237);
  wait_for_arrival(client);
  controlword(client, "10 disable", 0x06, 0x231);
}

static void open_client(Client* client, dds_domainid_t domain) {
  dds_guid_t guid;
  client->participant = checked(dds_create_participant(domain, NULL, NULL), "participant");
  checked(dds_get_guid(client->participant, &guid), "guid");
  memcpy(&client->id, guid.v, sizeof client->id);
  client->benches = subscribe(client, "vdrive/v1/bench", &vdrive_msg_BenchDescription_desc, kState);
  client->statuses = subscribe(client, "vdrive/v1/status", &vdrive_msg_StatusFrame_desc, kStream);
  client->command_replies =
      subscribe(client, "vdrive/v1/command_reply", &vdrive_msg_CommandReply_desc, kQueue);
  client->replies = subscribe(client, "vdrive/v1/reply", &vdrive_msg_Reply_desc, kQueue);
  client->commander = publish(client, "vdrive/v1/command", &vdrive_msg_CommandFrame_desc);
  client->requester = publish(client, "vdrive/v1/request", &vdrive_msg_Request_desc);
  wait_for_reader(client, client->commander);
  wait_for_reader(client, client->requester);
}

int main(int argc, char** argv) {
  if (argc != 4) {
    fail("usage: vendor_client DOMAIN BENCH AXIS");
  }
  setvbuf(stdout, NULL, _IOLBF, BUFSIZ);  // lets the reader see each row immediately
  Client client = {.bench = (uint32_t)strtoul(argv[2], NULL, 10),
                   .axis = (uint16_t)strtoul(argv[3], NULL, 10)};
  open_client(&client, (dds_domainid_t)strtoul(argv[1], NULL, 10));
  find_bench(&client);
  request_for_axis(&client, vdrive_msg_REQUEST_ACQUIRE, "acquire");
  open_command_replies(&client);
  printf("axis %" PRIu16 " held in epoch %" PRIu32 "\n", client.axis, client.epoch);
  run_example(&client);
  request_for_axis(&client, vdrive_msg_REQUEST_RELEASE, "release");
  printf("released\n");
  dds_delete(client.participant);
  return EXIT_SUCCESS;
}
