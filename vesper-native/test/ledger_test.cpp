// SPDX-License-Identifier: Apache-2.0
// Tests the ledger: the sources of momentum, angular momentum and energy of the bodies.
#include <array>
#include <cmath>
#include <memory>
#include <random>

#include "misbehaving.h"
#include "test_kit.hpp"

namespace vesper::test {
namespace {

constexpr uint32_t kPathSeed = 4711;

struct Totals {
  std::array<double, 7> values{};  // momentum, angular momentum, energy

  Totals& operator+=(const Totals& other) {
    for (size_t i = 0; i < values.size(); ++i) values[i] += other.values[i];
    return *this;
  }
  Totals operator-(const Totals& other) const {
    Totals difference = *this;
    for (size_t i = 0; i < values.size(); ++i) difference.values[i] -= other.values[i];
    return difference;
  }
};

void ExpectNear(const Totals& found, const Totals& expected, double tolerance) {
  static constexpr const char* kNames[] = {
      "momentum x",         "momentum y",         "momentum z", "angular momentum x",
      "angular momentum y", "angular momentum z", "energy"};
  for (size_t i = 0; i < found.values.size(); ++i) {
    EXPECT_NEAR(found.values[i], expected.values[i], tolerance) << kNames[i];
  }
}

Totals Of(const vesper_ledger_entry& entry) {
  const double* p = entry.momentum;
  const double* l = entry.angular_momentum;
  return {{p[0], p[1], p[2], l[0], l[1], l[2], entry.energy}};
}

/// Computes the totals by textbook formulas, for comparison.
Totals TotalsOf(const Bodies& bodies) {
  Totals totals;
  for (size_t i = 0; i < bodies.mass.size(); ++i) {
    const double m = bodies.mass[i];
    const double* x = &bodies.position[3 * i];
    const double* v = &bodies.velocity[3 * i];
    totals += {{m * v[0], m * v[1], m * v[2], m * (x[1] * v[2] - x[2] * v[1]),
                m * (x[2] * v[0] - x[0] * v[2]), m * (x[0] * v[1] - x[1] * v[0]),
                m / 2 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])}};
  }
  return totals;
}

class LedgerTest : public BothModes {
 protected:
  LedgerTest() { Start(8); }

  /// Creates `count` bodies with the ledger on; those of mass 0 are at rest.
  void Start(size_t count, size_t immovable = 0, bool deferred = false) {
    EngineOptions options = Options();
    options.deferred = deferred;
    engine = std::make_unique<TestEngine>(options);
    bodies = Bodies(count);
    std::mt19937 random(kPathSeed);
    std::uniform_real_distribution<double> coordinate(-2, 2);
    for (double& x : bodies.position) x = coordinate(random);
    for (double& v : bodies.velocity) v = coordinate(random);
    for (size_t i = 0; i < immovable; ++i) {
      bodies.mass[i] = 0;
      std::fill_n(bodies.velocity.begin() + static_cast<ptrdiff_t>(3 * i), 3, 0.0);
    }
    engine->AddBodies(bodies);
    EXPECT_OK(SetLedger(1));
  }

  /// Adds a law by which body i pulls body i + 1 with 5 N.
  void AddChain() {
    for (uint32_t i = 0; i + 1 < bodies.mass.size(); ++i) {
      endpoints.insert(endpoints.end(), {i, i + 1});
      hooke.push_back(5);
    }
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_provider_add_physical_property(engine->provider(), "endpoints",
                                                   endpoints.data(), hooke.size(), nullptr,
                                                   hooke.size(), error);
    }));
    EXPECT_OK(engine->Add("hookeConstant", hooke, 1));
  }

  vesper_error SetLedger(uint32_t on) {
    return Try(
        [&](vesper_error* error) { return vesper_engine_set_ledger(engine->get(), on, error); });
  }
  vesper_error TryLine(vesper_library_id library, uint32_t line, vesper_ledger_entry& entry) {
    entry.struct_size = sizeof entry;
    return Try([&](vesper_error* error) {
      return vesper_engine_ledger(engine->get(), library, line, &entry, error);
    });
  }
  Totals Law(vesper_library_id library, uint32_t law = 0) {
    vesper_ledger_entry entry{};
    EXPECT_OK(TryLine(library, law, entry));
    return Of(entry);
  }
  Totals Line(uint32_t line) { return Law(VESPER_NO_LIBRARY, line); }

  Bodies bodies{0};
  std::vector<uint32_t> endpoints;
  std::vector<double> hooke;
  std::unique_ptr<TestEngine> engine;
};
IN_BOTH_MODES(LedgerTest);

