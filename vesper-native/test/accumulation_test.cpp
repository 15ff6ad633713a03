// SPDX-License-Identifier: Apache-2.0
// Tests the sum of the forces of several laws.
#include <algorithm>
#include <limits>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

class AccumulationTest : public BothModes {};
IN_BOTH_MODES(AccumulationTest);

TEST_P(AccumulationTest, SumStartsFromZeroInEveryStep) {
  Bodies bodies(2);
  bodies.force.assign(6, 99);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("push", {{"force", 2}});
  EXPECT_OK(engine.Advance(1, 3));
  EXPECT_EQ(bodies.force, (std::vector<double>{2, 0, 0, 2, 0, 0}));
}

TEST_P(AccumulationTest, SumIsZeroWithoutALawThatAdds) {
  Bodies bodies(2);
  bodies.force.assign(6, 99);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("euler");
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force, std::vector<double>(6, 0));
}

TEST_P(AccumulationTest, SharesOfSeveralLawsAddUp) {
  Bodies bodies(2);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("push", {{"force", 2}});
  const vesper_library_id again = engine.Load("push_again", {{"force", 8}});
  EXPECT_OK(engine.Advance(1, 3));
  EXPECT_EQ(bodies.force, (std::vector<double>{10, 0, 0, 10, 0, 0}));
  EXPECT_OK(engine.Unload(again));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force, (std::vector<double>{2, 0, 0, 2, 0, 0}));
}

TEST_P(AccumulationTest, SumStartsFromTheAppliedForce) {
  Bodies bodies(2);
  bodies.applied = {1, 2, 3, 4, 5, 6};
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  EXPECT_OK(engine.Add("appliedForce", bodies.applied, 3));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force, bodies.applied);
  engine.Load("push", {{"force", 10}});
  EXPECT_OK(engine.Advance(1, 2));
  EXPECT_EQ(bodies.force, (std::vector<double>{11, 2, 3, 14, 5, 6}));
}

TEST_P(AccumulationTest, SharesAreRoundedOnTheirOwnAndSummedInOrderOfLoading) {
  // Each push adds two halves of 1. Both halves would be lost if the law added them to a running
  // sum of 1e16.
  Bodies bodies(1);
  bodies.applied = {1e16, 0, 0};
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  EXPECT_OK(engine.Add("appliedForce", bodies.applied, 3));
  engine.Load("push", {{"force", 2}});
  engine.Load("push_again", {{"force", -1e16}});
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force[0], (1e16 + 2) - 1e16);
}

TEST_P(AccumulationTest, SumThatOverflowsNamesTheLawThatMadeIt) {
  Bodies bodies(3);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  engine.Load("push", {{"force", 1.5e308}});
  const vesper_library_id again = engine.Load("push_again", {{"force", 1.5e308}});
  const vesper_error error = engine.Advance(1, 1);
  EXPECT_REFUSED(LAW_MISBEHAVED, "law push_again", error);
  EXPECT_EQ(error.library_id, again);
  EXPECT_EQ(error.law_index, 0u);
  EXPECT_EQ(error.row, 0u);
  EXPECT_STREQ(error.property, "externalForce");
  EXPECT_EQ(error.stage, 1u);
}

TEST_P(AccumulationTest, AppliedForceMustBeFinite) {
  Bodies bodies(3);
  bodies.applied[7] = std::numeric_limits<double>::quiet_NaN();
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  EXPECT_OK(engine.Add("appliedForce", bodies.applied, 3));
  const vesper_error error = engine.Advance(1, 1);
  EXPECT_REFUSED(INVALID_ARGUMENT, "property appliedForce, row 2", error);
  EXPECT_EQ(error.library_id, VESPER_NO_LIBRARY);
  EXPECT_EQ(error.row, 2u);
}

// The test uses enough rows that several threads share them.
TEST_P(AccumulationTest, TheFirstRowThatIsNotFiniteIsNamedWhateverTheNumberOfThreads) {
  for (const uint32_t threads : {1u, 2u, 8u}) {
    for (const bool applied : {true, false}) {
      Bodies bodies(200000);
      EngineOptions options = Options();
      options.threads = threads;
      TestEngine engine(options);
      engine.AddBodies(bodies);
      EXPECT_OK(engine.Add("appliedForce", bodies.applied, 3));
      engine.Load("push", {{"force", 2}});
      engine.Load("relay_velocity");  // from positions
      EXPECT_OK(engine.Advance(1, 1));
      EXPECT_EQ(std::count(bodies.force.begin(), bodies.force.end(), 2.0), 200000);
      std::vector<double>& spoilt = applied ? bodies.applied : bodies.position;
      for (const size_t row : {190000u, 60001u, 150000u}) {
        spoilt[3 * row] = std::numeric_limits<double>::quiet_NaN();
      }
      const vesper_error error = engine.Advance(1, 1);
      EXPECT_REFUSED(INVALID_ARGUMENT, applied ? "appliedForce, row 60001" : "position, row 60001",
                     error);
      EXPECT_EQ(error.row, 60001u) << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace vesper::test
