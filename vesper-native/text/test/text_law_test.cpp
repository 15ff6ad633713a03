// SPDX-License-Identifier: Apache-2.0
// Laws as text in an engine: forces, potentials, claims, own properties, faults.
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "text_engine.hpp"

namespace vesper::test {
namespace {

class TextLawTest : public BothModes {};
IN_BOTH_MODES(TextLawTest);

TEST_P(TextLawTest, WindPushesTowardsItsVelocity) {
  TestEngine engine(Options());
  Bodies bodies(3);
  engine.AddBodies(bodies);
  LoadText(engine,
           "law wind \"Drag towards a uniform wind.\"\n"
           "  parameter c = 100 kg/s, from 0 to 1e6 kg/s\n"
           "  parameter w = (5, 0, 0) m/s\n"
           "  each body:\n"
           "    force += c * (w - velocity)\n",
           {{"c", 2}, {"w_y", 1}});
  EXPECT_OK(engine.Advance(0.1, 1));
  EXPECT_EQ(bodies.force, (std::vector<double>{8, 2, 0, 8, 2, -2, 8, 2, -4}));
}

TEST_P(TextLawTest, TerminalSpeedIsWhereWeightAndDragBalance) {
  TestEngine engine(Options());
  Bodies bodies(1);
  engine.AddBodies(bodies);
  LoadText(engine,
           "law fall\n"
           "  parameter g = 10 m/s^2, c = 4 kg/s\n"
           "  each body:\n"
           "    force.y -= mass g\n"
           "    force -= c velocity\n");
  LoadText(engine, kMotion);
  EXPECT_OK(engine.Advance(1.0 / 64, 64 * 20));
  EXPECT_NEAR(bodies.velocity[1], -2.5, 1e-12);
}

// The text integrates an oscillator x'' = -x with the velocity half a step behind. This scheme has
// the period pi h / asin(h / 2) for a step h, and not 2 pi.
TEST_P(TextLawTest, OscillatorHasThePeriodOfTheScheme) {
  TestEngine engine(Options());
  Bodies bodies(1);
  bodies.position = {1, 0, 0};
  bodies.velocity = {0, 0, 0};
  engine.AddBodies(bodies);
  LoadText(engine, "law well\n  each body:\n    energy = 1/2 * 1 N/m position^2\n");
  LoadText(engine, kMotion);
  const double dt = 0.01;
  EXPECT_OK(engine.Advance(dt, 1000));
  // Semi-implicit Euler rotates by theta = 2 asin(dt / 2) in each step.
  const double theta = 2 * std::asin(dt / 2);
  const double expected = std::cos((1000 + 0.5) * theta) / std::cos(theta / 2);
  EXPECT_NEAR(bodies.position[0], expected, 1e-9);
}

/// Two bodies at a distance, on a diagonal.
Bodies Couple(double distance) {
  Bodies bodies(2);
  bodies.mass = {1, 1};
  bodies.position = {0, 0, 0, distance / 3, 2 * distance / 3, 2 * distance / 3};
  bodies.velocity.assign(6, 0);
  return bodies;
}

constexpr const char* kLennardJones =
    "law lennard_jones\n"
    "  parameter epsilon = 2 J, sigma = 1 m\n"
    "  each pair of bodies within 2.5 sigma, r apart:\n"
    "    energy = 4 epsilon ((sigma/r)^12 - (sigma/r)^6)\n";

TEST_P(TextLawTest, ForceOfAPairIsTheDerivativeOfItsEnergy) {
  for (const double r : {0.9, 1.0, 1.1225, 1.7, 2.4}) {
    TestEngine engine(Options());
    Bodies bodies = Couple(r);
    engine.AddBodies(bodies);
    const vesper_library_id id = LoadText(engine, kLennardJones);
    EXPECT_OK(engine.Advance(1e-3, 1));
    const double force = 4 * 2 * (12 * std::pow(r, -13) - 6 * std::pow(r, -7));
    const double tolerance = 1e-12 * std::abs(force) + 1e-12;
    EXPECT_NEAR(bodies.force[3], force / 3, tolerance);
    EXPECT_NEAR(bodies.force[4], 2 * force / 3, tolerance);
    for (size_t i = 0; i < 3; ++i) EXPECT_EQ(bodies.force[i], -bodies.force[3 + i]);
    const auto energy = [](double at) { return 8 * (std::pow(at, -12) - std::pow(at, -6)); };
    EXPECT_NEAR(PotentialEnergy(engine, id), energy(r) - energy(2.5), 1e-12 * energy(0.9));
  }
}

TEST_P(TextLawTest, WithinCutsShiftsOrSmooths) {
  const auto energy_at = [&](double r, const std::string& word) {
    TestEngine engine(Options());
    Bodies bodies = Couple(r);
    engine.AddBodies(bodies);
    const vesper_library_id id =
        LoadText(engine, "law x\n  each pair of bodies within 2 m, r apart" + word +
                             ":\n    energy = 3 J/m r\n");
    EXPECT_OK(engine.Advance(1e-3, 1));
    return PotentialEnergy(engine, id);
  };
  EXPECT_NEAR(energy_at(1, ", energy cut"), 3, 1e-12);
  EXPECT_NEAR(energy_at(1, ", energy shifted"), 3 - 6, 1e-12);
  EXPECT_NEAR(energy_at(1, ""), 3 - 6, 1e-12);
  EXPECT_NEAR(energy_at(1, ", energy smooth"), 3, 1e-12);
  EXPECT_NEAR(energy_at(1.9, ", energy smooth"), 0.5 * 3 * 1.9, 1e-12);
  EXPECT_NEAR(energy_at(1.9999, ", energy smooth"), 0, 1e-8);
  EXPECT_EQ(energy_at(2.0001, ", energy cut"), 0);
}

TEST_P(TextLawTest, PairsWithinADistanceAreThosePairs) {
  constexpr size_t kBodies = 200;
  Bodies near(kBodies), all(kBodies);
  for (size_t i = 0; i < 3 * kBodies; ++i) {
    near.position[i] = all.position[i] = 5 * std::sin(12.9898 * static_cast<double>(i));
  }
  const auto run = [&](Bodies& bodies, const std::string& heading, const std::string& condition) {
    TestEngine engine(Options());
    engine.AddBodies(bodies);
    LoadText(engine, "law x\n  " + heading + ":\n    repulsion = " + condition + "\n");
    EXPECT_OK(engine.Advance(1e-3, 1));
  };
  run(near, "each pair of bodies within 2 m, r apart", "1 N/m (2 m - r)");
  run(all, "each pair of bodies, r apart", "1 N/m (2 m - r) if r < 2 m else 0");
  double largest = 0;
  for (size_t i = 0; i < 3 * kBodies; ++i) {
    EXPECT_NEAR(near.force[i], all.force[i], 1e-12);
    largest = std::max(largest, std::abs(near.force[i]));
  }
  EXPECT_GT(largest, 1);
}

TEST_P(TextLawTest, HeatFlowsAlongSpringsAndIsConserved) {
  TestEngine engine(Options());
  Bodies bodies(3);
  engine.AddBodies(bodies);
  std::vector<uint32_t> ends{0, 1, 1, 2};
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_provider_add_physical_property(engine.provider(), "endpoints", ends.data(), 2,
                                                 nullptr, 2, error);
  }));
  // The temperature is the law's own property. The law reads its start values from the positions
  // and writes its results to them.
  LoadText(engine,
           "law heat\n"
           "  parameter k = 3 1/s\n"
           "  each body has warmth in m, flow in m/s, known\n"
           "  each body:\n"
           "    if known = 0: warmth = position.x\n"
           "    known = 1\n"
           "    flow = 0\n"
           "  each spring from a to b:\n"
           "    let q = k (a.warmth - b.warmth)\n"
           "    a.flow -= q;  b.flow += q\n"
           "  each body:\n"
           "    warmth += flow dt\n"
           "    position.y = warmth\n");
  bodies.position = {9, 0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_OK(engine.Advance(0.1, 1));
  EXPECT_NEAR(bodies.position[1], 9 - 2.7, 1e-12);
  EXPECT_NEAR(bodies.position[4], 2.7, 1e-12);
  EXPECT_EQ(bodies.position[7], 0);
  EXPECT_OK(engine.Advance(0.1, 200));
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(bodies.position[3 * i + 1], 3, 1e-9);
}

