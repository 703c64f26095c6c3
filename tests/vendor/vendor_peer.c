// SPDX-License-Identifier: Apache-2.0
// A Cyclone DDS writer or reader, controlled by lines on standard input:
//
//   vendor_peer DOMAIN TOPIC reader|writer
//
//   match                          waits up to ten seconds for the other side; answers "matched"
//   write FILLING INSTANCE COUNT   writes a sample and answers with its text (canonical.h)
//   take                           waits for a sample and answers with its text
//
// A text ends with a line "end". Exit code 0 at the end of the input; 1, with a line on standard
// error, if DDS refuses something or nothing arrives within ten seconds.
#include "canonical.h"
#include "vdrive_messages.h"

#include <dds/dds.h>

#include <stdlib.h>

static const dds_duration_t kPatience = DDS_SECS(10);
static const int32_t kAxesInDomain = 65536;
static const int32_t kSessionsInDomain = 65536;

// clang-format off
#define STRUCTURE(type) static inline void fill_##type(vdrive_msg_##type* m, Filler* filler) {
#define END(type) }
#define UNSIGNED(name, bits) m->name = (uint##bits##_t)next_unsigned(filler, bits);
#define SIGNED(name, bits) m->name = (int##bits##_t)next_signed(filler, bits);
#define KEY_UNSIGNED(name, bits) m->name = (uint##bits##_t)next_key(filler, bits);
#define REAL(name) m->name = next_real(filler);
#define BOOLEAN(name) m->name = next_boolean(filler);
#define STRING(name, bound) next_string(filler, bound, m->name);
#define ELEMENTS(name, bound, statement) \
  m->name._length = m->name._maximum = next_length(filler, bound); \
  m->name._release = true; \
  m->name._buffer = dds_alloc(m->name._length * sizeof *m->name._buffer); \
  for (uint32_t i = 0; i < m->name._length; ++i) { statement; }
