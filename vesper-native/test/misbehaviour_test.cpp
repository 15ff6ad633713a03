// SPDX-License-Identifier: Apache-2.0
// Tests laws that violate the contract: detection, report, and consequences.
#include "misbehaving.h"

#include <cfenv>
#include <cmath>
#include <limits>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

class MisbehaviourTest : public BothModes {
 protected:
  vesper_error AdvanceWith(const EngineOptions& options, Misbehaviour mode, double row = 0) {
    engine = std::make_unique<TestEngine>(options);
    bodies = Bodies(5);
    engine->AddBodies(bodies);
    library = engine->Load("misbehaving", {{"mode", static_cast<double>(mode)}, {"row", row}});
    return engine->Advance(1, 1);
  }

  Bodies bodies{5};
  std::unique_ptr<TestEngine> engine;
  vesper_library_id library = 0;
};
IN_BOTH_MODES(MisbehaviourTest);

TEST_P(MisbehaviourTest, WellBehavedLawPasses) {
  EXPECT_OK(AdvanceWith(Options(), WELL_BEHAVED));
  EXPECT_EQ(bodies.acceleration, std::vector<double>(15, 1));
}

TEST_P(MisbehaviourTest, NanIsLaidAtTheDoorOfLawPropertyAndRow) {
  const vesper_error error = AdvanceWith(Options(), WRITE_NAN, 3);
  EXPECT_REFUSED(LAW_MISBEHAVED, "law misbehaving: property position, row 3: wrote nan", error);
  EXPECT_EQ(error.library_id, library);
  EXPECT_EQ(error.law_index, 0u);
  EXPECT_EQ(error.row, 3u);
  EXPECT_STREQ(error.property, "position");
}

TEST_P(MisbehaviourTest, InfinityIsFoundInTheLastValue) {
  const vesper_error error = AdvanceWith(Options(), WRITE_INFINITY, 4);
  EXPECT_REFUSED(LAW_MISBEHAVED, "row 4: wrote -inf to component 2", error);
}

TEST_P(MisbehaviourTest, FailureCarriesTheLawsOwnMessageOnOneLine) {
  const vesper_error error = AdvanceWith(Options(), FAIL_WITH_MESSAGE);
  EXPECT_REFUSED(LAW_FAILED, "law misbehaving: diverged at once", error);
  EXPECT_EQ(error.library_id, library);
  EXPECT_EQ(error.row, VESPER_NO_ROW);
}

TEST_P(MisbehaviourTest, FailureWithoutMessageNamesTheStatus) {
  EXPECT_REFUSED(LAW_FAILED, "law misbehaving: returned status 2 (NOT_FOUND)",
                 AdvanceWith(Options(), FAIL_WITHOUT_MESSAGE));
}

TEST_P(MisbehaviourTest, FailureKeepsRowAndPropertyThatTheLawNames) {
  const vesper_error error = AdvanceWith(Options(), FAIL_WITH_ROW, 2);
  EXPECT_REFUSED(LAW_FAILED, "too fast", error);
  EXPECT_EQ(error.row, 2u);
  EXPECT_STREQ(error.property, "position");
}

TEST_P(MisbehaviourTest, ExceptionBecomesAStatus) {
  TestEngine throwing(Options());
  throwing.Load("throwing");
  EXPECT_REFUSED(LAW_FAILED, "law throwing: threw: out of range", throwing.Advance(1, 1));
}

TEST_P(MisbehaviourTest, LoopOverMoreThanAnyMemoryHoldsIsRefused) {
  for (const uint32_t threads : {1u, 3u}) {
    for (const double count : {0x1p60, 0x1p63, 0x1p40 + 1}) {
      for (const double grain : {0.0, 1.0, 0x1p63}) {
        TestEngine fresh({GetParam(), threads});
        fresh.AddBodies(bodies);
        const vesper_library_id looping =
            fresh.Load("looping", {{"count", count}, {"grain", grain}});
        const vesper_error error = fresh.Advance(1, 1);
        EXPECT_REFUSED(LAW_MISBEHAVED, "law looping: parallel_for over ", error);
        EXPECT_REFUSED(LAW_MISBEHAVED, " elements, expected 1099511627776 or fewer", error);
        EXPECT_EQ(error.library_id, looping);
      }
    }
  }
}