TEST_P(LedgerTest, LinesAddUpToWhatChanged) {
  Start(40, 3);
  AddChain();
  EXPECT_OK(engine->Add("appliedForce", bodies.applied, 3));
  std::fill(bodies.applied.begin(), bodies.applied.end(), 0.25);
  std::vector<vesper_library_id> laws;
  for (const char* name : {"springs", "push", "commuter", "euler", "brake"}) {
    laws.push_back(engine->Load(name));
  }
  const Totals before = TotalsOf(bodies);
  EXPECT_OK(engine->Advance(0.01, 10));
  bodies.velocity[15] += 2;
  EXPECT_OK(engine->Advance(0.01, 10));
  const Totals changed = TotalsOf(bodies) - before;
  Totals sum = Line(VESPER_LEDGER_CLIENT);
  sum += Line(VESPER_LEDGER_GROUND);
  for (const vesper_library_id law : laws) sum += Law(law);
  const double rounding = 1e-13 * (std::abs(TotalsOf(bodies).values[6]) + 1e4);
  ExpectNear(sum, changed, rounding);
  ExpectNear(Line(VESPER_LEDGER_TOTAL), changed, rounding);
}

TEST_P(LedgerTest, ForceLawIsCreditedWithForceTimesTime) {
  const vesper_library_id push = engine->Load("push", {{"force", 3}});
  engine->Load("euler");
  EXPECT_OK(engine->Advance(0.125, 16));
  const Totals pushed = Law(push);
  EXPECT_DOUBLE_EQ(pushed.values[0], 8 * 3 * 2.0);  // 8 bodies, 3 N, 2 s
  EXPECT_EQ(pushed.values[1], 0);
  EXPECT_EQ(pushed.values[2], 0);
}

TEST_P(LedgerTest, WorkOfTheForcesIsTheWholeChangeOfKineticEnergy) {
  AddChain();
  const vesper_library_id springs = engine->Load("springs");
  const vesper_library_id push = engine->Load("push");
  const vesper_library_id euler = engine->Load("euler");
  const double before = TotalsOf(bodies).values[6];
  EXPECT_OK(engine->Advance(0.02, 50));
  const double change = TotalsOf(bodies).values[6] - before;
  ASSERT_GT(std::abs(change), 1);
  EXPECT_NEAR(Law(springs).values[6] + Law(push).values[6], change, 1e-12 * std::abs(change));
  EXPECT_NEAR(Law(euler).values[6], 0, 1e-12 * std::abs(change));
}

TEST_P(LedgerTest, LawThatBreaksMomentumIsFoundByItsLine) {
  AddChain();
  const vesper_library_id springs = engine->Load("springs");
  const vesper_library_id wrong = engine->Load("push", {{"force", 1e-6}});
  const vesper_library_id euler = engine->Load("euler");
  const vesper_library_id trace = engine->Load("trace_observe");
  EXPECT_OK(engine->Advance(0.01, 100));
  EXPECT_NEAR(Law(wrong).values[0], 8 * 1e-6 * 1.0, 1e-15);
  for (const vesper_library_id right : {springs, euler, trace}) {
    EXPECT_NEAR(Law(right).values[0], 0, 1e-12) << engine->LawInfo(right).name;
  }
}

TEST_P(LedgerTest, ImmovableBodyHandsWhatItTakesToTheGround) {
  Start(2, 1);
  AddChain();
  const vesper_library_id springs = engine->Load("springs");
  engine->Load("euler");
  EXPECT_OK(engine->Advance(0.5, 2));
  EXPECT_EQ(Law(springs).values[0], 0) << "the forces on the two bodies are opposite";
  EXPECT_DOUBLE_EQ(Line(VESPER_LEDGER_GROUND).values[0], -5);
  EXPECT_EQ(Line(VESPER_LEDGER_GROUND).values[6], 0) << "who stands still does no work";
  EXPECT_DOUBLE_EQ(Line(VESPER_LEDGER_TOTAL).values[0], -5);
}

