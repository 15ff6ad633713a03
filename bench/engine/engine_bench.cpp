// SPDX-License-Identifier: Apache-2.0
// Measures the engine's own cost per law and step, with laws with an empty body on 1,000 bodies and
// one thread. Compares it with one read of the columns that the engine checks for NaN. Prints a
// table.
#include <time.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "vesper/vesper.hpp"

namespace {

constexpr uint64_t kRows = 1000;
constexpr uint64_t kValues = 3 * kRows;
constexpr int kRounds = 31;  // number of rounds, each of which measures both sides
constexpr double kRoundSeconds = 0.02;

using Column = std::vector<double>;

/// Returns the processor time of this thread, which excludes other programs.
double Now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

template <class Action>
double SecondsOf(Action&& action) {
  const double start = Now();
  action();
  return Now() - start;
}

/// Returns the number of repetitions that take about kRoundSeconds.
template <class Action>
uint32_t Calibrate(Action&& action) {
  uint32_t repetitions = 1;
  while (SecondsOf([&] { action(repetitions); }) < kRoundSeconds) repetitions *= 2;
  return repetitions;
}

struct Quartiles {
  double low, median, high;

  explicit Quartiles(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    low = values[values.size() / 4];
    median = values[values.size() / 2];
    high = values[values.size() * 3 / 4];
  }
};

/// Reads every value once at cache speed, a lower bound for the cost of any test.
[[gnu::noinline, gnu::optimize("O3")]] uint64_t Stream(const std::vector<Column>& columns) {
  using Lanes [[gnu::vector_size(16)]] = uint64_t;
  const auto read = [](const double* from) {
    Lanes lanes;
    std::memcpy(&lanes, from, sizeof lanes);
    return lanes;
  };
  static_assert(kValues % 8 == 0);
  Lanes a = {}, b = {}, c = {}, d = {};  // independent chains
  for (const Column& column : columns) {
    const double* values = column.data();
    for (uint64_t i = 0; i < kValues; i += 8) {
      a |= read(values + i);
      b |= read(values + i + 2);
      c |= read(values + i + 4);
      d |= read(values + i + 6);
    }
  }
  const Lanes all = a | b | c | d;
  return all[0] | all[1];
}

/// An engine with `laws` empty laws and its own columns.
class EmptyWorld {
 public:
  explicit EmptyWorld(int laws) {
    auto provider = engine_.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass_);
    provider.AddPhysicalProperty("position", position_);
    provider.AddPhysicalProperty("velocity", velocity_);
    provider.AddPhysicalProperty("externalForce", force_);
    engine_.LoadPhysicsLaw(BENCH_LAWS "/libvesper_law_empty_" + std::to_string(laws) + ".so");
  }

  void Advance(uint32_t steps) { engine_.Advance(0.001, steps); }

 private:
  Column mass_ = Column(kRows, 1), position_ = Column(kValues, 1), velocity_ = Column(kValues, 1);
  Column force_ = Column(kValues);
  vesper::PhysicsEngine engine_{"si-f64", {.threads = 1, .validate = false}};
};

void Measure(int laws) {
  EmptyWorld world(laws);
  const std::vector<Column> columns(static_cast<size_t>(laws), Column(kValues, 1));
  volatile uint64_t sink = 0;
  const auto advance = [&](uint32_t steps) { world.Advance(steps); };
  const auto stream = [&](uint32_t times) {
    for (uint32_t i = 0; i < times; ++i) sink = sink | Stream(columns);
  };
  const uint32_t steps = Calibrate(advance), times = Calibrate(stream);
  std::vector<double> engine, memory;
  for (int round = 0; round < kRounds; ++round) {
    engine.push_back(1e9 * SecondsOf([&] { advance(steps); }) / steps / laws);
    memory.push_back(1e9 * SecondsOf([&] { stream(times); }) / times / laws);
  }
  const Quartiles cost(engine), floor(memory);
  std::printf("| %d | %.0f (%.0f to %.0f) | %.0f (%.0f to %.0f) | %.1f |\n", laws, cost.median,
              cost.low, cost.high, floor.median, floor.low, floor.high, cost.median / floor.median);
}

std::string CpuModel() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(": ") + 2);
  }
  return "unknown CPU";
}

}  // namespace

int main() {
  std::printf("CPU: %s, %u cores visible. %s.\n\n", CpuModel().c_str(),
              std::thread::hardware_concurrency(), vesper_build_info());
  std::printf(
      "| laws | engine [ns per law and step] | streaming [ns per law] | ratio |\n"
      "|---:|---:|---:|---:|\n");
  for (const int laws : {1, 10, 50}) Measure(laws);
}