/// The end of the first range must not wrap around to the beginning.
TEST_P(MisbehaviourTest, LoopInRangesOfAnyLengthDoesEachElementOnce) {
  for (const uint32_t threads : {1u, 3u}) {
    for (const double grain : {1.0, 4.0, 0x1p40, 0x1p63}) {
      TestEngine fresh({GetParam(), threads});
      fresh.AddBodies(bodies);
      fresh.Load("looping", {{"count", 5}, {"grain", grain}});
      EXPECT_OK(fresh.Advance(1, 1));
      EXPECT_EQ(bodies.force, (std::vector<double>{1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0}));
    }
  }
}

/// The constructor runs when the library is opened, to read the declarations.
TEST_P(MisbehaviourTest, ExceptionOfAConstructorArrivesWithItsMessage) {
  TestEngine fresh(Options());
  fresh.AddBodies(bodies);
  EXPECT_REFUSED(LAW_FAILED, "law picky: no table of drag for 3 speeds", fresh.TryLoad("picky"));
  EXPECT_REFUSED(LAW_FAILED, "law picky: its constructor threw something that is no std::exception",
                 fresh.TryLoad("picky_number"));
  EXPECT_OK(fresh.Advance(1, 1));
}

TEST_P(MisbehaviourTest, LawThatCannotBeMadeIsNotLoaded) {
  TestEngine fresh(Options());
  fresh.AddBodies(bodies);
  EXPECT_REFUSED(LAW_FAILED, "law misbehaving: no device",
                 fresh.TryLoad("misbehaving", {{"mode", FAIL_IN_CREATE}}));
  EXPECT_REFUSED(LAW_MISBEHAVED, "create returned OK but no law",
                 fresh.TryLoad("misbehaving", {{"mode", NO_LAW_FROM_CREATE}}));
  EXPECT_OK(fresh.Advance(1, 1));
}

TEST_P(MisbehaviourTest, FailureToBindIsNoFault) {
  const vesper_error error = AdvanceWith(Options(), FAIL_IN_BIND);
  EXPECT_REFUSED(LAW_FAILED, "law misbehaving: no room", error);
  EXPECT_EQ(error.library_id, library);
  EXPECT_REFUSED(LAW_FAILED, "no room", engine->Advance(1, 1));
  EXPECT_OK(engine->Unload(library));
  EXPECT_OK(engine->Advance(1, 1));
}

TEST_P(MisbehaviourTest, NaNInWhatLawsOnlyReadIsTheClients) {
  Bodies given(3);
  TestEngine fresh(Options());
  fresh.AddBodies(given);
  fresh.Load("euler");
  given.mass[1] = NAN;
  const vesper_error error = fresh.Advance(1, 1);
  EXPECT_REFUSED(INVALID_ARGUMENT, "property mass, row 1: is nan, which law euler reads", error);
  EXPECT_STREQ(error.property, "mass");
  EXPECT_EQ(error.row, 1u);
  EXPECT_EQ(error.library_id, VESPER_NO_LIBRARY);
  EXPECT_EQ(error.law_index, VESPER_NO_LAW);
  EXPECT_REFUSED(FAULTED, "a step failed", fresh.Advance(1, 1));
  given.mass[1] = 2;
  given.position.assign(9, 0);
  given.velocity.assign(9, 0);
  EXPECT_EQ(vesper_engine_clear_fault(fresh.get(), nullptr), VESPER_OK);
  EXPECT_OK(fresh.Advance(1, 1));
}

