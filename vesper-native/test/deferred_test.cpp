// SPDX-License-Identifier: Apache-2.0
// Compares laws that keep the newest values in their own memory with equal laws that do not.
#include <algorithm>
#include <cstddef>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

constexpr double kDt = 0.01;

using Lines = std::vector<std::string>;

/// Bodies with an engine. vault and no_vault compute the same sums.
struct Scene {
  Scene(const std::vector<const char*>& laws, const EngineOptions& options) : engine(options) {
    engine.AddBodies(bodies);
    EXPECT_OK(engine.Add("angularVelocity", spin, 3));
    for (const char* law : laws) ids.push_back(engine.Load(law));
  }

  void ExpectSameAs(const Scene& twin) const {
    EXPECT_EQ(bodies.position, twin.bodies.position);
    EXPECT_EQ(bodies.velocity, twin.bodies.velocity);
    EXPECT_EQ(bodies.force, twin.bodies.force);
    EXPECT_EQ(spin, twin.spin);
  }

  Bodies bodies{40};
  std::vector<double> spin = std::vector<double>(120);
  TestEngine engine;
  std::vector<vesper_library_id> ids;
};

class DeferredTest : public BothModes {
 protected:
  EngineOptions Plain() const { return {.validate = GetParam()}; }
  /// Returns options of a client that synchronizes explicitly.
  EngineOptions Deferred() const { return {.validate = GetParam(), .deferred = true}; }
};
IN_BOTH_MODES(DeferredTest);

TEST_P(DeferredTest, ChangesNoBitWhateverLawsAreBesideIt) {
  const std::vector<std::vector<const char*>> suites = {{"vault"}, {"vault_pull", "vault_move"}};
  const std::vector<std::vector<const char*>> others = {{},
                                                        {"push"},
                                                        {"relay_spin", "relay_acceleration"},
                                                        {"push", "trace_constrain", "relay_spin"}};
  for (const auto& other : others) {
    std::vector<const char*> laws = {"no_vault"};
    laws.insert(laws.end(), other.begin(), other.end());
    Scene twin(laws, Plain());
    EXPECT_OK(twin.engine.Advance(kDt, 5));
    for (const auto& suite : suites) {
      for (const bool deferred : {false, true}) {
        for (const uint32_t threads : {1u, 2u}) {
          laws = suite;
          laws.insert(laws.end(), other.begin(), other.end());
          Scene run(laws, {.validate = GetParam(), .threads = threads, .deferred = deferred});
          EXPECT_OK(run.engine.Advance(kDt, 2));
          EXPECT_OK(run.engine.Advance(kDt, 3));
          if (deferred) EXPECT_OK(run.engine.SynchronizeAll());
          run.ExpectSameAs(twin);
        }
      }
    }
  }
}

TEST_P(DeferredTest, ConvertsUnitsLikeAnyLaw) {
  Scene twin({"no_vault_cm"}, Plain());
  Scene run({"vault_cm"}, Plain());
  EXPECT_OK(twin.engine.Advance(kDt, 1));
  EXPECT_OK(run.engine.Advance(kDt, 1));
  run.ExpectSameAs(twin);
  EXPECT_OK(twin.engine.Advance(kDt, 20));
  EXPECT_OK(run.engine.Advance(kDt, 20));
  for (size_t i = 0; i < run.bodies.position.size(); ++i) {
    EXPECT_NEAR(run.bodies.position[i], twin.bodies.position[i], 1e-12);
  }
}

TEST_P(DeferredTest, AdvanceLeavesArraysFreshUnlessTheClientAsksForMore) {
  Scene twin({"no_vault"}, Plain());
  Scene run({}, Plain());
  run.engine.Load("vault", {{"pull.talk", 1}, {"move.talk", 1}});
  for (int frame = 0; frame < 2; ++frame) {
    for (Scene* each : {&twin, &run}) {
      each->bodies.position[3] += 5;  // without touch
      EXPECT_OK(each->engine.Advance(kDt, 3));
    }
    run.ExpectSameAs(twin);
  }
  // Any number of steps needs one copy to the device and one copy back.
  const auto& log = run.engine.log();
  EXPECT_EQ(std::count(log.begin(), log.end(), "vault: take position"), 2);
  EXPECT_EQ(std::count(log.begin(), log.end(), "vault: write position"), 2);
}

