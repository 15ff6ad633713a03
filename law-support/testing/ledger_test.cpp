// SPDX-License-Identifier: Apache-2.0
// Tests the engine's ledger with real laws: the entries of forces and integrators.
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "oscillator.hpp"

namespace vesper {
namespace {

constexpr uint32_t kSeed = 5;

/// Springs and weight on 60 bodies, one of them immovable, with an integrator.
template <class Real>
struct Network {
  explicit Network(const std::string& integrator)
      : scene(RandomNetwork<Real>(60, kSeed)), engine(scene.MakeEngine()) {
    scene.gravity[1] = Real{-9.81};
    std::fill_n(scene.velocity.begin(), 3, Real{0});  // the immovable body
    springs = engine.LoadPhysicsLaw("hooke_spring");
    weight = engine.LoadPhysicsLaw("gravity_field");
    motion = engine.LoadPhysicsLaw(integrator);
    engine.SetLedger(true);
  }

  vesper_ledger_entry Line(uint32_t line) { return engine.Ledger(VESPER_NO_LIBRARY, line); }

  Scene<Real> scene;
  PhysicsEngine engine;
  vesper_library_id springs, weight, motion;
};

std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void ExpectZero(const double* v, double tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(v[c], 0, tolerance) << "component " << c;
}

class LedgerIntegratorTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Laws, LedgerIntegratorTest,
                         testing::Values("newton_motion", "velocity_verlet", "runge_kutta4"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(LedgerIntegratorTest, ForcesAreCreditedWithAllMomentumAndEnergyThatItMoves) {
  Network<double> network(GetParam());
  const double before = network.scene.KineticEnergy();
  network.engine.Advance(0.005, 100);
  const double change = network.scene.KineticEnergy() - before;
  ASSERT_GT(std::abs(change), 100);
  const vesper_ledger_entry motion = network.engine.Ledger(network.motion);
  ExpectZero(motion.momentum, 1e-9);
  EXPECT_NEAR(motion.energy, 0, 1e-11 * std::abs(change));
  const double work =
      network.engine.Ledger(network.springs).energy + network.engine.Ledger(network.weight).energy;
  EXPECT_NEAR(work, change, 1e-11 * std::abs(change));
}

TEST_P(LedgerIntegratorTest, SpringsGiveNeitherMomentumNorAngularMomentum) {
  Network<double> network(GetParam());
  network.engine.Advance(0.005, 100);
  const vesper_ledger_entry springs = network.engine.Ledger(network.springs);
  ExpectZero(springs.momentum, 1e-9);
  ExpectZero(springs.angular_momentum, 1e-8);
  const vesper_ledger_entry ground = network.Line(VESPER_LEDGER_GROUND);
  EXPECT_GT(std::abs(ground.momentum[1]), 1) << "they pull at the immovable body";
}

TEST_P(LedgerIntegratorTest, LinesAddUpToWhatChanged) {
  Network<double> network(GetParam());
  const Vec3<double> momentum = network.scene.Momentum();
  const Vec3<double> angular = network.scene.AngularMomentum();
  network.engine.Advance(0.005, 50);
  double y = 0, turn = 0;
  for (const vesper_library_id law : {network.springs, network.weight, network.motion}) {
    y += network.engine.Ledger(law).momentum[1];
    turn += network.engine.Ledger(law).angular_momentum[2];
  }
  y += network.Line(VESPER_LEDGER_GROUND).momentum[1];
  turn += network.Line(VESPER_LEDGER_GROUND).angular_momentum[2];
  EXPECT_NEAR(y, network.scene.Momentum().y - momentum.y, 1e-9);
  EXPECT_NEAR(turn, network.scene.AngularMomentum().z - angular.z, 1e-8);
}

/// Returns work plus change of potential energy of an undamped spring, after one second.
double EnergyBalance(const std::string& integrator, uint32_t steps) {
  Oscillator<double> oscillator(integrator);
  oscillator.engine.SetLedger(true);
  oscillator.engine.Advance(1.0 / steps, steps);
  const vesper_ledger_entry spring = oscillator.engine.Ledger(1);
  return std::abs(spring.energy + spring.potential_energy - spring.initial_potential_energy);
}

TEST(LedgerTest, WorkOfASpringIsItsLossOfPotentialEnergyToTheOrderOfTheIntegrator) {
  EXPECT_NEAR(std::log2(EnergyBalance("newton_motion", 200) / EnergyBalance("newton_motion", 400)),
              1, 0.1);
  EXPECT_NEAR(
      std::log2(EnergyBalance("velocity_verlet", 200) / EnergyBalance("velocity_verlet", 400)), 2,
      0.1);
  EXPECT_LT(EnergyBalance("runge_kutta4", 200), 1e-8);
}

/** Returns the energy [J] that the springs dissipate in a second. */
double Loss(PhysicsEngine& engine, vesper_library_id springs) {
  engine.SetLedger(true);  // switching on again resets the ledger
  engine.Advance(1e-3, 1000);
  const vesper_ledger_entry line = engine.Ledger(springs);  // the library's first law
  return line.initial_potential_energy - line.potential_energy - line.energy;
}

TEST(LedgerTest, ExampleOfThePageIsTheOneTestedHere) {
  const std::string page = ReadFile(VESPER_DOCS "/ledger.md");
  const std::string fence = "```cpp\n";
  const size_t begin = page.find(fence) + fence.size();
  const std::string example = page.substr(begin, page.find("```", begin) - begin);
  ASSERT_FALSE(example.empty());
  EXPECT_NE(ReadFile(TEST_SOURCES "/ledger_test.cpp").find(example), std::string::npos);
}

TEST(LedgerTest, DampingShowsAsEnergyThatASpringLoses) {
  Oscillator<double> oscillator("velocity_verlet", 2);
  const double before = oscillator.Energy();
  const double loss = Loss(oscillator.engine, 1);
  EXPECT_NEAR(loss, before - oscillator.Energy(), 1e-11);
  // The amplitude decreases as exp(-c t / 2 m), the energy approximately as its square.
  EXPECT_NEAR(loss, before * (1 - std::exp(-2 * 1.0 / 4)), 0.05 * before);
}

TEST(LedgerTest, PotentialEnergyIsThatOfTheArraysAsTheyAre) {
  Oscillator<double> oscillator("newton_motion");
  EXPECT_DOUBLE_EQ(oscillator.engine.PotentialEnergy(1), 0.5 * 100 * 0.25);
  oscillator.engine.Advance(1e-3, 1);
  oscillator.scene.position[3] = 0.25;
  EXPECT_DOUBLE_EQ(oscillator.engine.PotentialEnergy(1), 0.5 * 100 * 0.0625);
}

TEST(LedgerTest, SinglePrecisionIsSummedInDouble) {
  Network<float> network("newton_motion");
  const Vec3<double> momentum = network.scene.Momentum();
  network.engine.Advance(0.005, 50);
  const double change = network.scene.Momentum().y - momentum.y;
  EXPECT_NEAR(network.Line(VESPER_LEDGER_TOTAL).momentum[1], change, 1e-9 * std::abs(change));
  // The remainder of the integrator is its rounding to 24 bits.
  EXPECT_NEAR(network.engine.Ledger(network.motion).momentum[1], 0, 1e-4 * std::abs(change));
}

}  // namespace
}  // namespace vesper