/// Returns the force of a surface with the tension `sigma` on the corner `a` of a triangle. It acts
/// along the altitude from this corner, and is half the tension times the opposite side.
std::array<double, 3> ForceOfTension(double sigma, const double* a, const double* b,
                                     const double* c) {
  double along = 0, square = 0;
  for (size_t i = 0; i < 3; ++i) {
    along += (a[i] - b[i]) * (c[i] - b[i]);
    square += (c[i] - b[i]) * (c[i] - b[i]);
  }
  std::array<double, 3> altitude;
  double height = 0;
  for (size_t i = 0; i < 3; ++i) {
    altitude[i] = b[i] + along / square * (c[i] - b[i]) - a[i];
    height += altitude[i] * altitude[i];
  }
  const double size = sigma * std::sqrt(square) / 2 / std::sqrt(height);
  return {size * altitude[0], size * altitude[1], size * altitude[2]};
}

/// Returns the area of a triangle from the lengths of its sides (Heron).
double AreaOf(const double* a, const double* b, const double* c) {
  const auto length = [](const double* p, const double* q) {
    return std::sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) +
                     (p[2] - q[2]) * (p[2] - q[2]));
  };
  const double u = length(a, b), v = length(b, c), w = length(c, a), half = (u + v + w) / 2;
  return std::sqrt(half * (half - u) * (half - v) * (half - w));
}

