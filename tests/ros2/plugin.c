// SPDX-License-Identifier: Apache-2.0
// Imitates joint_state_topic_hardware_interface, with Cyclone DDS:
//
//   ros2_plugin DOMAIN JOINT JOINT
//
// It reads /joint_states with best effort and writes /robot_joint_commands with depth 1, but only
// while the sum of |state - command| is above 1e-5: first NaN, then a sine of 0.5 rad on both
// joints for four seconds, then nothing for ten. Exit code 0: both joints followed, and stayed in
// place afterwards.
#include "ros_messages.h"

#include <dds/dds.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { kJoints = 2, kPeriodMs = 10, kNanCommands = 5, kSineCommands = 400, kSilentTurns = 1000 };

static const double kThreshold = 1e-5;
static const double kAmplitude = 0.5;
static const double kPi = 3.14159265358979323846;

typedef struct Plugin {
  dds_entity_t reader;
  dds_entity_t writer;
  char* names[kJoints];
  double state[kJoints];
  double command[kJoints];
  int received;
  int written;
  double furthest;
  double largest_step;  // between two consecutive states
} Plugin;

static void fail(const char* text) {
  fprintf(stderr, "ros2_plugin: %s\n", text);
  exit(EXIT_FAILURE);
}

static dds_entity_t checked(dds_entity_t result, const char* what) {
  if (result < 0) fail(what);
  return result;
}

static void take_state(Plugin* plugin, const sensor_msgs_msg_dds__JointState_* state) {
  const uint32_t count = state->name._length;
  if (state->position._length != count || state->velocity._length != count) {
    fail("an array is shorter than name");  // the plugin throws there
  }
  for (uint32_t i = 0; i < count; ++i) {
    for (int joint = 0; joint < kJoints; ++joint) {
      if (strcmp(state->name._buffer[i], plugin->names[joint]) != 0) continue;
      const double position = state->position._buffer[i];
      if (plugin->received > 0) {
        plugin->largest_step = fmax(plugin->largest_step, fabs(position - plugin->state[joint]));
      }
      plugin->state[joint] = position;
    }
  }
  ++plugin->received;
}

static void read_states(Plugin* plugin) {
  void* samples[1] = {NULL};
  dds_sample_info_t info[1];
  while (dds_take(plugin->reader, samples, info, 1, 1) > 0) {
    if (info[0].valid_data) take_state(plugin, samples[0]);
    dds_return_loan(plugin->reader, samples, 1);
  }
}

static bool is_at_command(const Plugin* plugin) {
  double sum = 0.0;
  for (int joint = 0; joint < kJoints; ++joint) {
    sum += fabs(plugin->state[joint] - plugin->command[joint]);
  }
  return sum <= kThreshold;  // false for NaN
}

static void write_command(Plugin* plugin) {
  if (is_at_command(plugin)) return;
  sensor_msgs_msg_dds__JointState_ message;
  memset(&message, 0, sizeof message);
  const int64_t now = dds_time();
  message.header.stamp.sec = (int32_t)(now / DDS_NSECS_IN_SEC);
  message.header.stamp.nanosec = (uint32_t)(now % DDS_NSECS_IN_SEC);
  message.header.frame_id = "";
  message.name._length = message.name._maximum = kJoints;
  message.name._buffer = plugin->names;
  message.position._length = message.position._maximum = kJoints;
  message.position._buffer = plugin->command;
  if (dds_write(plugin->writer, &message) < 0) fail("write");
  ++plugin->written;
}

static void turn(Plugin* plugin) {
  dds_sleepfor(DDS_MSECS(kPeriodMs));
  read_states(plugin);
  write_command(plugin);
  for (int joint = 0; joint < kJoints; ++joint) {
    plugin->furthest = fmax(plugin->furthest, plugin->state[joint]);
  }
}

