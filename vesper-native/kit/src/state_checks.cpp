// SPDX-License-Identifier: Apache-2.0
// Checks that a law keeps no hidden state, does not move immovable bodies and writes no output.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "subject.hpp"

namespace vesper {
namespace {

constexpr uint64_t kRows = 101;

using Values = std::vector<std::vector<std::byte>>;

Values ValuesOf(World& world) {
  Values values;
  for (const AnyColumn& column : world.columns()) values.push_back(column.bytes());
  return values;
}

/// Writes values back, except scratch, which is in the engine's state.
void Restore(World& world, const Values& values) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (!values[i].empty()) {
      std::memcpy(world.columns()[i].data(), values[i].data(), values[i].size());
    }
  }
}

void ExpectSameBits(World& world, const Values& expected, const std::string& where) {
  for (size_t i = 0; i < expected.size(); ++i) {
    const AnyColumn& column = world.columns()[i];
    Expect(column.bytes() == expected[i],
           "'" + std::string(column.descriptor().name) + "' has other bits " + where);
  }
}

/// Captures the output that this process writes to one of its standard files during the life of
/// this object.
class Capture {
 public:
  explicit Capture(int file) : file_(file), memory_(memfd_create("output", MFD_CLOEXEC)) {
    if (memory_ < 0 || dup2(memory_, file_) < 0) throw std::runtime_error("no memory for output");
  }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;
  ~Capture() { close(memory_); }

  void ExpectNothing(const char* name) const {
    char text[80];
    const ssize_t size = pread(memory_, text, sizeof text, 0);
    if (size <= 0) return;
    const std::string all(text, static_cast<size_t>(size));
    throw CheckFailed("writes to " + std::string(name) + ": '" + all.substr(0, all.find('\n')) +
                      "'");
  }

 private:
  int file_, memory_;
};

}  // namespace

std::string CheckRepeat(const Subject& of) {
  const LawsUnderTest subject(of);
  World first = subject.MakeWorld(kRows), second = subject.MakeWorld(kRows);
  PhysicsEngine one = first.MakeEngine(subject.file());
  one.Advance(kDt, 3);
  PhysicsEngine other = second.MakeEngine(subject.file());
  other.Advance(kDt, 3);
  ExpectSameBits(
      second, ValuesOf(first),
      "in a second run of the same world; results may depend on the columns only, not on "
      "random numbers, a clock or addresses");
  return "";
}

std::string CheckRollback(const Subject& of) {
  const LawsUnderTest subject(of);
  World world = subject.MakeWorld(kRows);
  PhysicsEngine engine = world.MakeEngine(subject.file());
  engine.Advance(kDt, 2);
  const Values before = ValuesOf(world);
  const std::vector<std::byte> state = engine.SaveState();
  engine.Advance(kDt, 3);
  const Values after = ValuesOf(world);
  const std::string reason = "; what a law remembers between steps belongs into SCRATCH memory";
  Restore(world, before);
  engine.LoadState(state);
  engine.Advance(kDt, 3);
  ExpectSameBits(world, after, "after a rollback by 3 steps" + reason);

  World restarted = subject.MakeWorld(kRows);
  Restore(restarted, before);
  PhysicsEngine fresh = restarted.MakeEngine(subject.file());
  fresh.LoadState(state);
  fresh.Advance(kDt, 3);
  ExpectSameBits(restarted, after, "if a new engine continues from a saved state" + reason);
  return "";
}

std::string CheckMassZero(const Subject& of) {
  const LawsUnderTest subject(of);
  const std::vector<vesper_property_use> uses = subject.Uses();
  if (std::ranges::none_of(uses, [](const auto& use) {
        return use.name == std::string("mass") && (use.access & VESPER_READ) != 0;
      })) {
    throw CheckSkipped("does not read masses");
  }
  World world = subject.MakeWorld(kRows);
  constexpr uint64_t kEvery = 3;
  for (uint64_t row = 0; row < kRows; row += kEvery) world["mass"].Set(row, 0);
  const AnyColumn before = world["position"];
  PhysicsEngine engine = world.MakeEngine(subject.file());
  try {
    engine.Advance(kDt, 3);
  } catch (const Error& error) {
    throw CheckFailed("with bodies of mass 0: " + std::string(error.what()));
  }
  for (uint64_t row = 0; row < kRows; row += kEvery) {
    Expect(Length(world["position"].GetVector(row) - before.GetVector(row)) == 0,
           "moves the body of mass 0 in row " + std::to_string(row) + ", which is immovable");
  }
  return "";
}

std::string CheckOutput(const Subject& of) {
  const Capture output(STDOUT_FILENO), errors(STDERR_FILENO);
  const LawsUnderTest subject(of);
  World world = subject.MakeWorld(kRows);
  PhysicsEngine engine = world.MakeEngine(subject.file());
  engine.Advance(kDt, 2);
  std::fflush(nullptr);
  output.ExpectNothing("standard output");
  errors.ExpectNothing("standard error");
  return "";
}

}  // namespace vesper