TEST_P(TextLawTest, SurfaceTensionPullsTheCornersOfTrianglesTogether) {
  TestEngine engine(Options());
  Bodies bodies(5);
  bodies.position = {0.3, 1, -0.5, 2, 0.25, 0.125, -1, -2, 0.75, 1.5, 3, -2.5, 4, -1, 2};
  engine.AddBodies(bodies);
  // The first two triangles share a side. The corners of the third are in another order.
  std::vector<uint32_t> corners{0, 1, 2, 2, 1, 3, 4, 3, 0};
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_provider_add_physical_property(engine.provider(), "vertices", corners.data(), 3,
                                                 nullptr, 3, error);
  }));
  const vesper_library_id id =
      LoadText(engine,
               "law surface_tension\n"
               "  parameter sigma = 3 N/m\n"
               "  each surface of a, b, c:\n"
               "    energy = 1/2 sigma |(b.position - a.position) × (c.position - a.position)|\n",
               {{"sigma", 2.5}});
  EXPECT_OK(engine.Advance(1e-3, 1));
  std::vector<double> expected(15);
  double area = 0;
  for (size_t triangle = 0; triangle < 9; triangle += 3) {
    const auto at = [&](size_t corner) {
      return bodies.position.data() + 3 * corners[triangle + corner % 3];
    };
    area += AreaOf(at(0), at(1), at(2));
    for (size_t corner = 0; corner < 3; ++corner) {
      const auto force = ForceOfTension(2.5, at(corner), at(corner + 1), at(corner + 2));
      for (size_t i = 0; i < 3; ++i) expected[3 * corners[triangle + corner] + i] += force[i];
    }
  }
  std::array<double, 3> sum{}, torque{};
  for (size_t row = 0; row < 5; ++row) {
    const double* r = bodies.position.data() + 3 * row;
    const double* f = bodies.force.data() + 3 * row;
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(f[i], expected[3 * row + i], 1e-13) << row;
      const size_t j = (i + 1) % 3, k = (i + 2) % 3;
      sum[i] += f[i];
      torque[i] += r[j] * f[k] - r[k] * f[j];
    }
  }
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(sum[i], 0, 1e-13);
    EXPECT_NEAR(torque[i], 0, 1e-13);
  }
  EXPECT_GT(std::abs(bodies.force[0]), 1);
  EXPECT_NEAR(PotentialEnergy(engine, id), 2.5 * area, 1e-12);
}

