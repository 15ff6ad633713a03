// SPDX-License-Identifier: Apache-2.0
// Tests saving the state of an engine and continuing from it.
#include <algorithm>
#include <cmath>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

using Bytes = std::vector<char>;

Bytes Save(const TestEngine& engine) {
  uint64_t size = 0;
  EXPECT_OK(Try(
      [&](vesper_error* error) { return vesper_engine_state_size(engine.get(), &size, error); }));
  Bytes state(size);
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_save_state(engine.get(), state.data(), size, error);
  }));
  return state;
}

vesper_error Load(const TestEngine& engine, const Bytes& state) {
  return Try([&](vesper_error* error) {
    return vesper_engine_load_state(engine.get(), state.data(), state.size(), error);
  });
}

/// A world after `steps` steps whose law uses SCRATCH.
struct RememberingWorld {
  RememberingWorld(const EngineOptions& options, uint32_t steps, size_t count = 3)
      : bodies(count), engine(options) {
    engine.AddBodies(bodies);
    engine.Load("remembering");
    if (steps > 0) EXPECT_OK(engine.Advance(1, steps));
  }

  Bodies bodies;
  TestEngine engine;
};

class SavedStateTest : public BothModes {};
IN_BOTH_MODES(SavedStateTest);

TEST_P(SavedStateTest, AnotherEngineGoesOnFromIt) {
  RememberingWorld first(Options(), 5), second(Options(), 0);
  EXPECT_OK(Load(second.engine, Save(first.engine)));
  EXPECT_EQ(vesper_engine_step_count(second.engine.get()), 5u);
  EXPECT_OK(first.engine.Advance(1, 2));
  EXPECT_OK(second.engine.Advance(1, 2));
  EXPECT_EQ(second.bodies.acceleration, first.bodies.acceleration);
  EXPECT_EQ(second.bodies.acceleration[2], 7);
  EXPECT_EQ(Save(second.engine), Save(first.engine));
}

TEST_P(SavedStateTest, TimeGoesOnThoughTheStepHadChanged) {
  Bodies bodies(1);
  TestEngine first(Options()), second(Options());
  EXPECT_OK(first.Advance(0.5, 3));
  EXPECT_OK(first.Advance(0.25, 2));
  EXPECT_OK(Load(second, Save(first)));
  second.AddBodies(bodies);
  second.Load("clock");
  EXPECT_OK(second.Advance(0.25, 2));
  EXPECT_EQ(bodies.acceleration[0], 2.25);
  EXPECT_EQ(bodies.acceleration[2], 6);
}

TEST_P(SavedStateTest, StepsThatAreSetAreAsIfTheyHadBeenDone) {
  Bodies done_bodies(1), set_bodies(1);
  TestEngine done(Options()), set(Options());
  EXPECT_OK(done.Advance(0.1, 7));
  EXPECT_OK(Try(
      [&](vesper_error* error) { return vesper_engine_set_step_count(set.get(), 7, 0.1, error); }));
  EXPECT_EQ(vesper_engine_step_count(set.get()), 7u);
  EXPECT_EQ(Save(set), Save(done));
  done.AddBodies(done_bodies);
  set.AddBodies(set_bodies);
  done.Load("clock");
  set.Load("clock");
  EXPECT_OK(done.Advance(0.1, 2));
  EXPECT_OK(set.Advance(0.1, 2));
  EXPECT_EQ(set_bodies.acceleration, done_bodies.acceleration);
  EXPECT_EQ(set_bodies.acceleration[2], 8);
}

TEST_P(SavedStateTest, StepsOfNoLengthAreRefused) {
  TestEngine engine(Options());
  for (double dt : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    const vesper_error error = Try(
        [&](vesper_error* out) { return vesper_engine_set_step_count(engine.get(), 3, dt, out); });
    EXPECT_EQ(error.status, VESPER_INVALID_ARGUMENT);
    EXPECT_EQ(vesper_engine_step_count(engine.get()), 0u);
  }
}

TEST_P(SavedStateTest, TurnsAnEngineBack) {
  RememberingWorld world(Options(), 2);
  const Bytes state = Save(world.engine);
  EXPECT_OK(world.engine.Advance(1, 4));
  EXPECT_OK(Load(world.engine, state));
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration[2], 3);
  EXPECT_EQ(vesper_engine_step_count(world.engine.get()), 3u);
}