TEST_P(DeferredTest, PotentialEnergyIsThatOfTheArraysWhoeverWroteThem) {
  Scene run({"vault_pull", "no_vault_move"}, Plain());
  const auto expect_present = [&run] {
    double energy = 0, expected = 0;
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_engine_potential_energy(run.engine.get(), run.ids[0], 0, &energy, error);
    }));
    for (const double x : run.bodies.position) expected += x * x;  // stiffness 2
    EXPECT_DOUBLE_EQ(energy, expected);
  };
  expect_present();
  EXPECT_OK(run.engine.Advance(kDt, 2));  // moved by a law that does not defer
  expect_present();
  run.bodies.position[3] += 5;  // by the client, without touch
  expect_present();
}

TEST_P(DeferredTest, ArraysStayStaleUntilTheClientAsksForThem) {
  Scene twin({"no_vault"}, Plain());
  EXPECT_OK(twin.engine.Advance(kDt, 4));
  Scene run({}, Deferred());
  run.engine.Load("vault", {{"pull.talk", 1}, {"move.talk", 1}});
  const Bodies before = run.bodies;
  EXPECT_OK(run.engine.Advance(kDt, 1));
  EXPECT_OK(run.engine.Advance(kDt, 3));
  EXPECT_EQ(run.bodies.position, before.position);
  EXPECT_EQ(run.bodies.velocity, before.velocity);
  EXPECT_OK(run.engine.Synchronize({"position"}));
  EXPECT_EQ(run.bodies.position, twin.bodies.position);
  EXPECT_EQ(run.bodies.velocity, before.velocity);
  EXPECT_OK(run.engine.SynchronizeAll());
  EXPECT_OK(run.engine.SynchronizeAll());
  run.ExpectSameAs(twin);
  EXPECT_EQ(run.engine.log(),
            (Lines{"vault: take position", "vault: take velocity", "vault: write position",
                   "vault: write velocity", "vault: write externalForce"}));
}

TEST_P(DeferredTest, LawThatDoesNotDeferSeesFreshArrays) {
  Scene twin({"no_vault", "relay_velocity"}, Plain());
  Scene run({"vault", "relay_velocity"}, Deferred());
  for (Scene* each : {&twin, &run}) EXPECT_OK(each->engine.Advance(kDt, 3));
  EXPECT_OK(run.engine.SynchronizeAll());
  run.ExpectSameAs(twin);
}

TEST_P(DeferredTest, HashFindSaveAndUnloadMakeArraysFresh) {
  Scene twin({"no_vault"}, Plain());
  EXPECT_OK(twin.engine.Advance(kDt, 2));
  {
    Scene run({"vault"}, Deferred());
    EXPECT_OK(run.engine.Advance(kDt, 2));
    EXPECT_EQ(run.engine.StateHash(), twin.engine.StateHash());
    run.ExpectSameAs(twin);
  }
  {
    Scene run({"vault"}, Deferred());
    EXPECT_OK(run.engine.Advance(kDt, 2));
    vesper_property property{};
    property.struct_size = sizeof property;
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_provider_find_physical_property(run.engine.provider(), "position", &property,
                                                    error);
    }));
    EXPECT_EQ(run.bodies.position, twin.bodies.position);
    EXPECT_NE(run.bodies.velocity, twin.bodies.velocity);
  }
  {
    Scene run({"vault"}, Deferred());
    EXPECT_OK(run.engine.Advance(kDt, 2));
    uint64_t size = 0;
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_engine_state_size(run.engine.get(), &size, error);
    }));
    run.ExpectSameAs(twin);
  }
  {
    Scene run({"vault"}, Deferred());
    EXPECT_OK(run.engine.Advance(kDt, 2));
    EXPECT_OK(run.engine.Unload(run.ids[0]));
    run.ExpectSameAs(twin);
  }
}

TEST_P(DeferredTest, ArraysThatTheClientTouchesCount) {
  Scene twin({"no_vault"}, Plain());
  Scene run({"vault"}, Deferred());
  for (Scene* each : {&twin, &run}) {
    EXPECT_OK(each->engine.Advance(kDt, 2));
    EXPECT_OK(each->engine.SynchronizeAll());
    each->bodies.position[3] = 7;
    const char* edited = "position";
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_provider_touch(each->engine.provider(), &edited, 1, error);
    }));
    EXPECT_OK(each->engine.Advance(kDt, 2));
    // Values that the client writes are valid even if the array is stale; the law is not notified.
    each->bodies.velocity.assign(120, 0.5);
    EXPECT_OK(each->engine.Rebind("velocity", each->bodies.velocity, 3));
    EXPECT_OK(each->engine.Advance(kDt, 1));
    EXPECT_OK(each->engine.SynchronizeAll());
  }
  run.ExpectSameAs(twin);
}