TEST_P(MisbehaviourTest, BlameIsOfTheFirstStepAndRowWhateverTheNumberOfThreads) {
  const auto diverge = [](const EngineOptions& options) {
    Bodies many(50'000);  // more than one chunk per thread
    const auto launch = [&many](size_t row, double speed) { many.velocity[3 * row] = speed; };
    launch(10, 3e307);  // the lowest row, but it overflows two steps later
    launch(30'000, 8e307);
    launch(44'000, 8e307);
    TestEngine fresh(options);
    fresh.AddBodies(many);
    fresh.Load("push");
    fresh.Load("euler");
    return fresh.Advance(1, 20);
  };
  for (const uint32_t threads : {1u, 2u, 8u}) {
    const vesper_error error = diverge({.validate = GetParam(), .threads = threads});
    EXPECT_REFUSED(LAW_MISBEHAVED,
                   "after 2 steps: law euler: property position, row 30000: "
                   "wrote inf to component 0",
                   error);
    EXPECT_STREQ(error.property, "position");
    EXPECT_EQ(error.row, 30'000u);
  }
}

TEST_P(MisbehaviourTest, ALawThatWritesImmenseValuesFailsItselfIfValuesAreLimited) {
  for (const bool limited : {false, true}) {
    Bodies bodies(1);
    bodies.mass = {1e-20};
    TestEngine fresh({.validate = GetParam(), .limit_values = limited});
    fresh.AddBodies(bodies);
    fresh.Load("euler");
    const vesper_library_id push = fresh.Load("push", {{"force", 1e300}});
    const vesper_error error = fresh.Advance(1, 1);
    if (limited) {
      EXPECT_REFUSED(LAW_MISBEHAVED,
                     "law push: property externalForce, row 0: wrote 1e+300, more than 1.7e100, "
                     "to component 0",
                     error);
      EXPECT_EQ(error.library_id, push);
    } else {
      EXPECT_REFUSED(LAW_MISBEHAVED, "law euler: property", error);
    }
  }
}

TEST_P(MisbehaviourTest, FailedStepsAreVoidAndLeaveTheEngineFaulted) {
  AdvanceWith(Options(), WRITE_NAN);
  EXPECT_EQ(vesper_engine_step_count(engine->get()), 0u);
  const vesper_error error = engine->Advance(1, 1);
  EXPECT_REFUSED(FAULTED, "a step failed", error);
  EXPECT_EQ(error.library_id, library);
  uint64_t hash = 5;
  EXPECT_EQ(vesper_engine_state_hash(engine->get(), &hash, nullptr), VESPER_FAULTED);
  EXPECT_EQ(hash, 5u);
}

TEST_P(MisbehaviourTest, ClearedFaultLetsTheEngineTryAgain) {
  AdvanceWith(Options(), WRITE_NAN);
  const Bodies rollback(5);
  bodies.position = rollback.position;
  EXPECT_EQ(vesper_engine_clear_fault(engine->get(), nullptr), VESPER_OK);
  EXPECT_REFUSED(LAW_MISBEHAVED, "wrote nan", engine->Advance(1, 1));
}

TEST_P(MisbehaviourTest, UnloadingTheCulpritEndsTheFaultAndUnloadingAnotherDoesNot) {
  AdvanceWith(Options(), WRITE_NAN);
  const vesper_library_id push = engine->Load("push");
  EXPECT_OK(engine->Unload(push));
  EXPECT_REFUSED(FAULTED, "a step failed", engine->Advance(1, 1));
  EXPECT_OK(engine->Unload(library));
  EXPECT_OK(engine->Advance(1, 1));
}

TEST_P(MisbehaviourTest, FrameRedoneWithoutTheCulpritMatchesAWorldThatNeverHadIt) {
  Bodies with(5), without(5);
  TestEngine first(Options()), second(Options());
  for (auto [engine, columns] : {std::pair(&first, &with), std::pair(&second, &without)}) {
    engine->AddBodies(*columns);
    engine->Load("field");
    engine->Load("euler");
    EXPECT_OK(engine->Advance(0.25, 10));
  }
  const vesper_library_id culprit = first.Load("misbehaving", {{"mode", WRITE_NAN}});
  const Bodies rollback = with;
  EXPECT_NE(first.Advance(0.25, 3).status, VESPER_OK);
  with.position = rollback.position;
  with.velocity = rollback.velocity;
  with.acceleration = rollback.acceleration;
  with.force = rollback.force;
  EXPECT_OK(first.Unload(culprit));
  EXPECT_OK(first.Advance(0.25, 3));
  EXPECT_OK(second.Advance(0.25, 3));
  EXPECT_EQ(first.StateHash(), second.StateHash());
}

TEST_P(MisbehaviourTest, LawCannotChangeTheFloatingPointModesOfItsHost) {
  volatile double tiny = std::numeric_limits<double>::min();
  EXPECT_OK(AdvanceWith(Options(), CHANGE_MODES));
  EXPECT_EQ(std::fegetround(), FE_TONEAREST);
  EXPECT_GT(tiny / 2, 0) << "denormals are flushed";
}

TEST_P(MisbehaviourTest, ModesOfTheHostDoNotReachALaw) {
  const auto run = [this] {
    Bodies columns(100);
    TestEngine engine(Options());
    engine.AddBodies(columns);
    engine.Load("field");
    EXPECT_OK(engine.Advance(1, 1));
    return columns.force;
  };
  const std::vector<double> expected = run();
  ASSERT_EQ(std::fesetround(FE_UPWARD), 0);
  const std::vector<double> upward = run();
  EXPECT_EQ(std::fegetround(), FE_UPWARD);
  std::fesetround(FE_TONEAREST);
  EXPECT_EQ(upward, expected);
}

class ValidateTest : public MisbehaviourTest {};
INSTANTIATE_TEST_SUITE_P(Mode, ValidateTest, testing::Values(true), ModeName);

TEST_P(ValidateTest, WriteToAReadColumnIsCaught) {
  const vesper_error error = AdvanceWith(Options(), WRITE_READ_COLUMN, 2);
  EXPECT_REFUSED(LAW_MISBEHAVED, "property mass, row 2: declared READ, but the row was changed",
                 error);
  EXPECT_EQ(error.row, 2u);
  EXPECT_EQ(bodies.mass, Bodies(5).mass) << "the client's column is out of reach";
}

TEST_P(ValidateTest, WriteToAReadColumnWhileBindingIsCaught) {
  EXPECT_REFUSED(LAW_MISBEHAVED, "property mass, row 0: declared READ",
                 AdvanceWith(Options(), WRITE_READ_COLUMN_IN_BIND));
}

TEST_P(ValidateTest, WriteOutsideTheArrayIsCaught) {
  const vesper_error past = AdvanceWith(Options(), WRITE_PAST_END);
  EXPECT_REFUSED(LAW_MISBEHAVED, "property position, row 5: wrote past the last row", past);
  EXPECT_REFUSED(LAW_MISBEHAVED, "property position, row 0: wrote before the first row",
                 AdvanceWith(Options(), WRITE_BEFORE_START));
}

TEST_P(ValidateTest, RowLeftUnwrittenIsCaught) {
  const vesper_error error = AdvanceWith(Options(), LEAVE_ROW_UNWRITTEN, 3);
  EXPECT_REFUSED(LAW_MISBEHAVED, "acceleration, row 3: declared WRITE, but the row was not written",
                 error);
}

TEST_P(ValidateTest, NothingOfALawThatBrokeItsWordIsCopiedBack) {
  AdvanceWith(Options(), WRITE_PAST_END);
  EXPECT_EQ(bodies.position, Bodies(5).position);
  EXPECT_EQ(bodies.acceleration, Bodies(5).acceleration);
}

TEST_P(ValidateTest, ReferencesEditedWithoutTouchAreCheckedEveryTime) {
  Bodies columns(2);
  std::vector<uint32_t> endpoints = {0, 1};
  TestEngine engine(Options());
  engine.AddBodies(columns);
  ASSERT_EQ(vesper_provider_add_physical_property(engine.provider(), "endpoints", endpoints.data(),
                                                  1, nullptr, 1, nullptr),
            VESPER_OK);
  EXPECT_OK(engine.Advance(1, 1));
  endpoints[1] = 2;
  EXPECT_REFUSED(INVALID_ARGUMENT, "refers to row 2 of kind body", engine.Advance(1, 1));
}

}  // namespace
}  // namespace vesper::test