TEST_P(SavedStateTest, WithoutALibraryItFitsAnEngineWithoutIt) {
  RememberingWorld first(Options(), 5);
  Bytes state = Save(first.engine);
  const auto remove = [&state](const char* library) {
    uint64_t size = state.size();
    const vesper_error error = Try([&](vesper_error* e) {
      return vesper_saved_state_remove_library(state.data(), &size, library, e);
    });
    state.resize(size);
    return error;
  };
  const Bytes whole = state;
  EXPECT_OK(remove("rememberin"));  // no library's name, though the beginning of one
  EXPECT_EQ(state, whole);
  TestEngine second(Options());
  EXPECT_REFUSED(ACCESS_CONFLICT, "which no loaded law keeps", Load(second, state));
  EXPECT_OK(remove("remembering"));
  EXPECT_OK(Load(second, state));
  EXPECT_EQ(vesper_engine_step_count(second.get()), 5u);
  EXPECT_REFUSED(ACCESS_CONFLICT, "lacks remembering/", Load(first.engine, state));
  state[state.size() / 2] ^= 1;
  EXPECT_REFUSED(INVALID_ARGUMENT, "checksum", remove("remembering"));
}

TEST_P(SavedStateTest, BringsItsRowsAlong) {
  RememberingWorld few(Options(), 4, 2), many(Options(), 1, 5);
  EXPECT_OK(Load(many.engine, Save(few.engine)));
  EXPECT_OK(many.engine.Advance(1, 1));
  EXPECT_EQ(many.bodies.acceleration[3 * 1 + 2], 5);
  EXPECT_EQ(many.bodies.acceleration[3 * 2 + 2], 1);
}

TEST_P(SavedStateTest, OfOtherLawsIsRefusedByName) {
  RememberingWorld with(Options(), 1);
  Bodies bodies(3);
  TestEngine without(Options());
  without.AddBodies(bodies);
  const Bytes state = Save(with.engine), empty = Save(without);
  EXPECT_REFUSED(ACCESS_CONFLICT, "holds remembering/remembering 1.0.0/sum: f64 x 1 per body",
                 Load(without, state));
  EXPECT_REFUSED(ACCESS_CONFLICT, "lacks remembering/remembering 1.0.0/sum: f64 x 1 per body",
                 Load(with.engine, empty));
  EXPECT_OK(with.engine.Advance(1, 1));
  EXPECT_EQ(with.bodies.acceleration[2], 2);
}

TEST_P(SavedStateTest, OfAnotherPrototypeIsRefusedByName) {
  EngineOptions options = Options();
  TestEngine wide(options);
  options.prototype = "si-f32";
  TestEngine narrow(options);
  EXPECT_REFUSED(ACCESS_CONFLICT, "prototype is si-f32, expected si-f64", Load(wide, Save(narrow)));
}

TEST_P(SavedStateTest, DamagedInAnyByteIsRefusedAndChangesNothing) {
  RememberingWorld world(Options(), 2, 1);
  const Bytes state = Save(world.engine);
  EXPECT_OK(world.engine.Advance(1, 1));
  for (size_t i = 0; i < state.size(); ++i) {
    Bytes damaged = state;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    ASSERT_STREQ(vesper_status_name(Load(world.engine, damaged).status), "INVALID_ARGUMENT") << i;
  }
  EXPECT_EQ(vesper_engine_step_count(world.engine.get()), 3u);
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration[2], 4);
}

TEST_P(SavedStateTest, CutAnywhereIsRefused) {
  RememberingWorld world(Options(), 2, 1);
  const Bytes state = Save(world.engine);
  for (size_t size = 0; size < state.size(); ++size) {
    const Bytes cut(state.begin(), state.begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_STREQ(vesper_status_name(Load(world.engine, cut).status), "INVALID_ARGUMENT") << size;
  }
}

TEST_P(SavedStateTest, OfAnotherVersionIsRefusedByNumber) {
  RememberingWorld world(Options(), 1);
  Bytes state = Save(world.engine);
  state[8] = 7;
  EXPECT_REFUSED(INVALID_ARGUMENT, "version is 7, expected 2", Load(world.engine, state));
}

TEST_P(SavedStateTest, RoomMustBeAsLargeAsSaid) {
  RememberingWorld world(Options(), 1);
  Bytes room(10);
  EXPECT_REFUSED(INVALID_ARGUMENT, "size is 10", Try([&](vesper_error* error) {
                   return vesper_engine_save_state(world.engine.get(), room.data(), room.size(),
                                                   error);
                 }));
}

}  // namespace
}  // namespace vesper::test