/// Returns the saved state of an engine, which contains the columns of the laws' own.
std::string SavedState(TestEngine& engine) {
  uint64_t size = 0;
  EXPECT_OK(Try([&](vesper_error* e) { return vesper_engine_state_size(engine.get(), &size, e); }));
  std::string state(size, '\0');
  EXPECT_OK(Try([&](vesper_error* e) {
    return vesper_engine_save_state(engine.get(), state.data(), size, e);
  }));
  return state;
}

TEST_P(TextLawTest, ALawOfPhaseObserveRecordsTheResultOfEachStepAndChangesNothingElse) {
  constexpr double kStep = 1.0 / 64;
  constexpr const char* kWell = "law well\n  each body:\n    energy = 1/2 * 40 N/m position^2\n";
  const std::string watch =
      "law watch\n"
      "  phase observe\n"
      "  each body has fastest in m/s, path in m\n"
      "  each body:\n"
      "    fastest = max(fastest, |velocity|)\n"
      "    path += |velocity| dt\n";
  std::vector<double> fastest(3), path(3);
  TestEngine plain(Options()), watched(Options());
  Bodies without(3), with(3);
  plain.AddBodies(without);
  watched.AddBodies(with);
  LoadText(watched,
           watch);  // before the laws of earlier phases, whose results it nevertheless sees
  for (TestEngine* engine : {&plain, &watched}) {
    LoadText(*engine, kWell);
    LoadText(*engine, kMotion);
  }
  for (int step = 0; step < 100; ++step) {
    EXPECT_OK(plain.Advance(kStep, 1));
    for (size_t row = 0; row < 3; ++row) {
      const double* v = without.velocity.data() + 3 * row;
      const double speed = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
      fastest[row] = std::max(fastest[row], speed);
      path[row] += speed * kStep;
    }
  }
  EXPECT_OK(watched.Advance(kStep, 100));
  EXPECT_EQ(with.position, without.position);
  EXPECT_EQ(with.velocity, without.velocity);
  EXPECT_EQ(with.force, without.force);
  EXPECT_EQ(watched.StateHash(), plain.StateHash());
  const std::string state = SavedState(watched);
  for (const std::vector<double>& column : {fastest, path}) {
    EXPECT_GT(column[2], column[1]);
    const std::string_view bytes(reinterpret_cast<const char*>(column.data()), 3 * sizeof(double));
    EXPECT_NE(state.find(bytes), std::string::npos) << column[0];
  }
}

TEST_P(TextLawTest, ConditionsChooseWithoutTouchingTheOtherBranch) {
  TestEngine engine(Options());
  Bodies bodies(3);
  bodies.mass = {0, 2, 4};
  engine.AddBodies(bodies);
  LoadText(engine,
           "law x\n"
           "  each body:\n"
           "    if mass > 0 kg:\n"
           "      force += (1, 0, 0) N * 1 kg / mass\n"
           "    else:\n"
           "      force += (0, 7, 0) N\n");
  EXPECT_OK(engine.Advance(0.1, 1));
  EXPECT_EQ(bodies.force, (std::vector<double>{0, 7, 0, 0.5, 0, 0, 0.25, 0, 0}));
}

TEST_P(TextLawTest, AFormulaWithoutAValueIsBlamedByItsPlace) {
  TestEngine engine(Options());
  Bodies bodies(3);
  bodies.mass = {1, 0, 4};
  engine.AddBodies(bodies);
  const vesper_library_id id = LoadText(engine,
                                        "law x\n"
                                        "  each body:\n"
                                        "    force += (1, 0, 0) N * (1 kg / mass)\n");
  const vesper_error error = engine.Advance(0.1, 1);
  EXPECT_EQ(error.status, VESPER_LAW_FAILED);
  EXPECT_NE(std::string(error.message)
                .find("x.law:3:28: '(1 kg / mass)' divides by zero for row 1 of body"),
            std::string::npos)
      << error.message;
  EXPECT_EQ(error.row, 1u);
  EXPECT_STREQ(error.property, "externalForce");
  EXPECT_EQ(error.library_id, id);
}