TEST_P(DeferredTest, ArraysMayGrow) {
  Scene twin({"no_vault"}, Plain());
  Scene run({"vault"}, Deferred());
  for (Scene* each : {&twin, &run}) {
    EXPECT_OK(each->engine.Advance(kDt, 2));
    EXPECT_OK(each->engine.SynchronizeAll());
    Bodies& bodies = each->bodies;
    bodies.mass.resize(50, 1);
    bodies.orientation.resize(200);
    EXPECT_OK(each->engine.Rebind("mass", bodies.mass, 1));
    EXPECT_OK(each->engine.Rebind("orientation", bodies.orientation, 4));
    for (auto& [name, values] : std::initializer_list<std::pair<const char*, std::vector<double>&>>{
             {"position", bodies.position},
             {"velocity", bodies.velocity},
             {"acceleration", bodies.acceleration},
             {"externalForce", bodies.force},
             {"angularVelocity", each->spin}}) {
      values.resize(150, 2);
      EXPECT_OK(each->engine.Rebind(name, values, 3));
    }
    EXPECT_OK(each->engine.Advance(kDt, 2));
    EXPECT_OK(each->engine.SynchronizeAll());
  }
  run.ExpectSameAs(twin);
}

TEST_P(DeferredTest, SavedStateComesBackInTheCopiesToo) {
  Scene twin({"no_vault"}, Plain());
  EXPECT_OK(twin.engine.Advance(kDt, 5));
  Scene scene({"vault"}, Deferred());
  EXPECT_OK(scene.engine.Advance(kDt, 2));
  uint64_t size = 0;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_state_size(scene.engine.get(), &size, error);
  }));
  std::vector<std::byte> state(size);
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_save_state(scene.engine.get(), state.data(), size, error);
  }));
  const Bodies kept = scene.bodies;
  EXPECT_OK(scene.engine.Advance(kDt, 7));
  scene.bodies = kept;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_load_state(scene.engine.get(), state.data(), size, error);
  }));
  EXPECT_OK(scene.engine.Advance(kDt, 3));
  EXPECT_EQ(scene.engine.StateHash(), twin.engine.StateHash());
  scene.ExpectSameAs(twin);
}

TEST_P(DeferredTest, FailedStepIsUndoneInTheCopiesToo) {
  for (const EngineOptions& options : {Plain(), Deferred()}) {
    Scene twin({"no_vault"}, Plain());
    Scene run({"vault"}, options);
    for (Scene* each : {&twin, &run}) {
      EXPECT_OK(each->engine.Advance(kDt, 2));
      EXPECT_OK(each->engine.SynchronizeAll());
    }
    const Bodies kept = run.bodies;
    const vesper_library_id failing = run.engine.Load("relay_acceleration", {{"fail", 1}});
    EXPECT_REFUSED(LAW_FAILED, "asked to fail", run.engine.Advance(kDt, 3));
    run.bodies = kept;
    EXPECT_OK(run.engine.Unload(failing));
    for (Scene* each : {&twin, &run}) {
      EXPECT_OK(each->engine.Advance(kDt, 2));
      EXPECT_OK(each->engine.SynchronizeAll());
    }
    run.bodies.acceleration = twin.bodies.acceleration;
    run.ExpectSameAs(twin);
    EXPECT_EQ(run.engine.StateHash(), twin.engine.StateHash());
  }
}

