// SPDX-License-Identifier: Apache-2.0
// Checks of a library in an engine: loading, rows, threads, parameters, bad input, time.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>

#include "subject.hpp"

namespace vesper {
namespace {

/// Returns the number of mappings of law libraries in this process.
int CountMappings() {
  std::ifstream maps("/proc/self/maps");
  int count = 0;
  for (std::string line; std::getline(maps, line);) {
    if (line.find("libvesper_law_") != std::string::npos) ++count;
  }
  return count;
}

size_t CountEntries(const char* folder) {
  const std::filesystem::directory_iterator entries(folder);
  return static_cast<size_t>(std::distance(begin(entries), end(entries)));
}

/// Expects that an error names the law. Expects that it names the input if only the input can be
/// the cause.
void ExpectBlame(const LawsUnderTest& subject, const std::string& input, const Error& error) {
  const std::string what = error.what();
  if (error.status() == VESPER_INVALID_ARGUMENT && error.property() == input) return;
  Expect(error.status() == VESPER_LAW_MISBEHAVED || error.status() == VESPER_LAW_FAILED, what);
  Expect(std::ranges::any_of(subject.laws(), [&](auto* law) { return law->name == error.law(); }),
         "the law is not named: " + what);
  Expect(error.status() == VESPER_LAW_FAILED ||
             subject.Written().contains(std::string(error.property())),
         "the property is not named: " + what);
}

}  // namespace

std::string CheckReload(const Subject& of) {
  const LawsUnderTest subject(of);
  World world = subject.MakeWorld(7);
  PhysicsEngine engine = world.MakeEngine(subject.file());
  engine.UnloadPhysicsLaw(1);
  const int mappings = CountMappings();
  const size_t files = CountEntries("/proc/self/fd"), threads = CountEntries("/proc/self/task");
  for (int i = 0; i < 10; ++i) {
    const vesper_library_id id = world.Load(engine, subject.file());
    engine.Advance(kDt);
    Expect(CountMappings() > mappings || !subject.library().is_native(),
           "the library was not mapped again");
    engine.UnloadPhysicsLaw(id);
  }
  Expect(CountMappings() == mappings,
         "stays mapped after it was unloaded; compile it with -fno-gnu-unique");
  Expect(CountEntries("/proc/self/fd") == files, "leaves open files");
  Expect(CountEntries("/proc/self/task") == threads, "leaves threads");
  return "";
}

std::string CheckRows(const Subject& of) {
  const LawsUnderTest subject(of);
  for (const uint64_t rows : {0, 1, 7, 1021}) {
    World world = subject.MakeWorld(rows);
    PhysicsEngine engine = world.MakeEngine(subject.file());
    try {
      engine.Advance(kDt, 3);
    } catch (const Error& error) {
      throw CheckFailed("on " + std::to_string(rows) + " rows: " + error.what());
    }
  }
  return "";
}

/// Returns the processor time of all threads of this process [s].
double ProcessorTime() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Returns the processor time of two steps [s]. Makes one step before these two. It prepares memory
/// and is not counted.
double TimeOfSteps(const LawsUnderTest& subject, uint64_t rows) {
  World world = subject.MakeWorld(rows);
  PhysicsEngine engine = world.MakeEngine(subject.file());
  engine.Advance(kDt);
  const double before = ProcessorTime();
  engine.Advance(kDt, 2);
  return ProcessorTime() - before;
}

/// Returns whether twice the rows take about four times as long. Returns false if twice the rows
/// take less than a millisecond. The measurement of such a short time is inexact, and such a fast
/// law needs no smaller number of rows.
bool IsQuadratic(const LawsUnderTest& subject, uint64_t rows) {
  const double twice = TimeOfSteps(subject, 2 * rows);
  return twice > 0.001 && twice > 3 * TimeOfSteps(subject, rows);
}

/// Returns a number of rows that gives each thread several chunks. Laws whose time is quadratic in
/// the rows divide their work into small chunks, so fewer rows suffice for them.
uint64_t RowsForThreads(const LawsUnderTest& subject) {
  constexpr uint64_t kFew = 2003;
  World world = subject.MakeWorld(kFew);
  PhysicsEngine engine = world.MakeEngine(subject.file());
  const auto start = std::chrono::steady_clock::now();
  engine.Advance(kDt, 2);
  const bool is_slow = std::chrono::steady_clock::now() - start > std::chrono::milliseconds(20);
  return is_slow || IsQuadratic(subject, kFew) ? 10007 : 40009;
}

std::string CheckThreads(const Subject& of) {
  const LawsUnderTest subject(of);
  const uint64_t rows = RowsForThreads(subject);
  World one = subject.MakeWorld(rows);
  PhysicsEngine reference = one.MakeEngine(subject.file());
  reference.Advance(kDt, 2);
  for (const uint32_t threads : {2, 8}) {
    World many = subject.MakeWorld(rows);
    PhysicsEngine engine = many.MakeEngine(subject.file(), threads);
    engine.Advance(kDt, 2);
    for (size_t i = 0; i < one.columns().size(); ++i) {
      const std::string name = one.columns()[i].descriptor().name;
      Expect(many.columns()[i].bytes() == one.columns()[i].bytes(),
             "'" + name + "' has other bits on " + std::to_string(threads) + " threads than on 1");
    }
    Expect(engine.StateHash() == reference.StateHash(), "the state hash differs");
  }
  return "";
}

std::string CheckParameters(const Subject& of) {
  const LawsUnderTest subject(of);
  bool has_any = false;
  for (const vesper_law_desc* law : subject.laws()) {
    for (const auto& parameter : std::span(law->parameters, law->parameter_count)) {
      has_any = true;
      for (const double value : {parameter.minimum, parameter.maximum}) {
        World world = subject.MakeWorld(7);
        PhysicsEngine engine = world.MakeEngine(subject.file());
        engine.UnloadPhysicsLaw(1);
        world.Load(engine, subject.file(),
                   {{std::string(law->name) + "." + parameter.name, value}});
      }
    }
  }
  if (!has_any) throw CheckSkipped("has no parameters");
  return "";
}

std::string CheckNotANumber(const Subject& of) {
  const LawsUnderTest subject(of);
  int inputs = 0, reported = 0;
  for (const vesper_property_use& use : subject.Uses()) {
    if ((use.access & VESPER_READ) == 0 || use.scalar_type == VESPER_FIELD) continue;
    World clean = subject.MakeWorld(7), poisoned = subject.MakeWorld(7);
    AnyColumn& input = poisoned[use.name];
    if (!input.is_real()) continue;
    if ((input.descriptor().law_access & VESPER_ACCUMULATE) != 0)
      continue;  // computed by the
                 // engine
    ++inputs;
    input.Set(input.rows() / 2 * use.components, std::numeric_limits<double>::quiet_NaN());
    PhysicsEngine reference = clean.MakeEngine(subject.file());
    PhysicsEngine engine = poisoned.MakeEngine(subject.file());
    reference.Advance(kDt);
    try {
      engine.Advance(kDt);
    } catch (const Error& error) {
      ++reported;
      ExpectBlame(subject, use.name, error);
      continue;
    }
    for (const std::string& name : subject.Written()) {
      Expect(poisoned[name].bytes() == clean[name].bytes(),
             "NaN in '" + std::string(use.name) + "' changes '" + name + "' without an error");
    }
  }
  if (inputs == 0) throw CheckSkipped("has no real inputs");
  Expect(reported > 0 || subject.Written().empty(), "no NaN in any input is ever reported");
  return std::to_string(reported) + " of " + std::to_string(inputs) + " inputs report it";
}

std::string MeasureTime(const Subject& of) {
  const LawsUnderTest subject(of);
  for (uint64_t rows = 100;; rows *= 10) {
    World world = subject.MakeWorld(rows);
    PhysicsEngine engine = world.MakeEngine(subject.file(), 1, false);
    engine.Advance(kDt, 10);
    uint64_t total = 0;
    std::string note;
    for (const vesper_law_info& law : engine.Laws(1)) {
      const double each = static_cast<double>(law.nanoseconds) / static_cast<double>(law.calls);
      char text[64];
      std::snprintf(text, sizeof text, "%.2f ns", each / static_cast<double>(rows));
      note += (note.empty() ? "" : ", ") + std::string(law.name) + " " + text;
      total += law.nanoseconds;
    }
    // Ten times the rows would take a hundred times as long if the time is quadratic in the number
    // of rows.
    if (rows == 100000 || total > 10'000'000) {
      return note + " per row and call, " + std::to_string(rows) + " rows, 1 thread";
    }
  }
}

}  // namespace vesper