TEST_P(LedgerTest, SizesOfImpulsesHaveNoDirection) {
  Start(2);
  AddChain();
  const vesper_library_id springs = engine->Load("springs");
  engine->Load("euler");
  const auto arm = [this](size_t body) {
    return std::hypot(bodies.position[3 * body + 1], bodies.position[3 * body + 2]);
  };
  const double arms = arm(0) + arm(1);  // the forces act along X
  EXPECT_OK(engine->Advance(0.5, 1));
  vesper_ledger_entry entry{};
  EXPECT_OK(TryLine(springs, 0, entry));
  EXPECT_EQ(entry.momentum[0], 0);
  EXPECT_DOUBLE_EQ(entry.impulse_size, 2 * 5 * 0.5);  // 2 bodies, 5 N, 0.5 s
  EXPECT_NEAR(entry.angular_impulse_size, 5 * 0.5 * arms, 1e-12);
  EXPECT_OK(TryLine(VESPER_NO_LIBRARY, VESPER_LEDGER_TOTAL, entry));
  EXPECT_EQ(entry.impulse_size, 0);
}

TEST_P(LedgerTest, ClientIsCreditedWithWhatItAppliesAndEdits) {
  EXPECT_OK(engine->Add("appliedForce", bodies.applied, 3));
  const vesper_library_id euler = engine->Load("euler");
  bodies.applied[1] = 4;  // [N], on the body of 1 kg
  EXPECT_OK(engine->Advance(0.25, 2));
  bodies.velocity[3] += 10;  // the body of 2 kg
  bodies.applied[1] = 0;
  EXPECT_OK(engine->Advance(0.25, 2));
  const Totals client = Line(VESPER_LEDGER_CLIENT);
  EXPECT_NEAR(client.values[0], 20, 1e-12);
  EXPECT_NEAR(client.values[1], 2, 1e-12);
  EXPECT_NEAR(Law(euler).values[0], 0, 1e-12);
  EXPECT_NEAR(Law(euler).values[1], 0, 1e-12);
}

TEST_P(LedgerTest, LawOutsideTheForcePhaseIsCreditedWithWhatItWrites) {
  const vesper_library_id brake = engine->Load("brake");
  const Totals before = TotalsOf(bodies);
  EXPECT_OK(engine->Advance(1, 1));
  ExpectNear(Law(brake), TotalsOf(bodies) - before, 1e-12);
  EXPECT_NEAR(Law(brake).values[6], (0.81 - 1) * before.values[6], 1e-12);
}

TEST_P(LedgerTest, StagesCountAlikeIfTheIntegratorDoesNotSay) {
  const vesper_library_id push = engine->Load("push", {{"force", 3}});
  engine->Load("euler_four_stages");
  EXPECT_OK(engine->Advance(0.125, 16));
  EXPECT_DOUBLE_EQ(Law(push).values[0], 8 * 3 * 2.0);
}

TEST_P(LedgerTest, ForcesThatNobodyIntegratesGiveNothing) {
  const vesper_library_id push = engine->Load("push");
  EXPECT_OK(engine->Advance(1, 3));
  ExpectNear(Law(push), {}, 0);
  ExpectNear(Line(VESPER_LEDGER_TOTAL), {}, 0);
}

TEST_P(LedgerTest, TorquesTurnBodiesThatHaveInertia) {
  std::vector<double> inertia(24, 0.5), angular_velocity(24, 0), torque(24);
  for (size_t c = 0; c < 3; ++c) inertia[c] = 0;
  angular_velocity[4] = 3;
  EXPECT_OK(engine->Add("inertia", inertia, 3));
  EXPECT_OK(engine->Add("angularVelocity", angular_velocity, 3));
  EXPECT_OK(engine->Add("torque", torque, 3));
  std::fill(bodies.orientation.begin(), bodies.orientation.end(), 0.5);
  const vesper_library_id spinning = engine->Load("spinning");
  EXPECT_OK(engine->Advance(0.25, 4));
  // 8 bodies, 2 N*m, 1 s; one has no inertia. Its neighbour already rotates at 3 rad/s.
  EXPECT_DOUBLE_EQ(Law(spinning, 0).values[4], 16);
  EXPECT_DOUBLE_EQ(Line(VESPER_LEDGER_GROUND).values[4], -2);
  EXPECT_DOUBLE_EQ(Line(VESPER_LEDGER_TOTAL).values[4], 14);
  const double energy = 0.25 * (49 - 9) + 6 * 0.25 * 16;
  EXPECT_NEAR(Law(spinning, 0).values[6], energy, 1e-12);
  ExpectNear(Law(spinning, 1), {}, 1e-12);
}

