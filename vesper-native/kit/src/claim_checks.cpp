// SPDX-License-Identifier: Apache-2.0
// Checks of a law's claims: conservation, symmetry, and forces that derive from an energy.
#include <cmath>

#include "subject.hpp"

namespace vesper {
namespace {

constexpr uint64_t kRows = 101;

/// Returns a world after one step in which only the laws exert forces.
World AfterOneStep(const LawsUnderTest& subject) {
  World world = subject.MakeWorld(kRows);
  world.Clear("appliedForce");
  PhysicsEngine engine = world.MakeEngine(subject.file());
  engine.Advance(kDt);
  return world;
}

std::string Remainder(const char* what, double sum, double largest) {
  return std::string(what) + " sum to " + std::to_string(sum) + ", the largest force is " +
         std::to_string(largest) + " (seed " + std::to_string(kSeed) + ")";
}

void Run(const LawsUnderTest& subject, World& world) {
  PhysicsEngine engine = world.MakeEngine(subject.file());
  engine.Advance(kDt, 4);
}

}  // namespace

std::string CheckMomentum(const Subject& of) {
  const LawsUnderTest subject(of);
  subject.RequireClaim(VESPER_CLAIM_MOMENTUM);
  const World world = AfterOneStep(subject);
  const AnyColumn& force = world["externalForce"];
  Vec3<double> sum;
  for (uint64_t i = 0; i < force.rows(); ++i) sum += force.GetVector(i);
  Expect(force.Largest() > 0, "exerts no force at all");
  Expect(Length(sum) < subject.Tolerance(force.Largest()),
         Remainder("forces", Length(sum), force.Largest()));
  return "";
}

std::string CheckAngularMomentum(const Subject& of) {
  const LawsUnderTest subject(of);
  subject.RequireClaim(VESPER_CLAIM_ANGULAR_MOMENTUM);
  const World world = AfterOneStep(subject);
  const AnyColumn &force = world["externalForce"], &torque = world["torque"];
  Vec3<double> sum;
  for (uint64_t i = 0; i < force.rows(); ++i) {
    sum += Cross(world["position"].GetVector(i), force.GetVector(i)) + torque.GetVector(i);
  }
  Expect(force.Largest() + torque.Largest() > 0, "exerts no force at all");
  Expect(Length(sum) < subject.Tolerance(10 * (force.Largest() + torque.Largest())),
         Remainder("moments", Length(sum), force.Largest()));
  return "";
}

std::string CheckTranslation(const Subject& of) {
  const LawsUnderTest subject(of);
  subject.RequireClaim(VESPER_CLAIM_TRANSLATION);
  const Vec3<double> by{8, -4, 16};
  World original = subject.MakeWorld(kRows), translated = subject.MakeWorld(kRows);
  translated.Translate(by);
  Run(subject, original);
  Run(subject, translated);
  original.Translate(by);
  subject.ExpectSameResults(original, translated, 10);
  return "";
}

std::string CheckRotation(const Subject& of) {
  const LawsUnderTest subject(of);
  subject.RequireClaim(VESPER_CLAIM_ROTATION);
  const Quaternion by{{0.1, -0.5, 0.7}, 0.5};  // unit quaternion
  World straight = subject.MakeWorld(kRows), turned = subject.MakeWorld(kRows);
  turned.Rotate(by);
  Run(subject, straight);
  Run(subject, turned);
  straight.Rotate(by);
  subject.ExpectSameResults(straight, turned, 10);
  return "";
}

// Checks F = -dU/dx by central differences, for bodies at rest (friction is zero then).
std::string CheckPotentialEnergy(const Subject& of) {
  const LawsUnderTest subject(of);
  const vesper_law_desc& desc = *subject.laws().front();
  if (subject.real_type() != VESPER_F64) {
    throw CheckSkipped("differences of f32 energies say nothing");
  }
  if (subject.laws().size() > 1)
    throw CheckSkipped("the forces of the laws of a suite cannot be separated");
  if (desc.potential_energy == nullptr) throw CheckSkipped("has none");
  const double h = 1e-5;
  World world = subject.MakeWorld(7), probe = subject.MakeWorld(7);
  world.Clear("appliedForce");
  world.Clear("velocity");
  world.Clear("angularVelocity");
  PhysicsEngine engine = world.MakeEngine(subject.file());
  engine.Advance(kDt);
  const BareLaw law(desc, probe.PropertiesFor(desc), &subject.library().table());
  AnyColumn& position = probe["position"];
  const AnyColumn& force = world["externalForce"];
  for (uint64_t i = 0; i < position.size(); ++i) {
    const double x = position.Get(i);
    position.Set(i, x + h);
    const double after = law.PotentialEnergy();
    position.Set(i, x - h);
    const double before = law.PotentialEnergy();
    position.Set(i, x);
    const double gradient = -(after - before) / (2 * h);
    Expect(std::abs(force.Get(i) - gradient) <= 1e-6 * (1 + force.Largest()),
           "force " + std::to_string(force.Get(i)) + " N on row " + std::to_string(i / 3) +
               ", but the energy falls by " + std::to_string(gradient) + " J/m (seed " +
               std::to_string(kSeed) + ")");
  }
  return "";
}

// Moves each body along a line in small steps, and compares the work of its force with the change
// of the energy. The work in a step differs from the trapezoid rule by less than the change of the
// force times the length. A step of the energy, or a force that depends on the velocity or the
// time, does not satisfy this bound.
std::string CheckEnergy(const Subject& of) {
  const LawsUnderTest subject(of);
  subject.RequireClaim(VESPER_CLAIM_ENERGY);
  if (subject.real_type() != VESPER_F64) {
    throw CheckSkipped("differences of f32 energies say nothing");
  }
  if (subject.laws().size() > 1)
    throw CheckSkipped("the forces of the laws of a suite cannot be separated");
  const vesper_law_desc& desc = *subject.laws().front();
  constexpr double kLength = 0.01;  // [m]
  constexpr uint64_t kSteps = 400;
  const Vec3<double> direction{0.6, -0.48, 0.64};
  World world = subject.MakeWorld(7);
  const BareLaw law(desc, world.PropertiesFor(desc), &subject.library().table());
  AnyColumn& position = world["position"];
  uint64_t index = 0;
  for (uint64_t body = 0; body < position.rows(); ++body) {
    double energy = 0, force = 0;
    const Vec3<double> begin = position.GetVector(body);
    for (uint64_t step = 0; step <= kSteps; ++step, ++index) {
      const Vec3<double> place = begin + direction * (kLength * static_cast<double>(step));
      position.Set(3 * body, place.x);
      position.Set(3 * body + 1, place.y);
      position.Set(3 * body + 2, place.z);
      world.Clear("externalForce");
      law.Step({kDt, index}, [](uint32_t) {});
      const double energy_here = law.PotentialEnergy();
      const double force_here = Dot(world["externalForce"].GetVector(body), direction);
      if (step > 0) {
        const double work = (force + force_here) / 2 * kLength;
        const double error = std::abs(energy_here - energy + work);
        const double bound = kLength * (std::abs(force_here - force) +
                                        1e-3 * (std::abs(force_here) + std::abs(force))) +
                             1e-9 * (1 + std::abs(energy_here));
        Expect(error <= bound, "the force does " + std::to_string(work) + " J of work on body " +
                                   std::to_string(body) + " at " + std::to_string(place.x) + ", " +
                                   std::to_string(place.y) + ", " + std::to_string(place.z) +
                                   " m, but the energy changes by " +
                                   std::to_string(energy_here - energy) + " J (seed " +
                                   std::to_string(kSeed) + ")");
      }
      energy = energy_here;
      force = force_here;
    }
  }
  return "";
}

}  // namespace vesper
