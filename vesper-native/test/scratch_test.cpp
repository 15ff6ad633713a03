// SPDX-License-Identifier: Apache-2.0
// Tests the SCRATCH memory that the engine keeps for laws.
#include "test_kit.hpp"

namespace vesper::test {
namespace {

class ScratchTest : public BothModes {};
IN_BOTH_MODES(ScratchTest);

/// Bodies and a law that writes its SCRATCH values of row i to the acceleration: (sum of masses, 0,
/// calls).
struct Remembering {
  Remembering(size_t count, const EngineOptions& options, double fail_at = -1)
      : bodies(count), engine(options) {
    EXPECT_OK(engine.Add("mass", bodies.mass, 1));
    EXPECT_OK(engine.Add("acceleration", bodies.acceleration, 3));
    library = engine.Load("remembering", {{"failAt", fail_at}});
  }

  /// Replaces the bodies by bodies of these masses.
  void Rebind(std::vector<double> mass) {
    bodies.mass = std::move(mass);
    bodies.acceleration.assign(3 * bodies.mass.size(), 99);
    EXPECT_OK(engine.Rebind("mass", bodies.mass, 1));
    EXPECT_OK(engine.Rebind("acceleration", bodies.acceleration, 3));
  }
  vesper_error MoveRow(const char* kind, uint64_t from, uint64_t to) {
    return Try([&](vesper_error* error) {
      return vesper_engine_move_row(engine.get(), kind, from, to, error);
    });
  }

  Bodies bodies;
  TestEngine engine;
  vesper_library_id library = 0;
};

TEST_P(ScratchTest, StartsAtZeroAndLastsFromStepToStep) {
  Remembering world(2, Options());
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{1, 0, 1, 2, 0, 1}));
  EXPECT_OK(world.engine.Advance(1, 2));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{3, 0, 3, 6, 0, 3}));
}

TEST_P(ScratchTest, StartsAtZeroAgainWhenTheLawIsLoadedAgain) {
  Remembering world(1, Options());
  EXPECT_OK(world.engine.Advance(1, 5));
  EXPECT_OK(world.engine.Unload(world.library));
  world.engine.Load("remembering");
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{1, 0, 1}));
}

TEST_P(ScratchTest, LastsWhenArraysMoveAndOtherLawsComeAndGo) {
  Remembering world(2, Options());
  EXPECT_OK(world.engine.Advance(1, 1));
  world.Rebind({10, 20});
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{11, 0, 2, 22, 0, 2}));
}

TEST_P(ScratchTest, NewRowsAreZeroAndLostRowsAreForgotten) {
  Remembering world(2, Options());
  EXPECT_OK(world.engine.Advance(1, 1));
  world.Rebind({1, 2, 3});
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{2, 0, 2, 4, 0, 2, 3, 0, 1}));
  world.Rebind({1});
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{3, 0, 3}));
  world.Rebind({1, 2});
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{4, 0, 4, 2, 0, 1}));
}

TEST_P(ScratchTest, ComesBackWhenAStepFails) {
  Remembering world(2, Options(), 3);
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_REFUSED(LAW_FAILED, "as told", world.engine.Advance(1, 3));
  EXPECT_OK(Try(
      [&](vesper_error* error) { return vesper_engine_clear_fault(world.engine.get(), error); }));
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{2, 0, 2, 4, 0, 2}));
}

TEST_P(ScratchTest, FollowsTheRowThatFillsAGap) {
  Remembering world(3, Options());
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_OK(world.MoveRow("body", 2, 0));
  world.Rebind({3, 2});
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{6, 0, 2, 4, 0, 2}));
}

TEST_P(ScratchTest, RowThatWasLeftIsAsNew) {
  Remembering world(3, Options());
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_OK(world.MoveRow("body", 2, 0));  // a new body takes row 2
  EXPECT_OK(world.MoveRow("body", 1, 1));  // another new body takes row 1
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{4, 0, 2, 2, 0, 1, 3, 0, 1}));
}

TEST_P(ScratchTest, RowsAddedSinceTheLastStepAreNewWhereverTheyMove) {
  Remembering world(2, Options());
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_OK(world.MoveRow("body", 2, 0));
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{1, 0, 1, 4, 0, 2}));
}

TEST_P(ScratchTest, MovingRowsOfAnotherKindChangesNothing) {
  Remembering world(2, Options());
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_OK(world.MoveRow("spring", 1, 0));
  EXPECT_OK(world.engine.Advance(1, 1));
  EXPECT_EQ(world.bodies.acceleration, (std::vector<double>{2, 0, 2, 4, 0, 2}));
}

TEST_P(ScratchTest, MovesThatMakeNoSenseAreRefused) {
  Remembering world(2, Options());
  EXPECT_REFUSED(NOT_FOUND, "no kind 'ghost'", world.MoveRow("ghost", 1, 0));
  EXPECT_REFUSED(INVALID_ARGUMENT, "row 0 of kind body cannot become row 1",
                 world.MoveRow("body", 0, 1));
  EXPECT_REFUSED(INVALID_ARGUMENT, "kind is null", world.MoveRow(nullptr, 1, 0));
}

