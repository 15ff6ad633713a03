// SPDX-License-Identifier: Apache-2.0
// Times two programs for the same work in turn, A B A B .... So other activity of the machine
// affects both programs. Also measures this activity.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace bench {

struct Clock {
  double wall, processor, busy;  // [s]; busy: time of all programs on all processors

  static Clock Now() {
    using namespace std::chrono;
    rusage own{};
    getrusage(RUSAGE_SELF, &own);
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    double user = 0, nice = 0, system = 0, idle = 0, wait = 0, irq = 0, soft = 0, stolen = 0;
    if (FILE* file = std::fopen("/proc/stat", "r")) {
      if (std::fscanf(file, "cpu %lf %lf %lf %lf %lf %lf %lf %lf", &user, &nice, &system, &idle,
                      &wait, &irq, &soft, &stolen) != 8) {
        user = nice = system = irq = soft = stolen = 0;
      }
      std::fclose(file);
    }
    const double ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
    return {duration<double>(steady_clock::now().time_since_epoch()).count(),
            seconds(own.ru_utime) + seconds(own.ru_stime),
            (user + nice + system + irq + soft + stolen) / ticks};
  }
};

inline double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Medians over the rounds.
struct Timing {
  double wall, processor;  // [s] per call
};
struct Comparison {
  Timing a, b;
  double foreign;  // processors used by other programs in the meantime
};

/// Rounds of one side.
class Series {
 public:
  explicit Series(uint64_t calls = 1) : calls_(calls) {}

  /// Times one round, and returns its duration [s].
  template <class Action>
  double Measure(Action& action) {
    const Clock start = Clock::Now();
    for (uint64_t i = 0; i < calls_; ++i) action();
    const Clock end = Clock::Now();
    const auto n = static_cast<double>(calls_);
    wall_.push_back((end.wall - start.wall) / n);
    processor_.push_back((end.processor - start.processor) / n);
    return end.wall - start.wall;
  }
  Timing Result() const { return {Median(wall_), Median(processor_)}; }

 private:
  uint64_t calls_;  // calls per round
  std::vector<double> wall_, processor_;
};

/// Returns the number of calls that take about this many seconds. Ignores the first call, which may
/// include setup.
template <class Action>
uint64_t Calibrate(Action& action, double seconds) {
  action();
  uint64_t calls = 1;
  while (Series(calls).Measure(action) < seconds / 2) calls *= 2;
  return calls;
}

/** Calls a and b in turn, each for about `seconds` per round; returns medians over the rounds. */
template <class A, class B>
Comparison SideBySide(A&& a, B&& b, int rounds = 9, double seconds = 0.1) {
  Series of_a(Calibrate(a, seconds)), of_b(Calibrate(b, seconds));
  const Clock start = Clock::Now();
  for (int round = 0; round < rounds; ++round) {
    of_a.Measure(a);
    of_b.Measure(b);
  }
  const Clock end = Clock::Now();
  const double others = (end.busy - start.busy) - (end.processor - start.processor);
  return {of_a.Result(), of_b.Result(), std::max(0.0, others / (end.wall - start.wall))};
}

}  // namespace bench
