// SPDX-License-Identifier: Apache-2.0
/* A force law that harms its process in its 50th step, in the way that HOSTILE names; before, it
 * pushes every body with 1 N. HOSTILE_AT: the function that does it, "advance" by default. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

#include "vesper/law.h"

#ifndef HOSTILE_STEP
#define HOSTILE_STEP 50
#endif

#ifndef HOSTILE_LIBRARY
#define HOSTILE_LIBRARY "hostile"
#endif

#define IS(name) (strcmp(HOSTILE, name) == 0)

struct vesper_law {
  const vesper_property* properties;
  vesper_property mass, force;
};

static const vesper_unit kKilogram = {{0, 1, 0, 0, 0, 0, 0}, 0, 1.0, "kg"};
static const vesper_unit kNewton = {{1, 1, -2, 0, 0, 0, 0}, 0, 1.0, "N"};

static volatile int depth, zero;

__attribute__((noinline)) static int overflow(int i) {
  volatile char page[4096];
  page[i % 4096] = (char)i;
  depth = i;
  return overflow(i + 1) + page[0];
}

static void* wild_thread(void* user) {
  struct vesper_law* law = user;
  volatile double* at = law->force.data;
  for (;;) at[0] = at[0] + 1;
  return NULL;
}

static void* quiet_thread(void* user) {
  for (;;) sleep(1);
  return user;
}

static void on_signal(int signal) {
  (void)signal;
  for (;;) {
  }
}

/* What a law builds before it can act: once in a process, for more rows, and for an earlier time.
 */
static void build(struct vesper_law* law, uint64_t step) {
  static uint64_t rows, last;
  if (law->force.row_count > rows || step < last) usleep(600000);
  if (law->force.row_count > rows) rows = law->force.row_count;
  last = step;
}

/* Takes all memory, so that the engine itself finds none. */
static void hoard(void) {
  for (size_t size = 1 << 20; size >= 16; size = size > 1024 ? size / 2 : size - 16) {
    while (malloc(size) != NULL) {
    }
  }
}

/* Ends the process as another program would: not again in the process that follows. */
static void kill_once(void) {
  char mark[64];
  snprintf(mark, sizeof mark, "/tmp/reve-kill-once-%d", (int)getppid());
  const int file = open(mark, O_CREAT | O_EXCL | O_WRONLY, 0600);
  if (file >= 0) raise(SIGKILL);
}

static void harm(struct vesper_law* law) {
  double* m = law != NULL ? law->mass.data : NULL;
  double* f = law != NULL ? law->force.data : NULL;
  if (IS("segfault")) *(volatile int*)8 = 1;
  if (IS("abort")) abort();
  if (IS("exit")) exit(3);
  if (IS("_exit")) _exit(4);
  if (IS("exit_0")) _exit(0);
  if (IS("overflow")) overflow(0);
  if (IS("loop")) {
    for (;;) depth++;
  }
  if (IS("sleep")) sleep(1000);
  if (IS("late_segfault")) {
    usleep(2600000);
    *(volatile int*)8 = 1;
  }
  if (IS("deadlock")) {
    pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&mutex);
    pthread_mutex_lock(&mutex);
  }
  if (IS("far_write")) {
    for (uint64_t i = 0; i < (1u << 28); ++i) ((volatile double*)f)[i] = 1e9;
  }
  if (IS("write_before")) {
    for (int64_t i = 0; i < (1 << 28); ++i) ((volatile double*)f)[-i] = 1e9;
  }
  if (IS("const_write")) ((volatile double*)m)[0] += 1;
  if (IS("wild_then_crash")) {
    for (uint64_t i = 0; i < 3 * law->force.row_count; ++i) f[i] = 1e9;
    *(volatile int*)8 = 1;
  }
  if (IS("close_all")) {
    for (int fd = 0; fd < 1024; ++fd) close(fd);
  }
  if (IS("close_all_then_crash")) {
    for (int fd = 0; fd < 1024; ++fd) close(fd);
    abort();
  }
  if (IS("alarm")) alarm(1);
  if (IS("itimer")) {
    const struct itimerval soon = {{0, 1000}, {0, 1000}};
    setitimer(ITIMER_REAL, &soon, NULL);
    setitimer(ITIMER_PROF, &soon, NULL);
  }
  if (IS("pthread_exit")) pthread_exit(NULL);
  if (IS("stop")) raise(SIGSTOP);
  if (IS("stop_once") && depth++ == 0) raise(SIGSTOP);
  if (IS("terminate")) raise(SIGTERM);
  if (IS("kill")) raise(SIGKILL);
  if (IS("handler_loops")) {
    signal(SIGSEGV, on_signal);
    *(volatile int*)8 = 1;
  }
  if (IS("handler_ignores")) {
    signal(SIGSEGV, SIG_IGN);
    signal(SIGABRT, SIG_IGN);
    abort();
  }
  if (IS("exec")) execl("/bin/sleep", "sleep", "1000", (char*)NULL);
  if (IS("fork")) {
    if (fork() == 0) {
      for (uint64_t i = 0; i < law->force.row_count; ++i) f[3 * i] = 1e9;
      sleep(1000);
    }
  }
  if (IS("fork_bomb_then_crash")) {
    for (int i = 0; i < 8; ++i) {
      if (fork() == 0) {
        sleep(1000);
        _exit(0);
      }
    }
    abort();
  }
  if (IS("memory")) {
    for (;;) *(volatile char*)malloc(1 << 20) = 1;
  }
  if (IS("wild_thread") || IS("quiet_thread")) {
    pthread_t thread;
    pthread_create(&thread, NULL, IS("wild_thread") ? wild_thread : quiet_thread, law);
  }
  if (IS("kill_once")) kill_once();
  if (IS("hoard")) hoard();
  if (IS("divide")) depth = 7 / zero;
  if (IS("illegal")) __builtin_trap();
  if (IS("free_twice")) {
    char* volatile once = malloc(100);
    free(once);
    free(once);
  }
  if (IS("print")) {
    printf("{\"event\": \"end\", \"frames\": 1}\n");
    fflush(stdout);
  }
}