#define SEQUENCE(name, type, bound) ELEMENTS(name, bound, fill_##type(&m->name._buffer[i], filler))
#define SEQUENCE_OF_UNSIGNED(name, bits, bound) \
  ELEMENTS(name, bound, m->name._buffer[i] = (uint##bits##_t)next_unsigned(filler, bits))
#define SEQUENCE_OF_SIGNED(name, bits, bound) \
  ELEMENTS(name, bound, m->name._buffer[i] = (int##bits##_t)next_signed(filler, bits))
#include "fields.inc"
#undef STRUCTURE
#undef END
#undef UNSIGNED
#undef SIGNED
#undef KEY_UNSIGNED
#undef REAL
#undef BOOLEAN
#undef STRING
#undef ELEMENTS
#undef SEQUENCE
#undef SEQUENCE_OF_UNSIGNED
#undef SEQUENCE_OF_SIGNED

#define STRUCTURE(type) \
  static inline void write_##type(const char* path, const vdrive_msg_##type* m) {
#define END(type) }
#define UNSIGNED(name, bits) write_unsigned(stdout, path, #name, m->name);
#define SIGNED(name, bits) write_signed(stdout, path, #name, m->name);
#define KEY_UNSIGNED(name, bits) UNSIGNED(name, bits)
#define REAL(name) write_real(stdout, path, #name, m->name);
#define BOOLEAN(name) write_unsigned(stdout, path, #name, m->name);
#define STRING(name, bound) write_string(stdout, path, #name, m->name);
#define ELEMENTS(name, statement) \
  write_length(stdout, path, #name, m->name._length); \
  for (uint32_t i = 0; i < m->name._length; ++i) { char child[kLongestPath]; statement; }
#define SEQUENCE(name, type, bound) \
  ELEMENTS(name, write_##type(element_path(child, path, #name, i, "."), &m->name._buffer[i]))
#define SEQUENCE_OF_UNSIGNED(name, bits, bound) \
  ELEMENTS(name, write_unsigned(stdout, element_path(child, path, #name, i, ""), "", m->name._buffer[i]))
#define SEQUENCE_OF_SIGNED(name, bits, bound) \
  ELEMENTS(name, write_signed(stdout, element_path(child, path, #name, i, ""), "", m->name._buffer[i]))
#include "fields.inc"

// clang-format on

// The QoS of docs/reference/wire.md.
typedef struct Quality {
  bool reliable;
  bool transient_local;
  bool keep_all;
  int32_t depth;
  int32_t instances;
} Quality;

typedef struct Topic {
  const char* name;
  const dds_topic_descriptor_t* type;
  void (*fill)(void* sample, Filler* filler);
  void (*write)(const void* sample);
  Quality quality;
} Topic;

#define ANY(type)                                        \
  static void fill_any_##type(void* m, Filler* filler) { \
    fill_##type(m, filler);                              \
  }                                                      \
  static void write_any_##type(const void* m) {          \
    write_##type("", m);                                 \
  }
ANY(CommandFrame)
ANY(CommandReply)
ANY(Request)
ANY(Reply)
ANY(StatusFrame)
ANY(AxisStatus)
ANY(AxisParameters)
ANY(Event)
ANY(BenchDescription)
ANY(BenchState)
ANY(SessionName)
ANY(BenchSession)

#define TOPIC(name, type, ...)                                                         \
  {                                                                                    \
    "vdrive/v1/" name, &vdrive_msg_##type##_desc, fill_any_##type, write_any_##type, { \
      __VA_ARGS__                                                                      \
    }                                                                                  \
  }
#define QUEUE .reliable = true, .keep_all = true, .depth = 1024, .instances = 1
#define LAST .reliable = true, .transient_local = true, .depth = 1

static const Topic kTopics[] = {
    TOPIC("command", CommandFrame, QUEUE),
    TOPIC("command_reply", CommandReply, QUEUE),
    TOPIC("request", Request, QUEUE),
    TOPIC("reply", Reply, QUEUE),
    TOPIC("status", StatusFrame, .depth = 64, .instances = 1),
    TOPIC("axis", AxisStatus, .depth = 1, .instances = kAxesInDomain),
    TOPIC("parameters", AxisParameters, LAST, .instances = kAxesInDomain),
    TOPIC("event", Event, .reliable = true, .transient_local = true, .depth = 1024,
          .instances = 1024),
    TOPIC("bench", BenchDescription, LAST, .instances = 4096),
    TOPIC("bench_state", BenchState, .depth = 1, .instances = 1024),
    TOPIC("session", SessionName, LAST, .instances = kSessionsInDomain),
    TOPIC("bench_session", BenchSession, LAST, .instances = 1024 * 256),
};

static dds_entity_t checked(dds_entity_t result, const char* what) {
  if (result < 0) {
    fprintf(stderr, "vendor_peer: %s: %s\n", what, dds_strretcode(-result));
    exit(EXIT_FAILURE);
  }
  return result;
}

static const Topic* find_topic(const char* name) {
  for (size_t i = 0; i < sizeof kTopics / sizeof kTopics[0]; ++i) {
    if (strcmp(kTopics[i].name, name) == 0) {
      return &kTopics[i];
    }
  }
  fprintf(stderr, "vendor_peer: no topic %s\n", name);
  exit(EXIT_FAILURE);
}

static dds_qos_t* qos_of(const Quality* quality) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(
      qos, quality->reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
  dds_qset_durability(
      qos, quality->transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, quality->keep_all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST,
                   quality->depth);
  dds_qset_resource_limits(qos, quality->depth * quality->instances, quality->instances,
                           quality->depth);
  dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, quality->depth,
                              quality->depth * quality->instances, quality->instances,
                              quality->depth);
  dds_qset_writer_data_lifecycle(qos, false);
  return qos;
}

// Waits for one of the statuses of `mask`. @return false at the deadline
static bool wait_until(dds_entity_t waitset, dds_entity_t endpoint, uint32_t mask,
                       dds_time_t deadline) {
  checked(dds_set_status_mask(endpoint, mask), "status mask");
  return dds_waitset_wait_until(waitset, NULL, 0, deadline) > 0;
}

static void match(dds_entity_t waitset, dds_entity_t endpoint, bool is_reader) {
  const uint32_t mask =
      is_reader ? DDS_SUBSCRIPTION_MATCHED_STATUS : DDS_PUBLICATION_MATCHED_STATUS;
  puts(wait_until(waitset, endpoint, mask, dds_time() + kPatience) ? "matched" : "alone");
}

static void answer(const Topic* topic, const void* sample) {
  topic->write(sample);
  puts("end");
}

static void write_sample(const Topic* topic, dds_entity_t writer, const char* line) {
  int filling = 0;
  Filler filler = {0};
  if (sscanf(line, "write %d %" SCNu64 " %" SCNu64, &filling, &filler.instance, &filler.count) !=
      3) {
    fprintf(stderr, "vendor_peer: cannot read %s", line);
    exit(EXIT_FAILURE);
  }
  filler.filling = (Filling)filling;
  void* sample = dds_alloc(topic->type->m_size);
  topic->fill(sample, &filler);
  checked(dds_write(writer, sample), "write");
  answer(topic, sample);
  dds_sample_free(sample, topic->type, DDS_FREE_ALL);
}

static void take_sample(const Topic* topic, dds_entity_t waitset, dds_entity_t reader,
                        const char* line) {
  const dds_time_t deadline = dds_time() + DDS_MSECS(strtol(line + strlen("take "), NULL, 10));
  for (;;) {
    void* sample = NULL;
    dds_sample_info_t info;
    const int32_t count = checked(dds_take(reader, &sample, &info, 1, 1), "take");
    const bool found = count == 1 && info.valid_data;
    if (found) {
      answer(topic, sample);
    }
    if (count > 0) {
      checked(dds_return_loan(reader, &sample, count), "return");
    }
    if (found) {
      return;
    }
    if (count == 0 && !wait_until(waitset, reader, DDS_DATA_AVAILABLE_STATUS, deadline)) {
      puts("end");
      return;
    }
  }
}

static void obey(const Topic* topic, dds_entity_t waitset, dds_entity_t endpoint, bool is_reader) {
  char line[128];
  while (fgets(line, sizeof line, stdin) != NULL) {
    if (strcmp(line, "match\n") == 0) {
      match(waitset, endpoint, is_reader);
    } else if (is_reader) {
      take_sample(topic, waitset, endpoint, line);
    } else {
      write_sample(topic, endpoint, line);
    }
    fflush(stdout);
  }
}

int main(int argc, char** argv) {
  if (argc != 4) {
    fprintf(stderr, "usage: vendor_peer DOMAIN TOPIC reader|writer\n");
    return EXIT_FAILURE;
  }
  const Topic* topic = find_topic(argv[2]);
  const bool is_reader = strcmp(argv[3], "reader") == 0;
  const dds_entity_t participant =
      checked(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  const dds_entity_t subject =
      checked(dds_create_topic(participant, topic->type, topic->name, NULL, NULL), topic->name);
  dds_qos_t* qos = qos_of(&topic->quality);
  const dds_entity_t endpoint =
      checked(is_reader ? dds_create_reader(participant, subject, qos, NULL)
                        : dds_create_writer(participant, subject, qos, NULL),
              argv[3]);
  dds_delete_qos(qos);
  const dds_entity_t waitset = checked(dds_create_waitset(participant), "waitset");
  checked(dds_set_status_mask(endpoint, 0), "status mask");
  checked(dds_waitset_attach(waitset, endpoint, 0), "attach");
  obey(topic, waitset, endpoint, is_reader);
  dds_delete(participant);
  return EXIT_SUCCESS;
}