TEST_P(DeferredTest, WhatIsNotFiniteIsFoundWhenItIsWritten) {
  Scene twin({"no_vault"}, Plain());
  EXPECT_OK(twin.engine.Advance(kDt, 2));
  for (const EngineOptions& options : {Plain(), Deferred()}) {
    Scene run({}, options);
    const vesper_library_id vault = run.engine.Load("vault", {{"move.spoil", 1}});
    EXPECT_OK(run.engine.Advance(kDt, 2));
    EXPECT_OK(run.engine.SynchronizeAll());
    const Bodies kept = run.bodies;
    vesper_error error = run.engine.Advance(kDt, 1);
    if (options.deferred) {
      EXPECT_OK(error);
      error = run.engine.Synchronize({"position"});
    }
    EXPECT_REFUSED(LAW_MISBEHAVED, "law move: property position, row 1", error);
    EXPECT_EQ(error.library_id, vault);
    EXPECT_EQ(error.law_index, 1u);
    EXPECT_EQ(vesper_engine_step_count(run.engine.get()), options.deferred ? 3u : 2u);
    EXPECT_REFUSED(FAULTED, "", run.engine.SynchronizeAll());
    EXPECT_REFUSED(FAULTED, "", run.engine.Advance(kDt, 1));
    run.bodies = kept;
    EXPECT_OK(run.engine.Unload(vault));
    EXPECT_OK(run.engine.SynchronizeAll());
    run.bodies.force = twin.bodies.force;
    run.ExpectSameAs(twin);
  }
}

TEST_P(DeferredTest, WhatIsNotFiniteIsLaidAtTheDoorOfTheLawThatItCameFrom) {
  for (const EngineOptions& options : {Plain(), Deferred()}) {
    Scene run({}, options);
    const vesper_library_id vault = run.engine.Load("vault", {{"pull.spoil", 1}});
    EXPECT_OK(run.engine.Advance(kDt, 2));
    vesper_error error = run.engine.Advance(kDt, 1);
    if (options.deferred) {
      EXPECT_OK(error);
      error = run.engine.Synchronize({"position"});
    }
    EXPECT_REFUSED(LAW_MISBEHAVED, "law pull: property externalForce, row 2", error);
    EXPECT_EQ(error.library_id, vault);
    EXPECT_EQ(error.law_index, 0u);
  }
}

TEST_P(DeferredTest, ClientThatTouchesWhatItEditsIsNotAskedForTheRest) {
  Scene twin({"no_vault"}, Plain());
  Scene run({}, {.validate = GetParam(), .touches = true});
  run.engine.Load("vault", {{"pull.talk", 1}, {"move.talk", 1}});
  const char* edited = "position";
  for (int frame = 0; frame < 3; ++frame) {
    for (Scene* each : {&twin, &run}) {
      each->bodies.position[3] += 5;
      EXPECT_OK(Try([&](vesper_error* error) {
        return vesper_provider_touch(each->engine.provider(), &edited, 1, error);
      }));
      EXPECT_OK(each->engine.Advance(kDt, 3));
    }
    run.ExpectSameAs(twin);  // current after each advance
  }
  const Lines& log = run.engine.log();
  EXPECT_EQ(std::count(log.begin(), log.end(), "vault: take position"), 3);
  EXPECT_EQ(std::count(log.begin(), log.end(), "vault: take velocity"), 1);
  EXPECT_EQ(std::count(log.begin(), log.end(), "vault: write velocity"), 3);
}

TEST_P(DeferredTest, UnloadThatFindsWhatIsNotFiniteMayBeRepeated) {
  Scene run({}, Deferred());
  const vesper_library_id vault = run.engine.Load("vault", {{"move.spoil", 1}});
  EXPECT_OK(run.engine.Advance(kDt, 3));
  EXPECT_REFUSED(LAW_MISBEHAVED, "position, row 1", run.engine.Unload(vault));
  EXPECT_OK(run.engine.Unload(vault));
  EXPECT_OK(run.engine.Advance(kDt, 1));
}

TEST_P(DeferredTest, NamesToSynchronizeAreChecked) {
  Scene run({"vault"}, Deferred());
  EXPECT_REFUSED(NOT_FOUND, "positon", run.engine.Synchronize({"positon"}));
  EXPECT_REFUSED(NOT_FOUND, "charge is not bound", run.engine.Synchronize({"charge"}));
}

TEST(DeferredValidateTest, LawMustNotWriteTheArrayBeforeItIsAsked) {
  Scene run({}, {.validate = true});
  run.engine.Load("vault", {{"pull.cheat", 1}});
  EXPECT_REFUSED(LAW_MISBEHAVED, "externalForce, row 1: declared DEFERRED, but the row was changed",
                 run.engine.Advance(kDt, 1));
}

TEST(DeferredValidateTest, LawMustWriteEveryRowWhenItIsAsked) {
  Scene run({}, {.validate = true});
  run.engine.Load("vault", {{"move.skip", 1}});
  EXPECT_REFUSED(LAW_MISBEHAVED, "position, row 39: the row was not written",
                 run.engine.Advance(kDt, 1));
}

}  // namespace
}  // namespace vesper::test
