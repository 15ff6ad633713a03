// SPDX-License-Identifier: Apache-2.0
/* Does what no law may do, as its parameter `act` selects. Writes 1 to every acceleration. If an
 * act succeeds that must not, it fails with the message "succeeded". */
#define _GNU_SOURCE
#include "hostile.h"

#include <fcntl.h>
#include <linux/futex.h>
#include <pthread.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define USE_COUNT 3
#define PARAMETER_COUNT 2
#include "test_law.h"
#if defined(__x86_64__)
#include <immintrin.h>
#endif

static volatile int never = 0;

static uint64_t Next(uint64_t* state) { /* xorshift64 */
  *state ^= *state << 13;
  *state ^= *state >> 7;
  return *state ^= *state << 17;
}

/* Writes random bytes near its arrays, its stack and its heap, and at any address. */
static void WriteWildly(vesper_law* law, uint64_t seed) {
  volatile char local = 0;
  char* heap = malloc(64);
  uint64_t state = seed * 0x9e3779b97f4a7c15u + 1;
  char* near[] = {law->bound[1].data, law->bound[2].data, (char*)&local, heap,
                  (char*)law->host,   law->bound[0].data};
  for (int i = 0; i < 1000; ++i) {
    /* Most writes hit the pages of its outputs, so that many are made before one ends the process.
     */
    const uint64_t choice = Next(&state) % 4096;
    const uint64_t reach = 1ull << (Next(&state) % 36);
    const int64_t offset = (int64_t)(Next(&state) % (2 * reach)) - (int64_t)reach;
    volatile char* at = choice < 6    ? near[choice] + offset
                        : choice == 6 ? (volatile char*)Next(&state)
                                      : near[choice % 2] + Next(&state) % 2048;
    *at = (char)Next(&state);
  }
}

static int Overflow(int depth) {
  volatile char page[4096];
  page[0] = (char)depth;
  return never ? 0 : Overflow(depth + 1) + page[0];
}

/* Answers all requests without doing what they ask for; `words` is the exchange (exchange.hpp). */
static _Noreturn void AnswerForEver(volatile uint32_t* words) {
  volatile uint32_t* reply = words + 16;
  for (;;) {
    const uint32_t request = words[0];
    if (*reply == request) continue;
    words[32] = 0; /* the command */
    words[48] = 0; /* VESPER_OK */
    __sync_synchronize();
    *reply = request;
    syscall(SYS_futex, reply, FUTEX_WAKE, 1, NULL, NULL, 0);
  }
}

static void CountRanges(void* user, uint64_t begin, uint64_t end) {
  (void)begin, (void)end;
  ++*(uint64_t*)user;
}

static void* Nothing(void* argument) { return argument; }

/* Returns 1 if the act succeeded. */
static int Do(vesper_law* law, const vesper_step* step) {
  pthread_t thread;
  struct rlimit limit = {RLIM_INFINITY, RLIM_INFINITY};
  switch ((int)law->parameters[0]) {
    case OPEN_FILE:
      return open("/etc/passwd", O_RDONLY) >= 0 || open("/libvesper_law_hostile.so", O_RDONLY) >= 0;
    case OPEN_PARENT_MEMORY:
      return open("/proc/1/mem", O_RDONLY) >= 0 || open("/proc/self/environ", O_RDONLY) >= 0;
    case CREATE_SOCKET:
      return socket(AF_INET, SOCK_STREAM, 0) >= 0;
    case FORK:
      return fork() >= 0;
    case START_THREAD:
      return pthread_create(&thread, NULL, Nothing, NULL) == 0;
    case EXECUTE:
      return execl("/bin/true", "true", (char*)NULL) == 0;
    case TRACE_PARENT:
      return ptrace(PTRACE_ATTACH, (pid_t)law->parameters[1], NULL, NULL) == 0;
    case KILL_PARENT:
      return kill((pid_t)law->parameters[1], SIGKILL) == 0;
    case KILL_ALL:
      return kill(-1, SIGKILL) == 0;
    case STOP_ITSELF:
      return raise(SIGSTOP) == 0;
    case SET_HANDLER:
      return signal(SIGSEGV, SIG_IGN) != SIG_ERR;
    case SET_LIMIT:
      return setrlimit(RLIMIT_AS, &limit) == 0;
    case MAP_CODE:
      return mmap(NULL, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1,
                  0) != MAP_FAILED;
    case WRITE_NULL:
      *(volatile char*)8 = 1;
      return 1;
    case WRITE_READ_COLUMN_APART:
      ((volatile double*)law->bound[0].data)[1] = 2;
      return 1;
    case ABORT_APART:
      abort();
    case EXIT_APART:
      exit(7);
    case OVERFLOW_STACK:
      return Overflow(0) >= 0;
    case LOOP_FOR_EVER:
      while (!never) {
      }
      return 1;
    case SLEEP_FOR_EVER:
      for (;;) nanosleep(&(struct timespec){100, 0}, NULL);
    case FILL_MEMORY:
      for (size_t size = 0; size < (size_t)8 << 30; size += 1 << 20) {
        char* memory = malloc(1 << 20);
        if (memory == NULL) return 0;
        memset(memory, 1, 1 << 20);
      }
      return 1;
    case SHARE_MEMORY:
      return mmap(NULL, (size_t)8 << 30, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1,
                  0) != MAP_FAILED;
    case GROW_COLUMNS: /* the pages after the last column */
      ((volatile char*)law->bound[1].data)[(size_t)1 << 30] = 1;
      return 1;
    case WRITE_WILDLY:
      WriteWildly(law, (uint64_t)law->parameters[1] + step->index);
      return 0;
    case WRITE_NAN_APART:
      ((double*)law->bound[1].data)[3] = NAN;
      return 0;
    case LOG_LINES:
      law->host->log(law->host->context, VESPER_LOG_WARNING, "first");
      for (int i = 0; i < 5000; ++i) law->host->log(law->host->context, VESPER_LOG_INFO, "more");
      return 0;
    case FLUSH_DENORMALS:
#if defined(__x86_64__)
      _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
      return 0;
    case ANSWER_BY_ITSELF:
      AnswerForEver(*(volatile uint32_t**)law->host->context);
    case LOOP_OVER_TOO_MANY: {
      uint64_t ranges = 0;
      law->host->parallel_for(law->host->context, (uint64_t)1 << 60, (uint64_t)1 << 59, CountRanges,
                              &ranges);
      return ranges > 0;
    }
    case EXIT_AS_IF_KILLED:
      _exit(128 + SIGKILL);
    default:
      return 0;
  }
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  double* acceleration = law->bound[2].data;
  for (uint64_t i = 0; i < 3 * law->bound[2].row_count; ++i) acceleration[i] = 1;
  return Do(law, step) ? Fail(error, VESPER_LAW_FAILED, "succeeded") : VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
    REAL_USE("position", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE),
    REAL_USE("acceleration", 3, VESPER_WRITE, VESPER_UNIT_METRE_PER_SECOND_SQUARED),
};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("act", VESPER_UNIT_ONE, BEHAVE, 0, 1000),
    PARAMETER("number", VESPER_UNIT_ONE, 0, 0, 1e9),
};
static const vesper_law_desc kLaws[] = {LAW("hostile", VESPER_PHASE_CONSTRAIN, 0, kUses, USE_COUNT,
                                            kParameters, PARAMETER_COUNT, Create, Bind, Act)};
LIBRARY("hostile", kLaws, NULL, NULL)
