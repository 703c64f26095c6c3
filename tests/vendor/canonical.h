// SPDX-License-Identifier: Apache-2.0
// Shared by both sides of a comparison: values to fill a message with, and the text form of a
// field. Plain C, because one side is.
#pragma once

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef __cplusplus
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"  // C knows no other
#endif

enum { kLongestString = 256, kLongestPath = 128 };

// How a sample is filled.
typedef enum Filling {
  kEmpty,     // zeros, no element, no character
  kLowest,    // the smallest value of each type, one element, one character
  kHighest,   // the largest value of each type, as many elements and characters as the IDL allows
  kDistinct,  // a different value in each field, three elements, text beyond ASCII
  kFull,      // a different value in each field, everything as long as allowed, odd doubles
  kRandom     // any values and lengths that the IDL allows, depending on the initial count
} Filling;

// Generates values in the order of the fields; both sides get the same ones.
typedef struct Filler {
  Filling filling;
  uint64_t instance;  // for the keys; 0 = keys are filled like other fields
  uint64_t count;     // fields filled; its start makes the values of samples differ
} Filler;

// The finalizer of splitmix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators).
static inline uint64_t mixed(uint64_t word) {
  word = (word ^ (word >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
  word = (word ^ (word >> 27)) * UINT64_C(0x94D049BB133111EB);
  return word ^ (word >> 31);
}

// An odd multiplier maps different counts to different words.
static inline uint64_t next_word(Filler* filler) {
  const uint64_t word = ++filler->count * UINT64_C(0x9E3779B97F4A7C15);
  return filler->filling == kRandom ? mixed(word) : word;
}

static inline uint64_t next_unsigned(Filler* filler, int bits) {
  const uint64_t word = next_word(filler);
  switch (filler->filling) {
    case kEmpty:
    case kLowest:
      return 0;
    case kHighest:
      return UINT64_MAX >> (64 - bits);
    default:
      return word >> (64 - bits);
  }
}

static inline int64_t next_signed(Filler* filler, int bits) {
  const uint64_t word = next_word(filler);
  const int64_t highest = (int64_t)(UINT64_MAX >> (65 - bits));
  switch (filler->filling) {
    case kEmpty:
      return 0;
    case kLowest:
      return -highest - 1;
    case kHighest:
      return highest;
    default:
      return (int64_t)(word >> (64 - bits)) - highest - 1;
  }
}

static inline uint64_t next_key(Filler* filler, int bits) {
  const uint64_t value = next_unsigned(filler, bits);
  return filler->instance != 0 ? filler->instance : value;
}

static inline double next_real(Filler* filler) {
  static const double odd[] = {-0.0, HUGE_VAL, __builtin_nan(""), DBL_TRUE_MIN};
  const uint64_t word = next_word(filler);
  switch (filler->filling) {
    case kEmpty:
      return 0.0;
    case kLowest:
      return -DBL_MAX;
    case kHighest:
      return DBL_MAX;
    case kDistinct:
      return (double)filler->count / 3.0;
    case kRandom:
      return (double)(int64_t)word / 3.0;
    default:
      return odd[filler->count % 4];
  }
}

static inline bool next_boolean(Filler* filler) {
  const uint64_t word = next_word(filler);
  if (filler->filling == kRandom) {
    return word % 2 == 1;
  }
  return filler->filling != kEmpty && filler->filling != kLowest;
}

static inline uint32_t next_length(const Filler* filler, uint32_t bound) {
  switch (filler->filling) {
    case kEmpty:
      return 0;
    case kLowest:
      return 1;
    case kDistinct:
      return bound < 3 ? bound : 3;
    case kRandom:
      return (uint32_t)(mixed(filler->count) % (bound + 1));
    default:
      return bound;
  }
}

// Returns a string of at most `bound` bytes, which is below kLongestString. Characters beyond ASCII
// are never split.
static inline const char* next_string(Filler* filler, size_t bound, char* text) {
  static const char piece[] = "\xC3\xA9";  // e with acute accent, two bytes
  const uint64_t word = next_word(filler);
  text[0] = '\0';
  switch (filler->filling) {
    case kEmpty:
      break;
    case kLowest:
      strcpy(text, "a");
      break;
    case kHighest:
      memset(text, '~', bound);
      text[bound] = '\0';
      break;
    case kDistinct:  // a quarter of the bound, so shorter than allowed
      snprintf(text, bound / 4 + 2, "\xE2\x82\xAC%" PRIu64, filler->count);  // euro sign
      break;
    case kRandom: {
      const size_t length = word % (bound + 1);
      for (size_t i = 0; i < length; ++i) {
        text[i] = (char)('!' + mixed(word + i) % 90);
      }
      text[length] = '\0';
      break;
    }
    default:
      if (bound % 2 == 1) {
        strcpy(text, "x");
      }
      while (strlen(text) < bound) {
        strcat(text, piece);
      }
  }
  return text;
}

// Writes one line per field: "axes[2].objects[0].value=-17".

static inline void write_unsigned(FILE* out, const char* path, const char* name, uint64_t value) {
  fprintf(out, "%s%s=%" PRIu64 "\n", path, name, value);
}

static inline void write_signed(FILE* out, const char* path, const char* name, int64_t value) {
  fprintf(out, "%s%s=%" PRId64 "\n", path, name, value);
}

// Writes the bits, so that -0 and NaNs are distinguished as well.
static inline void write_real(FILE* out, const char* path, const char* name, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  fprintf(out, "%s%s=0x%016" PRIX64 "\n", path, name, bits);
}

static inline void write_string(FILE* out, const char* path, const char* name, const char* value) {
  fprintf(out, "%s%s=\"%s\"\n", path, name, value);
}

static inline void write_length(FILE* out, const char* path, const char* name, size_t length) {
  fprintf(out, "%s%s.length=%zu\n", path, name, length);
}

// Returns "axes[2]." for an element of a sequence of structures, "axes[2]" for other elements.
static inline const char* element_path(char* text, const char* path, const char* name, size_t index,
                                       const char* end) {
  const int length = snprintf(text, kLongestPath, "%s%s[%zu]%s", path, name, index, end);
  if (length < 0 || length >= kLongestPath) {
    abort();
  }
  return text;
}

#ifdef __cplusplus
#pragma GCC diagnostic pop
#endif