TEST_P(LedgerTest, SpinIsTakenInTheBodysOwnAxes) {
  std::vector<double> inertia(24, 0), angular_velocity(24, 0), torque(24);
  inertia[0] = 1, inertia[1] = 2, inertia[2] = 3;
  EXPECT_OK(engine->Add("inertia", inertia, 3));
  EXPECT_OK(engine->Add("angularVelocity", angular_velocity, 3));
  bodies.orientation[0] = bodies.orientation[1] = bodies.orientation[2] = 0;
  bodies.orientation[2] = bodies.orientation[3] = std::sqrt(0.5);  // the x axis points along y
  EXPECT_OK(engine->Advance(1, 1));
  angular_velocity[1] = 4;  // about the body's x axis
  EXPECT_OK(engine->Advance(1, 1));
  const Totals client = Line(VESPER_LEDGER_CLIENT);
  EXPECT_NEAR(client.values[3], 0, 1e-14);
  EXPECT_NEAR(client.values[4], 1 * 4, 1e-14);
  EXPECT_NEAR(client.values[6], 0.5 * 1 * 16, 1e-14);
}

TEST_P(LedgerTest, FailedAdvanceLeavesNoTrace) {
  const vesper_library_id push = engine->Load("push");
  engine->Load("euler");
  EXPECT_OK(engine->Advance(0.1, 5));
  const Totals before = Law(push);
  const Bodies kept = bodies;
  const vesper_library_id failing =
      engine->Load("misbehaving", {{"mode", static_cast<double>(FAIL_WITH_MESSAGE)}});
  EXPECT_REFUSED(LAW_FAILED, "diverged", engine->Advance(0.1, 5));
  ExpectNear(Law(push), before, 0);
  std::copy(kept.position.begin(), kept.position.end(), bodies.position.begin());
  std::copy(kept.velocity.begin(), kept.velocity.end(), bodies.velocity.begin());
  EXPECT_OK(engine->Unload(failing));
  EXPECT_OK(engine->Advance(0.1, 5));
  EXPECT_DOUBLE_EQ(Law(push).values[0], 2 * before.values[0]);
  ExpectNear(Line(VESPER_LEDGER_CLIENT), {}, 0);
}

TEST_P(LedgerTest, UnloadedLawsStayInTheBalance) {
  const vesper_library_id push = engine->Load("push");
  engine->Load("euler");
  EXPECT_OK(engine->Advance(0.25, 4));
  const Totals pushed = Law(push);
  EXPECT_OK(engine->Unload(push));
  ExpectNear(Line(VESPER_LEDGER_UNLOADED), pushed, 0);
  const vesper_library_id again = engine->Load("push_again");
  EXPECT_OK(engine->Advance(0.25, 4));
  EXPECT_DOUBLE_EQ(Law(again).values[0], 8 * 4.0);
  ExpectNear(Line(VESPER_LEDGER_UNLOADED), pushed, 0);
}

TEST_P(LedgerTest, BodiesMayComeAndGo) {
  const vesper_library_id push = engine->Load("push");
  const vesper_library_id euler = engine->Load("euler");
  EXPECT_OK(engine->Advance(0.25, 4));
  bodies = Bodies(12);
  EXPECT_OK(engine->Rebind("mass", bodies.mass, 1));
  for (auto [name, values] : {std::pair{"position", &bodies.position},
                              {"velocity", &bodies.velocity},
                              {"acceleration", &bodies.acceleration},
                              {"externalForce", &bodies.force}}) {
    EXPECT_OK(engine->Rebind(name, *values, 3));
  }
  EXPECT_OK(engine->Rebind("orientation", bodies.orientation, 4));
  EXPECT_OK(engine->Advance(0.25, 4));
  EXPECT_DOUBLE_EQ(Law(push).values[0], 8 + 12);
  Totals sum = Law(push);
  sum += Law(euler);
  sum += Line(VESPER_LEDGER_CLIENT);
  ExpectNear(Line(VESPER_LEDGER_TOTAL), sum, 1e-10);
}