TEST_P(ScratchTest, KindMustBeKnown) {
  TestEngine engine(Options());
  EXPECT_REFUSED(NOT_FOUND, "scratch sum: prototype si-f64 has no kind ghost",
                 engine.TryLoad("remembering_ghosts"));
}

TEST_P(ScratchTest, CannotBeOptional) {
  TestEngine engine(Options());
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "SCRATCH cannot be optional",
                 engine.TryLoad("remembering_perhaps"));
}

/// Each body could need 8 GB without this limit.
TEST_P(ScratchTest, HasAtMost4096ComponentsInARow) {
  TestEngine engine(Options());
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED,
                 "law remembering_all, property sum: SCRATCH has 1000000000 components, expected "
                 "4096 or fewer",
                 engine.TryLoad("remembering_all"));
}

TEST_P(ScratchTest, HasAtMostOneGibibyteInAllRows) {
  Bodies few(100);
  TestEngine engine(Options());
  engine.AddBodies(few);
  engine.Load("remembering_much");
  EXPECT_OK(engine.Advance(1, 1));
  Bodies many((1 << 15) + 1);  // rows of 32 KiB
  TestEngine full(Options());
  full.AddBodies(many);
  const vesper_library_id library = full.Load("remembering_much");
  const vesper_error error = full.Advance(1, 1);
  EXPECT_REFUSED(LAW_MISBEHAVED,
                 "law remembering_much: SCRATCH sum: 32769 rows of 32768 bytes, expected 1024 MiB "
                 "or less",
                 error);
  EXPECT_EQ(error.library_id, library);
  EXPECT_STREQ(error.property, "sum");
  EXPECT_OK(full.Unload(library));
  EXPECT_OK(full.Advance(1, 1));
}

/// Returns a row of a SCRATCH use, or the error as an exception of the test.
std::vector<double> RememberedRow(Remembering& world, uint32_t use, uint64_t row, uint32_t count) {
  std::vector<double> values(count, -1);
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_scratch_row(world.engine.get(), world.library, 0, use, row, values.data(),
                                     count, error);
  }));
  return values;
}

TEST_P(ScratchTest, OneRowCanBeRead) {
  Remembering world(2, Options());
  EXPECT_EQ(RememberedRow(world, 2, 1, 1), (std::vector<double>{0}));  // before the first step
  EXPECT_OK(world.engine.Advance(1, 3));
  EXPECT_EQ(RememberedRow(world, 2, 0, 1), (std::vector<double>{3}));
  EXPECT_EQ(RememberedRow(world, 2, 1, 1), (std::vector<double>{6}));
  EXPECT_EQ(RememberedRow(world, 3, 1, 2), (std::vector<double>{0, 3}));
  EXPECT_OK(world.MoveRow("body", 1, 0));
  EXPECT_EQ(RememberedRow(world, 2, 0, 1), (std::vector<double>{6}));
  EXPECT_EQ(RememberedRow(world, 2, 1, 1), (std::vector<double>{0}));
  EXPECT_EQ(RememberedRow(world, 2, UINT64_MAX, 1), (std::vector<double>{0}));
}

TEST_P(ScratchTest, OnlyScratchCanBeReadInItsShape) {
  Remembering world(2, Options());
  double value = -1;
  const auto read = [&](vesper_library_id library, uint32_t law, uint32_t use, double* out,
                        uint32_t count) {
    return Try([&](vesper_error* error) {
      return vesper_engine_scratch_row(world.engine.get(), library, law, use, 0, out, count, error);
    });
  };
  EXPECT_REFUSED(NOT_FOUND, "no library with id 99", read(99, 0, 2, &value, 1));
  EXPECT_REFUSED(NOT_FOUND, "there is no law 1", read(world.library, 1, 2, &value, 1));
  EXPECT_REFUSED(NOT_FOUND, "no SCRATCH use 0", read(world.library, 0, 0, &value, 1));
  EXPECT_REFUSED(NOT_FOUND, "no SCRATCH use 4", read(world.library, 0, 4, &value, 1));
  EXPECT_REFUSED(INVALID_ARGUMENT, "SCRATCH count: count is 1, expected 2",
                 read(world.library, 0, 3, &value, 1));
  EXPECT_REFUSED(INVALID_ARGUMENT, "out is null", read(world.library, 0, 2, nullptr, 1));
  EXPECT_EQ(value, -1);
}

TEST_P(ScratchTest, HoldsNoNaN) {
  Remembering world(2, Options());
  world.bodies.mass[1] = 1e308;
  EXPECT_OK(world.engine.Advance(1, 1));
  const vesper_error error = world.engine.Advance(1, 1);
  EXPECT_REFUSED(LAW_MISBEHAVED, "row 1", error);
}

}  // namespace
}  // namespace vesper::test