TEST_P(TextLawTest, APropertyOfItsOwnStaysWithinItsLimits) {
  TestEngine engine(Options());
  Bodies bodies(3);
  bodies.mass = {1, 2, 4};
  engine.AddBodies(bodies);
  const vesper_library_id id = LoadText(engine,
                                        "law x\n"
                                        "  each body has store in J, from -2 to 10 J, loss in W\n"
                                        "  each body: loss = 1 W * mass / (1 kg)\n"
                                        "  each body: store -= loss dt\n");
  EXPECT_OK(engine.Advance(0.25, 2));  // to -2 J for the last body
  const vesper_error error = engine.Advance(0.25, 1);
  EXPECT_EQ(error.status, VESPER_LAW_FAILED);
  EXPECT_NE(std::string(error.message)
                .find("x.law:2:29: 'store' is -3 J for row 2 of body, expected a value from -2 to "
                      "10 J"),
            std::string::npos)
      << error.message;
  EXPECT_EQ(error.row, 2u);
  EXPECT_STREQ(error.property, "store");
  EXPECT_EQ(error.library_id, id);
}

TEST_P(TextLawTest, LimitsHoldForWhatSpringsAddAndForEachComponent) {
  for (const std::string law : {"  each body has heat in J, from 0 J\n"
                                "  each pair a and b of bodies: a.heat -= 1 J; b.heat += 1 J\n",
                                "  each body has a vector heat in J, from 0 J\n"
                                "  each body: heat.z = -1 J\n"}) {
    TestEngine engine(Options());
    Bodies bodies(2);
    engine.AddBodies(bodies);
    LoadText(engine, "law x\n" + law);
    const vesper_error error = engine.Advance(0.25, 1);
    EXPECT_EQ(error.status, VESPER_LAW_FAILED);
    EXPECT_NE(std::string(error.message).find("'heat' is -1 J for row 0 of body"),
              std::string::npos)
        << error.message;
  }
}

TEST_P(TextLawTest, APositionThatIsNotFiniteIsAFaultOfPairsWithinADistance) {
  TestEngine engine(Options());
  Bodies bodies(4);
  bodies.position[3 * 2 + 1] = std::nan("");
  engine.AddBodies(bodies);
  const vesper_library_id id = LoadText(engine, kLennardJones);
  const vesper_error error = engine.Advance(0.1, 1);
  EXPECT_EQ(error.status, VESPER_LAW_FAILED);
  EXPECT_NE(std::string(error.message)
                .find("x.law:3:3: the position of row 2 of body is not finite, so it has no "
                      "distance to other rows"),
            std::string::npos)
      << error.message;
  EXPECT_EQ(error.row, 2u);
  EXPECT_STREQ(error.property, "position");
  EXPECT_EQ(error.library_id, id);
}

TEST(TextTest, ClaimsFollowFromTheFormulas) {
  const uint32_t all = VESPER_CLAIM_MOMENTUM | VESPER_CLAIM_ANGULAR_MOMENTUM |
                       VESPER_CLAIM_TRANSLATION | VESPER_CLAIM_ROTATION;
  EXPECT_EQ(ClaimsOf(kLennardJones), all | VESPER_CLAIM_ENERGY);
  EXPECT_EQ(ClaimsOf("law x\n  each pair of bodies, r apart:\n    attraction = 1 N/m r\n"), all);
  EXPECT_EQ(ClaimsOf("law x\n  each pair of bodies:\n"
                     "    let f = 1 kg/s (b.velocity - a.velocity)\n"
                     "    a.force += f; b.force -= f\n"),
            all & ~VESPER_CLAIM_ANGULAR_MOMENTUM);
  EXPECT_EQ(
      ClaimsOf("law x\n  each pair of bodies:\n    a.force += 1 N/m (b.position - a.position)\n"),
      uint32_t{VESPER_CLAIM_TRANSLATION | VESPER_CLAIM_ROTATION});
  EXPECT_EQ(ClaimsOf("law x\n  each body:\n    force -= 1 N/m position\n"),
            uint32_t{VESPER_CLAIM_ROTATION});
  EXPECT_EQ(ClaimsOf("law x\n  each body:\n    force.y -= 10 m/s^2 mass\n"),
            uint32_t{VESPER_CLAIM_TRANSLATION});
  EXPECT_EQ(ClaimsOf("law x\n  each body:\n    force += mass gravity\n"),
            uint32_t{VESPER_CLAIM_TRANSLATION | VESPER_CLAIM_ROTATION});
}

