// SPDX-License-Identifier: Apache-2.0
// Tests a step: order of laws, stages, accumulators, time.
#include <algorithm>
#include <cmath>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

class AdvanceTest : public BothModes {};
IN_BOTH_MODES(AdvanceTest);

// The step is a power of two, so that the closed forms below are exact.
constexpr double kExactDt = 1.0 / 64;

TEST_P(AdvanceTest, ConstantForceMatchesDiscreteClosedForm) {
  Bodies bodies(4);
  bodies.mass = {1, 2, 4, 8};
  const Bodies start = bodies;
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("euler");
  engine.Load("push", {{"force", 16}});
  constexpr uint32_t kSteps = 32;
  EXPECT_OK(engine.Advance(kExactDt, kSteps));
  for (size_t i = 0; i < 4; ++i) {
    const double a = 16 / bodies.mass[i];
    const double x = start.position[3 * i] + start.velocity[3 * i] * kSteps * kExactDt +
                     a * kExactDt * kExactDt * kSteps * (kSteps + 1) / 2;
    EXPECT_EQ(bodies.velocity[3 * i], start.velocity[3 * i] + a * kSteps * kExactDt) << "row " << i;
    EXPECT_EQ(bodies.position[3 * i], x) << "row " << i;
    EXPECT_EQ(bodies.position[3 * i + 1], start.position[3 * i + 1]) << "row " << i;
  }
  EXPECT_EQ(vesper_engine_step_count(engine.get()), kSteps);
}

TEST_P(AdvanceTest, BodyWithoutMassDoesNotMove) {
  Bodies bodies(2);
  bodies.mass[0] = 0;
  const Bodies start = bodies;
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("euler");
  engine.Load("push");
  EXPECT_OK(engine.Advance(kExactDt, 10));
  EXPECT_EQ(bodies.position[0], start.position[0]);
  EXPECT_NE(bodies.position[3], start.position[3]);
}

TEST_P(AdvanceTest, SplittingACallChangesNoBit) {
  Bodies at_once(5), split(5);
  TestEngine first(Options()), second(Options());
  for (auto [engine, bodies] : {std::pair(&first, &at_once), std::pair(&second, &split)}) {
    engine->AddBodies(*bodies);
    engine->Load("field");
    engine->Load("euler");
  }
  EXPECT_OK(first.Advance(0.01, 30));
  for (int i = 0; i < 30; ++i) EXPECT_OK(second.Advance(0.01, 1));
  EXPECT_EQ(at_once.position, split.position);
  EXPECT_EQ(first.StateHash(), second.StateHash());
}

TEST_P(AdvanceTest, LawsRunByPhaseThenByOrderOfLoading) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("trace_observe");
  engine.Load("trace_constrain");
  engine.Load("trace_integrate");
  engine.Load("trace_force");
  EXPECT_OK(engine.Advance(kExactDt, 1));
  // The order is: the integrator before the first stage (5), the force (1) and the integrator (6,
  // 7) in each of two stages, the constraint (2), and the observer (3).
  EXPECT_EQ(bodies.orientation[0], 5161723);
}

TEST_P(AdvanceTest, IntegratorIsCalledFromItsFirstStageOn) {
  for (const uint32_t threads : {1u, 2u}) {
    Bodies bodies(1);
    EngineOptions options = Options();
    options.threads = threads;
    TestEngine engine(options);
    engine.AddBodies(bodies);
    const vesper_library_id integrator = engine.Load("trace_from_stage_1");
    engine.Load("trace_force");
    EXPECT_OK(engine.Advance(kExactDt, 1));
    EXPECT_EQ(bodies.orientation[0], 1617) << threads << " threads";
    EXPECT_EQ(engine.LawInfo(integrator).calls, 2u);
  }
}

TEST_P(AdvanceTest, LawsOfOnePhaseRunInOrderOfLoading) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("misbehaving");
  engine.Load("trace_constrain");
  EXPECT_OK(engine.Advance(kExactDt, 2));
  EXPECT_EQ(bodies.orientation[0], 22);
}

TEST_P(AdvanceTest, ForcesAreEvaluatedOnceWithoutAnIntegrator) {
  Bodies bodies(3);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id push = engine.Load("push", {{"force", 3}});
  EXPECT_OK(engine.Advance(kExactDt, 5));
  EXPECT_EQ(bodies.force[6], 3);
  EXPECT_EQ(engine.LawInfo(push).calls, 5u);
}

TEST_P(AdvanceTest, ForcesAreEvaluatedOncePerStage) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("euler_four_stages");
  const vesper_library_id push = engine.Load("push");
  EXPECT_OK(engine.Advance(kExactDt, 3));
  EXPECT_EQ(engine.LawInfo(push).calls, 12u);
  EXPECT_EQ(bodies.force[0], 1);
}

TEST_P(AdvanceTest, LawLoadedLaterActsFromTheNextStepOn) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("euler");
  EXPECT_OK(engine.Advance(kExactDt, 4));
  EXPECT_EQ(bodies.velocity[0], 1);
  const vesper_library_id push = engine.Load("push", {{"force", 64}});
  EXPECT_OK(engine.Advance(kExactDt, 1));
  EXPECT_EQ(bodies.velocity[0], 2);
  EXPECT_OK(engine.Unload(push));
  EXPECT_OK(engine.Advance(kExactDt, 4));
  EXPECT_EQ(bodies.velocity[0], 2);
  EXPECT_EQ(bodies.force[0], 0);
}