static void open_topics(Plugin* plugin, int domain) {
  const dds_entity_t participant =
      checked(dds_create_participant((dds_domainid_t)domain, NULL, NULL), "participant");
  const dds_entity_t states =
      checked(dds_create_topic(participant, &sensor_msgs_msg_dds__JointState__desc,
                               "rt/joint_states", NULL, NULL),
              "topic");
  const dds_entity_t commands =
      checked(dds_create_topic(participant, &sensor_msgs_msg_dds__JointState__desc,
                               "rt/robot_joint_commands", NULL, NULL),
              "topic");
  dds_qos_t* sensor = dds_create_qos();  // SensorDataQoS
  dds_qset_reliability(sensor, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(sensor, DDS_HISTORY_KEEP_LAST, 5);
  plugin->reader = checked(dds_create_reader(participant, states, sensor, NULL), "reader");
  dds_delete_qos(sensor);
  dds_qos_t* one = dds_create_qos();  // QoS(1)
  dds_qset_reliability(one, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(one, DDS_HISTORY_KEEP_LAST, 1);
  plugin->writer = checked(dds_create_writer(participant, commands, one, NULL), "writer");
  dds_delete_qos(one);
}

static void wait_for_bridge(Plugin* plugin) {
  for (int i = 0; i < 3000; ++i) {
    dds_publication_matched_status_t matched;
    dds_sleepfor(DDS_MSECS(kPeriodMs));
    read_states(plugin);
    if (dds_get_publication_matched_status(plugin->writer, &matched) == DDS_RETCODE_OK &&
        matched.current_count > 0 && plugin->received > 0) {
      return;
    }
  }
  fail("no bridge");
}

int main(int count, char** arguments) {
  if (count != 2 + kJoints) fail("usage: ros2_plugin DOMAIN JOINT JOINT");
  Plugin plugin;
  memset(&plugin, 0, sizeof plugin);
  for (int joint = 0; joint < kJoints; ++joint) plugin.names[joint] = arguments[2 + joint];
  open_topics(&plugin, atoi(arguments[1]));
  wait_for_bridge(&plugin);

  double start[kJoints];
  memcpy(start, plugin.state, sizeof start);
  for (int joint = 0; joint < kJoints; ++joint) plugin.command[joint] = NAN;
  for (int i = 0; i < kNanCommands; ++i) turn(&plugin);
  // 1 - cos begins and ends at rest; two periods.
  for (int i = 1; i <= kSineCommands; ++i) {
    const double phase = 4.0 * kPi * i / kSineCommands;
    for (int joint = 0; joint < kJoints; ++joint) {
      plugin.command[joint] = start[joint] + 0.5 * kAmplitude * (1.0 - cos(phase));
    }
    turn(&plugin);
  }
  for (int joint = 0; joint < kJoints; ++joint) plugin.command[joint] = start[joint];
  for (int i = 0; i < 1000 && !is_at_command(&plugin); ++i) turn(&plugin);
  const bool has_arrived = is_at_command(&plugin);
  const int written = plugin.written;
  const int received = plugin.received;
  double drift = 0.0;
  for (int i = 0; i < kSilentTurns; ++i) {
    turn(&plugin);
    for (int joint = 0; joint < kJoints; ++joint) {
      drift = fmax(drift, fabs(plugin.state[joint] - start[joint]));
    }
  }
  printf(
      "written %d, received %d, furthest %g, largest step %g; in the pause written %d, "
      "received %d, drift %g\n",
      written, received, plugin.furthest, plugin.largest_step, plugin.written - written,
      plugin.received - received, drift);
  if (!has_arrived) fail("the joints did not return to their start");
  if (plugin.written != written) fail("it wrote in the time without commands");
  if (plugin.received - received < 100) fail("too few states came without commands");
  if (plugin.furthest < 0.8 * kAmplitude) fail("the joints did not follow the sine");
  if (plugin.furthest > 1.05 * kAmplitude) fail("the joints went too far");
  if (drift > kThreshold) fail("the joints did not hold");
  return EXIT_SUCCESS;
}
