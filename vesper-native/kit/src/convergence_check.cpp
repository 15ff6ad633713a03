// SPDX-License-Identifier: Apache-2.0
// Check of the order of convergence of an integrator. The test problem is a body with a spring to
// the origin.
#include <cmath>
#include <cstdio>

#include "subject.hpp"

namespace vesper {
namespace {

constexpr double kMass = 2;                  // [kg]
constexpr double kStiffness = 8;             // [N/m]
constexpr double kDuration = 1.3;            // [s], not a multiple of a quarter period
constexpr double kFrequency = 2;             // sqrt(kStiffness / kMass) [rad/s]
const Vec3<double> kStart{1, -0.5, 0.25};    // [m]
const Vec3<double> kStartSpeed{0.2, 1, -1};  // [m/s]

bool Moves(const vesper_law_desc& law) {
  int found = 0;
  for (uint32_t i = 0; i < law.use_count; ++i) {
    const vesper_property_use& use = law.uses[i];
    const std::string name = use.name;
    found += (name == "position" || name == "velocity") && (use.access & VESPER_WRITE) != 0;
    found += name == "externalForce" && use.access == VESPER_READ;
  }
  return found == 3;
}

/// Returns the distance [m] from the exact solution in phase space after `steps`.
double ErrorAfter(const LawsUnderTest& subject, const vesper_law_desc& desc, uint64_t steps) {
  World world = subject.MakeWorld(1);
  AnyColumn &position = world["position"], &velocity = world["velocity"];
  world["mass"].Set(0, kMass);
  position.SetVector(0, kStart);
  velocity.SetVector(0, kStartSpeed);
  world["acceleration"].SetVector(0, kStart * (-kStiffness / kMass));
  const BareLaw law(desc, world.PropertiesFor(desc), &subject.library().table());
  const double dt = kDuration / static_cast<double>(steps);
  for (uint64_t step = 0; step < steps; ++step) {
    law.Step({dt, step}, [&](uint32_t) {
      world["externalForce"].SetVector(0, position.GetVector(0) * -kStiffness);
    });
  }
  const double c = std::cos(kFrequency * kDuration), s = std::sin(kFrequency * kDuration);
  const Vec3<double> x = kStart * c + kStartSpeed * (s / kFrequency);
  const Vec3<double> v = kStartSpeed * c - kStart * (kFrequency * s);
  return std::hypot(Length(position.GetVector(0) - x),
                    Length(velocity.GetVector(0) - v) / kFrequency);
}

}  // namespace

std::string CheckConvergence(const Subject& of) {
  const LawsUnderTest subject(of);
  if (subject.real_type() != VESPER_F64) throw CheckSkipped("f32 rounds before it converges");
  std::string note;
  for (const vesper_law_desc* desc : subject.laws()) {
    if (desc->phase != VESPER_PHASE_INTEGRATE || !Moves(*desc)) continue;
    const double coarse = ErrorAfter(subject, *desc, 64), fine = ErrorAfter(subject, *desc, 128);
    const double order = std::log2(coarse / fine);
    char text[96];
    std::snprintf(text, sizeof text, "order %.2f (errors %.2e and %.2e m)", order, coarse, fine);
    Expect(order > 0.9, std::string(desc->name) + ": " + text + "; expected at least order 1");
    note += (note.empty() ? "" : ", ") + std::string(desc->name) + " " + text;
  }
  if (note.empty()) throw CheckSkipped("does not move bodies by forces");
  return note;
}

}  // namespace vesper