TEST_P(LedgerTest, LawsThatDeferTheirWritesAreBookedLikeTheirTwins) {
  const auto book = [this](const std::vector<const char*>& laws, const char* beside,
                           bool deferred) {
    Start(8, 0, deferred);
    std::vector<vesper_library_id> ids;
    for (const char* law : laws) ids.push_back(engine->Load(law));
    const vesper_library_id other = engine->Load(beside);
    const vesper_library_id brake = engine->Load("brake");
    EXPECT_OK(engine->Advance(0.01, 3));
    EXPECT_OK(engine->Advance(0.01, 4));
    const Totals move = ids.size() == 1 ? Law(ids.front(), 1) : Law(ids.back());
    return std::vector<Totals>{
        Law(ids.front()),         move, Law(other), Law(brake), Line(VESPER_LEDGER_CLIENT),
        Line(VESPER_LEDGER_TOTAL)};
  };
  for (const char* beside : {"trace_observe", "push"}) {  // one or two laws add to the forces
    const std::vector<Totals> twins = book({"no_vault"}, beside, false);
    ASSERT_GT(std::abs(twins[0].values[6]), 0.1) << "the spring works";
    for (const auto& laws : {std::vector<const char*>{"vault"}, {"vault_pull", "vault_move"}}) {
      for (const bool deferred : {false, true}) {
        const std::vector<Totals> lines = book(laws, beside, deferred);
        for (size_t i = 0; i < lines.size(); ++i) ExpectNear(lines[i], twins[i], 0);
      }
    }
  }
}

TEST_P(LedgerTest, SwitchingOnAgainStartsAnew) {
  const vesper_library_id push = engine->Load("push");
  engine->Load("euler");
  EXPECT_OK(engine->Advance(0.25, 4));
  EXPECT_OK(SetLedger(1));
  ExpectNear(Law(push), {}, 0);
  EXPECT_OK(engine->Advance(0.25, 8));
  EXPECT_DOUBLE_EQ(Law(push).values[0], 8 * 2.0);
}

TEST_P(LedgerTest, RefusesLinesThatDoNotExist) {
  vesper_ledger_entry entry{};
  EXPECT_REFUSED(NOT_FOUND, "no library with id 9", TryLine(9, 0, entry));
  EXPECT_REFUSED(NOT_FOUND, "no line 4", TryLine(VESPER_NO_LIBRARY, 4, entry));
  const vesper_library_id push = engine->Load("push");
  EXPECT_REFUSED(NOT_FOUND, "there is no law 1", TryLine(push, 1, entry));
  double energy = 0;
  EXPECT_REFUSED(NOT_FOUND, "law push reports no potential energy", Try([&](vesper_error* error) {
                   return vesper_engine_potential_energy(engine->get(), push, 0, &energy, error);
                 }));
  EXPECT_OK(SetLedger(0));
  EXPECT_REFUSED(NOT_FOUND, "the ledger is off", TryLine(push, 0, entry));
}

TEST_P(LedgerTest, AsksForTheArraysItNeeds) {
  TestEngine bare(Options());
  EXPECT_OK(bare.Add("mass", bodies.mass, 1));
  EXPECT_OK(bare.Add("position", bodies.position, 3));
  ASSERT_EQ(vesper_engine_set_ledger(bare.get(), 1, nullptr), VESPER_OK);
  EXPECT_REFUSED(NOT_FOUND, "the ledger needs property velocity, which is not bound",
                 bare.Advance(1, 1));
  EXPECT_OK(bare.Add("velocity", bodies.velocity, 3));
  EXPECT_OK(bare.Advance(1, 1));
}

struct FreeEngine {
  void operator()(vesper_engine* engine) const { vesper_engine_destroy(engine); }
};
using EnginePointer = std::unique_ptr<vesper_engine, FreeEngine>;

const std::string kMass = "prototype mine\nreal f64\ntime [s]\nbody mass: real x1 [g] read\n";
const std::string kPosition = kMass + "body position: real x3 [km] read_write\n";
const std::string kVelocity = kPosition + "body velocity: real x3 [km/h] read_write\n";

EnginePointer EngineWith(const std::string& text) {
  vesper_prototype* prototype = nullptr;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_prototype_parse(text.c_str(), "test", &prototype, error);
  }));
  const vesper_engine_config config = TestConfig();
  vesper_engine* engine = nullptr;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_create(&config, prototype, &engine, error);
  }));
  vesper_prototype_free(prototype);
  return EnginePointer(engine);
}

