// SPDX-License-Identifier: Apache-2.0
// Checks for mistakes that show only in some worlds, or only after a long time: bodies at one
// place, changed floating-point modes, memory that grows, forces that depend on the step, names.
#include <malloc.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <limits>
#include <span>

#include "nearest_name.hpp"
#include "subject.hpp"
#include "vesper/kit/test_prototype.hpp"

namespace vesper {
namespace {

constexpr uint64_t kBodies = 101;

/// The modes of this thread that change the results of arithmetic.
struct FloatingPointModes {
  int rounding = std::fegetround();
  // The factor is volatile, because the compiler must not compute the product.
  bool flushes = Halved(std::numeric_limits<double>::min()) == 0;

  static double Halved(double number) {
    volatile double half = 0.5;
    return number * half;
  }
};

/// Throws an exception unless this thread has the default modes.
void ExpectDefaultModes(const std::string& where) {
  const FloatingPointModes modes;
  Expect(modes.rounding == FE_TONEAREST,
         where + " leaves another rounding mode; restore it (fesetround) before the return");
  Expect(!modes.flushes, where + " leaves a mode in which small numbers become 0");
}

/// Returns the memory that this process has allocated [bytes].
size_t AllocatedBytes() {
  const struct mallinfo2 now = mallinfo2();
  return now.uordblks + now.hblkhd;
}

/// Returns whether the names have nearly the same length. The similar name is another word if the
/// lengths differ more.
bool IsMisspelt(std::string_view name, const std::string& nearest) {
  constexpr size_t kMost = 2;
  return std::max(name.size(), nearest.size()) - std::min(name.size(), nearest.size()) <= kMost;
}

/// Returns whether a law remembers earlier steps. Its force, for example that of friction, may
/// depend on the length of these steps.
bool Remembers(const LawsUnderTest& subject) {
  return std::ranges::any_of(subject.Uses(),
                             [](const auto& use) { return use.access == VESPER_SCRATCH; });
}

bool HasIntegrator(const LawsUnderTest& subject) {
  return std::ranges::any_of(subject.laws(),
                             [](const auto* law) { return law->phase == VESPER_PHASE_INTEGRATE; });
}

}  // namespace

std::string CheckCoincident(const Subject& of) {
  const LawsUnderTest subject(of);
  const std::vector<vesper_property_use> uses = subject.Uses();
  if (std::ranges::none_of(uses, [](const auto& use) {
        return use.name == std::string("position") && (use.access & VESPER_READ) != 0;
      })) {
    throw CheckSkipped("does not read positions");
  }
  World world = subject.MakeWorld(kBodies);
  AnyColumn& position = world["position"];
  constexpr uint64_t kEvery = 3;
  for (uint64_t row = 1; row < kBodies; row += kEvery) {
    position.SetVector(row, position.GetVector(row - 1));
  }
  PhysicsEngine engine = world.MakeEngine(subject.file());
  try {
    engine.Advance(kDt, 3);
  } catch (const Error& error) {
    throw CheckFailed("with two bodies at one place: " + std::string(error.what()));
  }
  return "";
}

std::string CheckModes(const Subject& of) {
  const LawsUnderTest subject(of);
  for (const vesper_law_desc* desc : subject.laws()) {
    World world = subject.MakeWorld(kBodies);
    const BareLaw law(*desc, world.PropertiesFor(*desc),
                      &subject.library().table(subject.real_type()));
    ExpectDefaultModes(std::string(desc->name) + ": its constructor or Bind");
    law.Step({kDt, 0}, [](uint32_t) {});
    ExpectDefaultModes(std::string(desc->name) + ": Advance");
  }
  return "";
}

std::string CheckMemory(const Subject& of) {
  const LawsUnderTest subject(of);
  // Laws may sometimes enlarge their buffers. Therefore only growth in each of several periods
  // counts as a leak.
  constexpr int kPeriods = 4;
  constexpr uint32_t kSteps = 64;
  constexpr size_t kLeast = 8;  // minimum size of a leak in a step [bytes]
  World world = subject.MakeWorld(kBodies);
  PhysicsEngine engine = world.MakeEngine(subject.file(), 1, false);
  engine.Advance(kDt, kSteps);
  size_t least = std::numeric_limits<size_t>::max(), last = AllocatedBytes();
  for (int period = 0; period < kPeriods; ++period) {
    engine.Advance(kDt, kSteps);
    const size_t now = AllocatedBytes();
    least = std::min(least, now > last ? now - last : 0);
    last = now;
  }
  Expect(least < kLeast * kSteps, "allocates about " + std::to_string(least / kSteps) +
                                      " bytes more in each step, and does not free them");
  return "";
}

std::string CheckStepLength(const Subject& of) {
  const LawsUnderTest subject(of);
  if (HasIntegrator(subject)) throw CheckSkipped("moves bodies");
  if (Remembers(subject)) throw CheckSkipped("remembers earlier steps in SCRATCH memory");
  World whole = subject.MakeWorld(kBodies), half = subject.MakeWorld(kBodies);
  whole.MakeEngine(subject.file()).Advance(kDt);
  half.MakeEngine(subject.file()).Advance(kDt / 2);
  bool has_force = false;
  for (const vesper_property_use& use : subject.Uses()) {
    if (use.access != VESPER_ACCUMULATE) continue;
    has_force = true;
    const AnyColumn &a = whole[use.name], &b = half[use.name];
    const double tolerance = subject.Tolerance(1 + a.Largest());
    for (uint64_t i = 0; i < a.size(); ++i) {
      Expect(std::abs(a.Get(i) - b.Get(i)) <= tolerance,
             "'" + std::string(use.name) + "' in row " +
                 std::to_string(i / a.descriptor().components) + " is " + std::to_string(a.Get(i)) +
                 " in a step of dt, and " + std::to_string(b.Get(i)) +
                 " in a step of dt / 2; the engine multiplies forces by dt");
    }
  }
  if (!has_force) throw CheckSkipped("exerts no force");
  return "";
}

std::string CheckNames(const Subject& of) {
  const LawsUnderTest subject(of);
  const vesper_prototype& prototype = TestPrototype(subject.real_type());
  for (const vesper_property_use& use : subject.Uses()) {
    if (use.access == VESPER_SCRATCH) continue;
    std::vector<std::string> names;
    for (const auto& property : std::span(prototype.properties, prototype.property_count)) {
      if (property.kind == std::string(use.kind)) names.emplace_back(property.name);
    }
    if (std::ranges::find(names, use.name) != names.end()) continue;
    const std::string* nearest = NearestName(use.name, names);
    if (nearest != nullptr && IsMisspelt(use.name, *nearest)) {
      throw CheckFailed("'" + std::string(use.name) + "' is no property of the kind '" + use.kind +
                        "'; did you mean '" + *nearest + "'?");
    }
  }
  return "";
}

}  // namespace vesper