TEST_P(AdvanceTest, EmptyKindsAreStepped) {
  Bodies none(0);
  TestEngine engine(Options());
  engine.AddBodies(none);
  engine.Load("euler");
  engine.Load("push");
  engine.Load("push_again");
  EXPECT_OK(engine.Advance(kExactDt, 2));
  EXPECT_EQ(vesper_engine_step_count(engine.get()), 2u);
}

TEST_P(AdvanceTest, ZeroStepsOnlyBind) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.Load("euler");
  EXPECT_REFUSED(NOT_FOUND, "law euler: needs property mass", engine.Advance(kExactDt, 0));
  engine.AddBodies(bodies);
  EXPECT_OK(engine.Advance(kExactDt, 0));
  EXPECT_EQ(vesper_engine_step_count(engine.get()), 0u);
}

TEST_P(AdvanceTest, TimeStepMustBeFiniteAndPositive) {
  TestEngine engine(Options());
  for (const double dt : {0.0, -1.0, double{INFINITY}, double{NAN}}) {
    EXPECT_REFUSED(INVALID_ARGUMENT, "dt is", engine.Advance(dt, 1));
  }
  EXPECT_OK(engine.Advance(kExactDt, 1));
}

TEST_P(AdvanceTest, TimeIsMultipliedAndGoesOnWhenTheStepChanges) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("clock");
  const auto time = [&] { return bodies.acceleration[0]; };
  EXPECT_OK(engine.Advance(0.1, 1000));
  EXPECT_EQ(time(), 999 * 0.1) << "not the sum of 999 roundings";
  EXPECT_OK(engine.Advance(0.5, 1));
  EXPECT_EQ(time(), 1000 * 0.1);
  EXPECT_OK(engine.Advance(0.5, 4));
  EXPECT_EQ(time(), 1000 * 0.1 + 4 * 0.5);
  EXPECT_EQ(bodies.acceleration[2], 1004) << "steps before the last one";
}

TEST_P(AdvanceTest, FailedStepsTakeNoTime) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("clock");
  EXPECT_OK(engine.Advance(0.25, 2));
  const vesper_library_id throwing = engine.Load("throwing");
  EXPECT_REFUSED(LAW_FAILED, "law throwing", engine.Advance(7, 1));
  EXPECT_OK(engine.Unload(throwing));
  EXPECT_OK(engine.Advance(0.25, 1));
  EXPECT_EQ(bodies.acceleration[0], 0.5);
}

TEST_P(AdvanceTest, AnObserverSeesWhichLawIsCalled) {
  struct Observer {
    uint64_t running[2] = {};
    std::vector<uint64_t> seen;
  } observer;
  vesper_engine_config config = TestConfig(Options());
  config.threads = 2;
  config.running = observer.running;
  config.log_user = &observer;
  config.log = [](void* user, uint32_t, const char*) {
    auto& o = *static_cast<Observer*>(user);
    o.seen.push_back(o.running[0] != 0 ? o.running[0] : o.running[1]);
  };
  vesper_engine* engine = nullptr;
  ASSERT_EQ(vesper_engine_create(&config, vesper_prototype_standard("si-f64"), &engine, nullptr),
            VESPER_OK);
  vesper_library_id id = 0;
  ASSERT_EQ(vesper_engine_load_physics_law(engine, "suite", nullptr, 0, &id, nullptr), VESPER_OK);
  const uint64_t first_law = (uint64_t{id} << 32) | 1;
  EXPECT_NE(std::find(observer.seen.begin(), observer.seen.end(), first_law), observer.seen.end());
  EXPECT_EQ(observer.running[0], 0u);
  EXPECT_EQ(observer.running[1], 0u);
  vesper_engine_destroy(engine);
}

TEST_P(AdvanceTest, CallsFromInsideAStepAreRefused) {
  // The log callback is the only place from which a client could call its engine recursively.
  struct Probe {
    vesper_engine* engine = nullptr;
    std::vector<vesper_status> seen;
    std::string last_line;
  } probe;
  vesper_engine_config config = TestConfig(Options());
  config.log_user = &probe;
  config.log = [](void* user, uint32_t, const char* line) {
    auto& p = *static_cast<Probe*>(user);
    p.last_line = line;
    if (p.last_line.find("not destroyed") != std::string::npos) return;
    uint64_t hash = 0;
    p.seen.push_back(vesper_engine_advance(p.engine, 1, 1, nullptr));
    p.seen.push_back(vesper_engine_unload_physics_law(p.engine, 1, nullptr));
    p.seen.push_back(vesper_engine_state_hash(p.engine, &hash, nullptr));
    p.seen.push_back(
        vesper_provider_touch(vesper_engine_property_provider(p.engine), nullptr, 0, nullptr));
    vesper_engine_destroy(p.engine);
  };
  ASSERT_EQ(
      vesper_engine_create(&config, vesper_prototype_standard("si-f64"), &probe.engine, nullptr),
      VESPER_OK);
  vesper_library_id id = 0;
  ASSERT_EQ(vesper_engine_load_physics_law(probe.engine, "suite", nullptr, 0, &id, nullptr),
            VESPER_OK);
  ASSERT_FALSE(probe.seen.empty());
  EXPECT_EQ(probe.last_line.find("vesper_engine_destroy: the engine is inside"), 0u);
  for (const vesper_status status : probe.seen) EXPECT_EQ(status, VESPER_BUSY);
  EXPECT_EQ(vesper_engine_unload_physics_law(probe.engine, id, nullptr), VESPER_OK);
  vesper_engine_destroy(probe.engine);
}

}  // namespace
}  // namespace vesper::test