TEST(TextTest, EnergyIsClaimedIfAllForcesFollowFromAContinuousEnergy) {
  const auto claims = [](const std::string& heading, const std::string& energy,
                         const std::string& more = "") {
    return (ClaimsOf("law x\n  each body has k in N/m\n  each pair of bodies" + heading + ":\n" +
                     "    energy = " + energy + "\n" + more) &
            VESPER_CLAIM_ENERGY) != 0;
  };
  const std::string spring = "1/2 * 1 N/m r^2";
  EXPECT_TRUE(claims(", r apart", spring));
  EXPECT_TRUE(claims(" within 2 m, r apart", spring)) << "shifted unless said otherwise";
  EXPECT_TRUE(claims(" within 2 m, r apart, energy shifted", spring));
  EXPECT_TRUE(claims(" within 2 m, r apart, energy smooth", spring));
  EXPECT_FALSE(claims(" within 2 m, r apart, energy cut", spring));
  EXPECT_FALSE(claims(", r apart", spring + " (2 if r < 1 m else 1)")) << "has a step";
  EXPECT_FALSE(claims(", r apart", spring + " floor(r / 1 m)")) << "has steps";
  EXPECT_FALSE(claims(", r apart", spring + " sin(time / 1 s)")) << "depends on the time";
  EXPECT_FALSE(claims(", r apart", spring, "    a.force -= 1 kg/s a.velocity\n"));
  EXPECT_FALSE(claims(", r apart", spring, "  each body: force -= 1 kg/s velocity\n"));
  EXPECT_TRUE(claims(", r apart", spring, "  each body: k = 1 N / |position|\n"));
  EXPECT_FALSE(claims(", r apart", "1/2 a.k r^2", "  each body: k = 1 N / |position|\n"))
      << "the law changes its energy";
  EXPECT_TRUE(claims(", r apart", "1/2 a.k r^2"));
}

TEST(TextTest, NotationsOfOneFormulaGiveTheSameNumbers) {
  const char* forms[] = {
      "1/2 mass |velocity|^2 velocity / (1 m^2/s)", "0.5 * mass * velocity^2 * velocity / 1 m^2/s",
      "½ mass velocity² velocity / 1 m^2/s", "mass (velocity · velocity) velocity / 2 m^2/s",
      "mass dot(velocity, velocity) velocity / (2 m^2/s)"};
  std::vector<std::vector<double>> forces;
  for (const char* form : forms) {
    TestEngine engine;
    Bodies bodies(9);
    engine.AddBodies(bodies);
    LoadText(engine, std::string("law x\n  each body:\n    force += ") + form + "\n");
    EXPECT_OK(engine.Advance(0.1, 1));
    forces.push_back(bodies.force);
  }
  for (const auto& force : forces) {
    for (size_t i = 0; i < force.size(); ++i) {
      EXPECT_NEAR(force[i], forces[0][i], 1e-13 * (1 + std::abs(force[i])));
    }
  }
}

TEST(TextTest, UnitsWithOtherScalesAreConverted) {
  TestEngine engine;
  Bodies bodies(1);
  bodies.velocity = {1, 0, 0};
  engine.AddBodies(bodies);
  LoadText(engine,
           "law x\n  parameter v = 36 km/h, t = 2 min, a = 90 deg, e = 1 eV\n  each body:\n"
           "    force.x += 1 kg/s v\n"
           "    force.y += 1 N/s t\n"
           "    force.z += 1 N sin(a)\n");
  EXPECT_OK(engine.Advance(0.1, 1));
  EXPECT_NEAR(bodies.force[0], 10, 1e-13);
  EXPECT_NEAR(bodies.force[1], 120, 1e-13);
  EXPECT_NEAR(bodies.force[2], 1, 1e-15);
}

