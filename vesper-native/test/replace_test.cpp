// SPDX-License-Identifier: Apache-2.0
// Tests the replacement of a loaded library between two frames.
#include "misbehaving.h"
#include "test_kit.hpp"

namespace vesper::test {
namespace {

class ReplaceTest : public BothModes {};
IN_BOTH_MODES(ReplaceTest);

/// Replaces a library by one from the test laws.
vesper_error Replace(const TestEngine& engine, vesper_library_id library, const std::string& by,
                     Parameters parameters = {}) {
  const vesper_engine_config config = TestConfig();
  vesper_prepared_library* prepared = nullptr;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_library_prepare(&config, by.c_str(), &prepared, error);
  }));
  std::vector<vesper_parameter> values;
  for (const auto& [name, value] : parameters) {
    values.push_back({sizeof(vesper_parameter), 0, name, value});
  }
  const vesper_error result = Try([&](vesper_error* error) {
    return vesper_engine_replace_library(engine.get(), library, prepared, values.data(),
                                         static_cast<uint32_t>(values.size()), error);
  });
  if (result.status != VESPER_OK) vesper_library_discard(prepared);
  return result;
}

std::vector<char> Saved(const TestEngine& engine) {
  uint64_t size = 0;
  EXPECT_OK(Try(
      [&](vesper_error* error) { return vesper_engine_state_size(engine.get(), &size, error); }));
  std::vector<char> state(size);
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_save_state(engine.get(), state.data(), size, error);
  }));
  return state;
}

/// A law that pushes, and one that counts its steps in SCRATCH.
struct CountingWorld {
  explicit CountingWorld(const EngineOptions& options) : engine(options) {
    engine.AddBodies(bodies);
    push = engine.Load("push", {{"force", 2}});
    remembering = engine.Load("remembering");
    EXPECT_OK(engine.Advance(1, 3));
  }

  void ExpectSame(CountingWorld& other) {
    EXPECT_OK(engine.Advance(1, 2));
    EXPECT_OK(other.engine.Advance(1, 2));
    EXPECT_EQ(bodies.force, other.bodies.force);
    EXPECT_EQ(bodies.acceleration, other.bodies.acceleration);
    EXPECT_EQ(Saved(engine), Saved(other.engine));
  }

  Bodies bodies{2};
  TestEngine engine;
  vesper_library_id push = 0;
  vesper_library_id remembering = 0;
};

TEST_P(ReplaceTest, TheNewVersionTakesIdAndState) {
  CountingWorld world(Options()), expected(Options());
  EXPECT_OK(Replace(world.engine, world.remembering, "remembering"));
  EXPECT_EQ(world.engine.LawInfo(world.remembering).calls, 0u);
  world.ExpectSame(expected);
  EXPECT_EQ(world.bodies.acceleration[2], 5);
}

TEST_P(ReplaceTest, TheNewVersionTakesThePlaceInTheOrder) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id first = engine.Load("push", {{"force", 1}});
  engine.Load("push_again", {{"force", 1e16}});
  engine.Load("push_third", {{"force", -1e16}});
  EXPECT_OK(Replace(engine, first, "push_changed", {{"force", 1}}));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force[0], 0);  // 1 + 1e16 is 1e16; as the last one it would add 1
}

TEST_P(ReplaceTest, TheNewVersionActsFromTheNextStepOn) {
  CountingWorld world(Options());
  EXPECT_EQ(world.bodies.force[0], 2);
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_set_interval(world.engine.get(), world.push, 0, error);
  }));
  EXPECT_OK(Replace(world.engine, world.push, "push_changed", {{"force", 7}}));
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.force[0], 7);
  EXPECT_EQ(world.engine.LawInfo(world.push).calls, 1u);
  EXPECT_OK(Replace(world.engine, world.push, "push_again", {{"force", 3}}));  // another name
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.force[0], 3);
  EXPECT_STREQ(world.engine.LawInfo(world.push).library, "push_again");
}

TEST_P(ReplaceTest, ARefusedVersionChangesNothing) {
  CountingWorld world(Options()), expected(Options());
  const vesper_library_id euler = world.engine.Load("euler");
  EXPECT_REFUSED(ALREADY_EXISTS, "library euler is loaded already",
                 Replace(world.engine, world.push, "euler"));
  EXPECT_REFUSED(ACCESS_CONFLICT, "euler", Replace(world.engine, world.push, "euler_four_stages"));
  EXPECT_REFUSED(NOT_FOUND, "nothing", Replace(world.engine, world.push, "push", {{"nothing", 1}}));
  EXPECT_REFUSED(NOT_FOUND, "no library with id 99", Replace(world.engine, 99, "push"));
  EXPECT_OK(world.engine.Unload(euler));
  world.ExpectSame(expected);
  EXPECT_EQ(world.engine.LawInfo(world.push).calls, 5u);
}

TEST_P(ReplaceTest, ANewVersionThatFailsInCreateLeavesTheOldOne) {
  CountingWorld world(Options()), expected(Options());
  EXPECT_REFUSED(LAW_FAILED, "no device",
                 Replace(world.engine, world.push, "misbehaving", {{"mode", FAIL_IN_CREATE}}));
  world.ExpectSame(expected);
}

TEST_P(ReplaceTest, AnotherLayoutBeginsWithZeros) {
  CountingWorld world(Options());
  EXPECT_OK(Replace(world.engine, world.remembering, "remembering_of_world"));
  EXPECT_OK(Replace(world.engine, world.remembering, "remembering"));
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration[2], 1);
  EXPECT_OK(Replace(world.engine, world.remembering, "remembering"));
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration[2], 2);
}

TEST_P(ReplaceTest, UndoneChangesBringTheOldVersionBack) {
  CountingWorld world(Options()), expected(Options());
  EXPECT_OK(Try(
      [&](vesper_error* error) { return vesper_engine_begin_changes(world.engine.get(), error); }));
  for (const char* next : {"remembering", "push_again", "remembering"}) {
    EXPECT_OK(Replace(world.engine, world.remembering, next));
  }
  EXPECT_OK(world.engine.Unload(world.remembering));
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_end_changes(world.engine.get(), 0, error);
  }));
  world.ExpectSame(expected);
  EXPECT_EQ(world.engine.LawInfo(world.remembering).calls, 5u);
}

TEST_P(ReplaceTest, TheLedgerBooksWhatTheOldVersionGaveAsUnloaded) {
  Bodies bodies(2);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id push = engine.Load("push", {{"force", 2}});
  engine.Load("euler");
  EXPECT_OK(
      Try([&](vesper_error* error) { return vesper_engine_set_ledger(engine.get(), 1, error); }));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_OK(Replace(engine, push, "push_changed", {{"force", 5}}));
  EXPECT_OK(engine.Advance(1, 1));
  const auto momentum = [&](vesper_library_id library, uint32_t line) {
    vesper_ledger_entry entry{};
    entry.struct_size = sizeof entry;
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_engine_ledger(engine.get(), library, line, &entry, error);
    }));
    return entry.momentum[0];
  };
  EXPECT_EQ(momentum(VESPER_NO_LIBRARY, VESPER_LEDGER_UNLOADED), 4);  // 2 bodies x 2 N x 1 s
  EXPECT_EQ(momentum(push, 0), 10);
}

}  // namespace
}  // namespace vesper::test
