// SPDX-License-Identifier: Apache-2.0
// Tests laws that are called in every n-th step only, or never.
#include <limits>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

class IntervalTest : public BothModes {};
IN_BOTH_MODES(IntervalTest);

vesper_error SetInterval(TestEngine& engine, vesper_library_id library, uint32_t interval) {
  return Try([&](vesper_error* error) {
    return vesper_engine_set_interval(engine.get(), library, interval, error);
  });
}

TEST_P(IntervalTest, AddsInEveryNthStepWhatItWouldAddInAllOfThem) {
  Bodies bodies(2);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id push = engine.Load("push", {{"force", 2}});
  EXPECT_OK(SetInterval(engine, push, 3));
  const std::vector<double> tripled{6, 0, 0, 6, 0, 0}, nothing(6, 0);
  for (int step = 0; step < 7; ++step) {
    EXPECT_OK(engine.Advance(1, 1));
    EXPECT_EQ(bodies.force, step % 3 == 0 ? tripled : nothing) << step;
  }
  EXPECT_EQ(engine.LawInfo(push).calls, 3u);
  EXPECT_OK(SetInterval(engine, push, 1));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force, (std::vector<double>{2, 0, 0, 2, 0, 0}));
}

TEST_P(IntervalTest, LeavesTheShareOfOtherLawsAlone) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id push = engine.Load("push", {{"force", 2}});
  engine.Load("push_again", {{"force", 8}});
  EXPECT_OK(SetInterval(engine, push, 2));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force, (std::vector<double>{12, 0, 0}));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force, (std::vector<double>{8, 0, 0}));
}

TEST_P(IntervalTest, ZeroMeansNever) {
  Bodies bodies(1);
  bodies.velocity = {1, 0, 0};
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id push = engine.Load("push", {{"force", 2}});
  const vesper_library_id euler = engine.Load("euler");
  EXPECT_OK(SetInterval(engine, push, 0));
  EXPECT_OK(SetInterval(engine, euler, 0));
  const std::vector<double> before = bodies.position;
  EXPECT_OK(engine.Advance(1, 2));
  EXPECT_EQ(bodies.force, (std::vector<double>{0, 0, 0}));
  EXPECT_EQ(bodies.position, before);
  EXPECT_EQ(engine.LawInfo(push).calls + engine.LawInfo(euler).calls, 0u);
}

TEST_P(IntervalTest, IsRefusedForLawsThatWriteProperties) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id euler = engine.Load("euler");
  const vesper_error error = SetInterval(engine, euler, 2);
  EXPECT_EQ(error.status, VESPER_ACCESS_CONFLICT);
  EXPECT_EQ(error.library_id, euler);
  EXPECT_NE(std::string(error.message).find("is no force law"), std::string::npos);
  EXPECT_EQ(SetInterval(engine, 99, 2).status, VESPER_NOT_FOUND);
}

TEST_P(IntervalTest, AForceThatOverflowsForSeveralStepsAtOnceIsAFault) {
  Bodies bodies(1);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id push =
      engine.Load("push", {{"force", std::numeric_limits<double>::max() / 2}});
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_OK(SetInterval(engine, push, 4));
  EXPECT_OK(engine.Advance(1, 3));  // steps 1 to 3, in which the law adds nothing
  const vesper_error error = engine.Advance(1, 1);
  EXPECT_EQ(error.status, VESPER_LAW_MISBEHAVED);
  EXPECT_EQ(error.library_id, push);
  EXPECT_STREQ(error.property, "externalForce");
}

}  // namespace
}  // namespace vesper::test
