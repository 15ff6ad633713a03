// SPDX-License-Identifier: Apache-2.0
/* Two laws in tables with the layout of contract 1.MINOR. The tables of contract 1.0 have fewer
 * fields than those of today, and the tables of 1.9 have 16 bytes more. These bytes are zero,
 * unless ASKS states that the law uses their features. */
#define USE_COUNT 2
#define PARAMETER_COUNT 1
#include "test_law.h"

#define LARGEST 256
#define LATER (MINOR == 0 ? 0 : 16)
#define SIZE(type, first) (MINOR == 0 ? (first) : sizeof(type) + LATER)

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  double* velocity = law->bound[1].data;
  (void)step;
  (void)error;
  for (uint64_t i = 0; i < law->bound[1].row_count; ++i) velocity[3 * i] += law->parameters[0];
  return VESPER_OK;
}

/* Writes element i of an array whose elements have `size` bytes. */
static void Put(uint64_t* array, int i, const void* element, size_t known, uint32_t size) {
  char* at = (char*)array + i * size;
  memset(at, 0, size);
  memcpy(at, element, known < size ? known : size);
  memcpy(at, &size, sizeof size);
}

static void Fill(uint64_t* library_memory) {
  static uint64_t laws[LARGEST], uses[LARGEST], parameters[LARGEST];
  const vesper_property_use use[] = {
      REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
      REAL_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND)};
  const vesper_parameter_desc parameter = PARAMETER("gain", VESPER_UNIT_METRE_PER_SECOND, 1, 0, 9);
  const vesper_law_desc law[] = {LAW("early", VESPER_PHASE_CONSTRAIN, 0, (void*)uses, USE_COUNT,
                                     (void*)parameters, 1, Create, Bind, Act),
                                 LAW("late", VESPER_PHASE_OBSERVE, 0, (void*)uses, USE_COUNT,
                                     (void*)parameters, 1, Create, Bind, Act)};
  const vesper_law_library library = {
      sizeof library, (1u << 16) | MINOR, NAME, 2, 0, (void*)laws, NULL, NULL, 0, 0, NULL, NULL};
  const uint32_t law_size = SIZE(vesper_law_desc, 112);
  memset(laws, 0xff, sizeof laws); /* the bytes after a table do not belong to it */
  for (int i = 0; i < 2; ++i) {
    Put(uses, i, &use[i], sizeof *use, SIZE(vesper_property_use, 72));
    Put(laws, i, &law[i], sizeof *law, law_size);
  }
  Put(parameters, 0, &parameter, sizeof parameter, SIZE(vesper_parameter_desc, 80));
  memset(library_memory, 0xff, LARGEST * sizeof *library_memory);
  Put(library_memory, 0, &library, sizeof library, SIZE(vesper_law_library, 48));
  if (ASKS) ((char*)laws)[law_size - 1] = 1;
}

const vesper_law_library* vesper_law_library_entry(void) {
  static uint64_t library[LARGEST];
  Fill(library);
  return (void*)library;
}