TEST(TextTest, ResultsDoNotDependOnTheNumberOfThreads) {
  const std::string text =
      "law x\n"
      "  each body has count\n"
      "  each pair of bodies, r apart:\n"
      "    energy = -1 N*m^2 / sqrt(r^2 + 1 m^2) * (1 + 0.1 sin(r / 1 m))\n"
      "    a.count += 1; b.count += 1\n"
      "  each body:\n"
      "    force += mass gravity + (count, 0, 0) N\n"
      "    count = 0\n";
  std::vector<std::vector<double>> forces;
  for (const uint32_t threads : {1u, 2u, 5u}) {
    TestEngine engine({.threads = threads});
    Bodies bodies(3000);
    for (size_t i = 0; i < bodies.position.size(); ++i) {
      bodies.position[i] = 40 * std::sin(12.9898 * static_cast<double>(i));
    }
    std::vector<double> gravity{0, -10, 0};
    engine.AddBodies(bodies);
    EXPECT_OK(engine.Add("gravity", gravity, 3));
    LoadText(engine, text);
    EXPECT_OK(engine.Advance(0.1, 2));
    forces.push_back(bodies.force);
  }
  EXPECT_EQ(forces[0], forces[1]);
  EXPECT_EQ(forces[0], forces[2]);
  EXPECT_NEAR(forces[0][0], forces[1][0], 0);
}

TEST(TextTest, ALawThatIsNotCompiledSaysWhy) {
  std::string text = "law long\n  each body:\n    let a = mass / (1 kg)\n";
  std::string sum = "0";
  for (int part = 0; part < 12; ++part) {
    const std::string name = "b" + std::to_string(part);
    text += "    let " + name + " = 0";
    for (int i = 2; i < 122; ++i) text += " + a/" + std::to_string(1000 * part + i);
    text += "\n";
    sum += " + " + name;
  }
  TestEngine engine;
  Bodies bodies(1);
  engine.AddBodies(bodies);
  LoadText(engine, text + "    force.x += 1 N (" + sum + ")\n");
  EXPECT_OK(engine.Advance(0.1, 1));
  ASSERT_EQ(engine.log().size(), 1u);
  EXPECT_NE(engine.log()[0].find("the law long is evaluated, not compiled, so it is slower: "),
            std::string::npos)
      << engine.log()[0];
}

TEST(TextTest, SeveralLawsOfOneTextAreALibrary) {
  TestEngine engine;
  Bodies bodies(1);
  engine.AddBodies(bodies);
  const vesper_library_id id =
      LoadText(engine, std::string("law pull\n  each body:\n    force += (3, 0, 0) N\n") + kMotion);
  EXPECT_OK(engine.Advance(0.5, 1));
  EXPECT_EQ(bodies.velocity[0], 1 + 1.5);
  EXPECT_STREQ(engine.LawInfo(id, 1).name, "motion");
}

TEST(TextTest, FilesAreFoundByNameAndByPath) {
  TemporaryFolder folder;
  const std::string text = "law push\n  each body:\n    force += (3, 0, 0) N\n";
  WriteFile(folder / "push.law", {text.begin(), text.end()});
  vesper_engine_config config = TestConfig();
  const std::string path = folder / "";
  config.law_path = path.c_str();
  for (const std::string& name :
       {std::string("push"), std::string("push.law"), folder / "push.law"}) {
    vesper_prepared_library* prepared = nullptr;
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_library_prepare(&config, name.c_str(), &prepared, error);
    }));
    EXPECT_STREQ(vesper_library_name(prepared), "push");
    vesper_library_discard(prepared);
  }
}

TEST(TextTest, ATextThatIsTooLongIsRefusedUnread) {
  TestEngine engine;
  vesper_library_id id = 0;
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "at most 65536",
                 TryLoadText(engine, std::string(70000, ' '), id));
}

}  // namespace
}  // namespace vesper::test
