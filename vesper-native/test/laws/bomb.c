// SPDX-License-Identifier: Apache-2.0
/* Crashes while it is loaded, called, read or unloaded. BOMB selects the time. */
#include <signal.h>
#include <unistd.h>

#include "test_law.h"

#define CRASH_IN_CONSTRUCTOR 1
#define EXIT_IN_CONSTRUCTOR 2
#define HANG_IN_CONSTRUCTOR 3
#define CRASH_IN_ENTRY 4
#define GARBAGE_TABLE 5
#define NULL_TABLE 6
#define OTHER_ABI 7
#define GARBAGE_NAME 8
#define ABORT_IN_DESTRUCTOR 9
#define FORGED_REPORT 10

#if BOMB == CRASH_IN_CONSTRUCTOR
__attribute__((constructor)) static void GoOff(void) { raise(SIGSEGV); }
#elif BOMB == EXIT_IN_CONSTRUCTOR
__attribute__((constructor)) static void GoOff(void) { _exit(7); }
#elif BOMB == HANG_IN_CONSTRUCTOR
__attribute__((constructor)) static void GoOff(void) {
  for (;;) pause();
}
#elif BOMB == ABORT_IN_DESTRUCTOR
__attribute__((destructor)) static void GoOff(void) { abort(); }
#elif BOMB == FORGED_REPORT
/* Imitates a refusal report of vesper-probe, but with unterminated strings. */
__attribute__((constructor)) static void GoOff(void) {
  struct {
    int32_t stage;
    vesper_error error;
  } report = {.stage = 0, .error = {.status = VESPER_LIBRARY_LOAD_FAILED}};
  memset(report.error.property, 'x', sizeof report.error.property);
  memset(report.error.message, 'x', sizeof report.error.message);
  _exit(write(4, &report, sizeof report) == sizeof report ? 0 : 1);
}
#endif

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law;
  (void)step;
  (void)error;
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM)};
static const vesper_law_desc kLaws[] = {
    LAW("bomb", VESPER_PHASE_OBSERVE, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
static vesper_law_library library = {
    sizeof library, VESPER_ABI_VERSION, "bomb", 1, 0, kLaws, NULL, NULL, 0, 0, NULL, NULL};

const vesper_law_library* vesper_law_library_entry(void) {
#if BOMB == CRASH_IN_ENTRY
  raise(SIGBUS);
#elif BOMB == GARBAGE_TABLE
  return (const vesper_law_library*)(uintptr_t)64;
#elif BOMB == NULL_TABLE
  return NULL;
#elif BOMB == OTHER_ABI
  /* The engine must read nothing after the version. If it read the name, it would crash. */
  library.abi_version = 2u << 16;
  library.name = (const char*)(uintptr_t)64;
#elif BOMB == GARBAGE_NAME
  library.name = (const char*)(uintptr_t)64;
#endif
  return &library;
}
