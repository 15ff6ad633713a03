// SPDX-License-Identifier: Apache-2.0
// Tests that equal arrays, laws, order and dt give equal bits.
#include <cmath>
#include <random>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

constexpr uint64_t kSeed = 20240607;

Bodies RandomBodies(size_t count) {
  std::mt19937_64 random(kSeed);
  Bodies bodies(count);
  for (double& x : bodies.position) x = std::ldexp(static_cast<double>(random() >> 11), -53);
  return bodies;
}

uint64_t HashAfter(const char* field, const EngineOptions& options, uint32_t steps) {
  Bodies bodies = RandomBodies(10007);
  TestEngine engine(options);
  engine.AddBodies(bodies);
  engine.Load(field);
  engine.Load("push");
  engine.Load("euler");
  EXPECT_OK(engine.Advance(1.0 / 240, steps));
  return engine.StateHash();
}

class DeterminismTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Grains, DeterminismTest, testing::Values("field", "field_by_100"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(DeterminismTest, ThreadCountChangesNoBit) {
  RecordProperty("seed", std::to_string(kSeed));
  const uint64_t expected = HashAfter(GetParam(), {.threads = 1}, 20);
  for (const uint32_t threads : {2u, 3u, 8u}) {
    EXPECT_EQ(HashAfter(GetParam(), {.threads = threads}, 20), expected)
        << threads << " threads, seed " << kSeed;
  }
}

TEST_P(DeterminismTest, ValidateModeChangesNoBit) {
  EXPECT_EQ(HashAfter(GetParam(), {.validate = true, .threads = 2}, 20),
            HashAfter(GetParam(), {.validate = false, .threads = 2}, 20))
      << "seed " << kSeed;
}

TEST(ParallelForTest, EveryEngineHasTheThreadsItAskedForWhateverTheMachineHas) {
  // This test checks that the engine uses the requested number of threads. It might otherwise use 2
  // threads instead of 8 on a machine with 2 cores, also in the test above.
  for (const uint32_t threads : {2u, 8u, 3u}) {
    Bodies bodies(1);
    TestEngine engine({.threads = threads});
    engine.AddBodies(bodies);
    engine.Load("rendezvous", {{"seats", static_cast<double>(threads)}});
    EXPECT_OK(engine.Advance(0.1, 3));  // by helpers that were started, and by those that wait
  }
}

TEST(ParallelForTest, RangesBehindOneThatTakesLongAreDoneByOtherThreads) {
  const double ranges = 16;
  for (double held = 0; held < ranges; ++held) {
    SCOPED_TRACE(held);
    Bodies bodies(1);
    TestEngine engine({.threads = 2});
    engine.AddBodies(bodies);
    engine.Load("held_range", {{"held", held}, {"ranges", ranges}});
    EXPECT_OK(engine.Advance(0.1, 1));
  }
}

TEST(ParallelForTest, GrainIsPartOfTheResult) {
  // The result must depend on the chunks. The tests above could otherwise pass with a law whose
  // result does not depend on them.
  EXPECT_NE(HashAfter("field", {}, 1), HashAfter("field_by_100", {}, 1)) << "seed " << kSeed;
}

}  // namespace
}  // namespace vesper::test
