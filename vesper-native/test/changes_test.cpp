// SPDX-License-Identifier: Apache-2.0
// Tests series of changes that are kept or undone as a whole.
#include "test_kit.hpp"

namespace vesper::test {
namespace {

class ChangesTest : public BothModes {};
IN_BOTH_MODES(ChangesTest);

vesper_error Begin(const TestEngine& engine) {
  return Try([&](vesper_error* error) { return vesper_engine_begin_changes(engine.get(), error); });
}

vesper_error End(const TestEngine& engine, bool keep) {
  return Try([&](vesper_error* error) {
    return vesper_engine_end_changes(engine.get(), keep ? 1 : 0, error);
  });
}

/// Two bodies with two laws. One law writes their forces, and the other counts its steps in
/// SCRATCH.
struct ChangedWorld {
  explicit ChangedWorld(const EngineOptions& options) : engine(options) {
    engine.AddBodies(bodies);
    push = engine.Load("push", {{"force", 2}});
    remembering = engine.Load("remembering");
  }

  Bodies bodies{2};
  TestEngine engine;
  vesper_library_id push = 0;
  vesper_library_id remembering = 0;
};

TEST_P(ChangesTest, UndoneTheyLeaveNoTrace) {
  ChangedWorld world(Options()), expected(Options());
  EXPECT_OK(world.engine.Advance(1, 3));
  EXPECT_OK(expected.engine.Advance(1, 3));
  EXPECT_OK(Begin(world.engine));
  EXPECT_OK(world.engine.Unload(world.push));
  EXPECT_OK(world.engine.Unload(world.remembering));
  world.engine.Load("push_changed", {{"force", 5}});  // declares the name of push
  world.engine.Load("remembering");
  world.engine.Load("euler");
  EXPECT_OK(End(world.engine, false));
  for (ChangedWorld* each : {&world, &expected}) EXPECT_OK(each->engine.Advance(1, 2));
  EXPECT_EQ(world.bodies.force, expected.bodies.force);
  EXPECT_EQ(world.bodies.acceleration, expected.bodies.acceleration);
  EXPECT_EQ(world.bodies.acceleration[2], 5);
  EXPECT_EQ(world.engine.StateHash(), expected.engine.StateHash());
  EXPECT_EQ(world.engine.LawInfo(world.push).calls, 5u);
  EXPECT_EQ(world.engine.LawInfo(world.remembering).calls, 5u);
}

TEST_P(ChangesTest, UndoneTheyRestoreTheStepCountAndIntervals) {
  ChangedWorld world(Options());
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_set_interval(world.engine.get(), world.push, 2, error);
  }));
  EXPECT_OK(world.engine.Advance(1, 4));
  EXPECT_OK(Begin(world.engine));
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_set_interval(world.engine.get(), world.push, 1, error);
  }));
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_set_step_count(world.engine.get(), 77, 0.5, error);
  }));
  EXPECT_OK(End(world.engine, false));
  EXPECT_EQ(vesper_engine_step_count(world.engine.get()), 4u);
  EXPECT_OK(world.engine.Advance(1, 2));
  EXPECT_EQ(world.engine.LawInfo(world.push).calls, 3u);  // in steps 0, 2 and 4
}

TEST_P(ChangesTest, KeptTheyStay) {
  ChangedWorld world(Options());
  EXPECT_OK(Begin(world.engine));
  EXPECT_OK(world.engine.Unload(world.push));
  const vesper_library_id changed = world.engine.Load("push_changed", {{"force", 5}});
  EXPECT_OK(End(world.engine, true));
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.engine.LawInfo(changed).calls, 1u);
  EXPECT_EQ(world.bodies.force[0], 5);
  EXPECT_REFUSED(NOT_FOUND, "no library with id", world.engine.Unload(world.push));
}

TEST_P(ChangesTest, AreRefusedOutOfTurn) {
  ChangedWorld world(Options());
  EXPECT_REFUSED(NOT_FOUND, "no changes are in progress", End(world.engine, true));
  EXPECT_OK(Begin(world.engine));
  EXPECT_REFUSED(ALREADY_EXISTS, "changes are in progress", Begin(world.engine));
  EXPECT_OK(End(world.engine, false));
  EXPECT_REFUSED(NOT_FOUND, "no changes are in progress", End(world.engine, false));
}

TEST_P(ChangesTest, InProgressTheyEndWithTheEngine) {
  ChangedWorld world(Options());
  EXPECT_OK(Begin(world.engine));
  EXPECT_OK(world.engine.Unload(world.push));
}

}  // namespace
}  // namespace vesper::test