#ifndef HOSTILE_AT
#define HOSTILE_AT "advance"
#endif
static void harm_in(const char* place, struct vesper_law* law) {
  if (strcmp(HOSTILE_AT, place) == 0) harm(law);
}

static vesper_status create(const vesper_host* host, vesper_suite* suite, const double* parameters,
                            vesper_law** out, vesper_error* error) {
  (void)host, (void)suite, (void)parameters, (void)error;
  harm_in("create", NULL);
  *out = calloc(1, sizeof(struct vesper_law));
  return VESPER_OK;
}

static vesper_status bind(vesper_law* law, const vesper_property* properties, vesper_error* error) {
  (void)error;
  law->mass = properties[0];
  law->force = properties[1];
  harm_in("bind", law);
  return VESPER_OK;
}

static vesper_status advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)error;
  double* force = law->force.data;
  for (uint64_t i = 0; i < law->force.row_count; ++i) force[3 * i] += 1;
  if (IS("build")) build(law, step->index);
  if (step->index >= HOSTILE_STEP) harm_in("advance", law);
  return VESPER_OK;
}

static void destroy(vesper_law* law) {
  harm_in("destroy", law);
  free(law);
}

__attribute__((constructor)) static void constructor(void) { harm_in("constructor", NULL); }
__attribute__((destructor)) static void destructor(void) { harm_in("destructor", NULL); }

const vesper_law_library* vesper_law_library_entry(void) {
  static vesper_property_use uses[2];
  static vesper_law_desc law;
  static vesper_law_library library;
  harm_in("entry", NULL);
  uses[0] = (vesper_property_use){sizeof uses[0], VESPER_F64, "mass", "body", 1,
                                  VESPER_READ,    kKilogram,  0,      0};
  uses[1] = (vesper_property_use){
      sizeof uses[1], VESPER_F64, "externalForce", "body", 3, VESPER_ACCUMULATE, kNewton, 0, 0};
  law.struct_size = sizeof law;
  law.real_type = VESPER_F64;
  law.name = "hostile";
  law.version = "1.0.0";
  law.doc = "Harms its process.";
  law.phase = VESPER_PHASE_FORCE;
  law.use_count = 2;
  law.uses = uses;
  law.create = create;
  law.bind = bind;
  law.advance = advance;
  law.destroy = destroy;
  library.struct_size = sizeof library;
  library.abi_version = VESPER_ABI_VERSION;
  library.name = HOSTILE_LIBRARY;
  library.law_count = 1;
  library.laws = &law;
  return &library;
}