vesper_error OpenWith(const std::string& text) {
  const EnginePointer engine = EngineWith(text);
  return Try([&](vesper_error* error) { return vesper_engine_set_ledger(engine.get(), 1, error); });
}

TEST(LedgerPrototypeTest, NamesWhatIsMissingOrIsSomethingElse) {
  EXPECT_REFUSED(NOT_FOUND, "needs property velocity: real x 3 [m/s], which prototype mine",
                 OpenWith(kPosition));
  EXPECT_REFUSED(UNIT_MISMATCH, "property velocity: is in m, the ledger expects m/s",
                 OpenWith(kPosition + "body velocity: real x3 [m] read_write\n"));
  EXPECT_REFUSED(TYPE_MISMATCH, "property velocity: is f64 x 2, the ledger expects real x 3",
                 OpenWith(kPosition + "body velocity: real x2 [m/s] read_write\n"));
  EXPECT_REFUSED(TYPE_MISMATCH, "property velocity: is of kind ball, but mass is of kind body",
                 OpenWith(kPosition + "ball velocity: real x3 [m/s] read_write\n"));
  EXPECT_REFUSED(UNIT_MISMATCH, "property torque: is in N",
                 OpenWith(kVelocity + "body torque: real x3 [N] accumulate\n"));
}

TEST(LedgerPrototypeTest, LinesAreInSiUnits) {
  const EnginePointer engine = EngineWith(kVelocity);
  double mass = 500, position[] = {0, 2, 0}, velocity[] = {0, 0, 0};  // [g], [km], [km/h]
  vesper_provider* provider = vesper_engine_property_provider(engine.get());
  for (auto [name, values] : {std::pair<const char*, double*>{"mass", &mass},
                              {"position", position},
                              {"velocity", velocity}}) {
    ASSERT_EQ(vesper_provider_add_physical_property(provider, name, values, 1, nullptr, 1, nullptr),
              VESPER_OK);
  }
  ASSERT_EQ(vesper_engine_set_ledger(engine.get(), 1, nullptr), VESPER_OK);
  ASSERT_EQ(vesper_engine_advance(engine.get(), 1, 1, nullptr), VESPER_OK);
  velocity[0] = 36;
  ASSERT_EQ(vesper_engine_advance(engine.get(), 1, 1, nullptr), VESPER_OK);
  vesper_ledger_entry client{};
  client.struct_size = sizeof client;
  ASSERT_EQ(
      vesper_engine_ledger(engine.get(), VESPER_NO_LIBRARY, VESPER_LEDGER_CLIENT, &client, nullptr),
      VESPER_OK);
  EXPECT_DOUBLE_EQ(client.momentum[0], 5);
  EXPECT_DOUBLE_EQ(client.angular_momentum[2], -10000);
  EXPECT_DOUBLE_EQ(client.energy, 25);
}

TEST(LedgerBitsTest, LedgerChangesNoBitOfTheWorldAndThreadsNoneOfTheLedger) {
  std::vector<uint64_t> hashes;
  std::vector<double> works;
  for (const auto& [ledger, threads] : {std::pair{0u, 1u}, {1u, 1u}, {0u, 4u}, {1u, 4u}}) {
    Bodies bodies(1000);
    TestEngine engine({.threads = threads});
    engine.AddBodies(bodies);
    ASSERT_EQ(vesper_engine_set_ledger(engine.get(), ledger, nullptr), VESPER_OK);
    const vesper_library_id field = engine.Load("field");
    for (const char* name : {"push", "euler", "brake"}) engine.Load(name);
    EXPECT_OK(engine.Advance(0.01, 20));
    hashes.push_back(engine.StateHash());
    if (ledger == 0) continue;
    vesper_ledger_entry entry{};
    entry.struct_size = sizeof entry;
    ASSERT_EQ(vesper_engine_ledger(engine.get(), field, 0, &entry, nullptr), VESPER_OK);
    works.push_back(entry.energy);
  }
  EXPECT_EQ(hashes, std::vector<uint64_t>(4, hashes[0]));
  EXPECT_NE(works[0], 0);
  EXPECT_EQ(works[0], works[1]);
}

}  // namespace
}  // namespace vesper::test
