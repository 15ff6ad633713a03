// SPDX-License-Identifier: Apache-2.0
// Tests laws whose units differ in scale from the prototype's.
#include <random>

#include "kernels.hpp"
#include "test_kit.hpp"

namespace vesper::test {
namespace {

class ConversionTest : public BothModes {
 protected:
  ConversionTest() : engine(Options()) { engine.AddBodies(bodies); }

  Bodies bodies{5};
  TestEngine engine;
};
IN_BOTH_MODES(ConversionTest);

TEST_P(ConversionTest, LawSeesAndWritesValuesInItsOwnUnits) {
  engine.Load("commuter");
  EXPECT_OK(engine.Advance(1, 3));
  for (size_t row = 0; row < 5; ++row) {
    const double faster = row % 2 == 0 ? 30 : 0;  // 3 steps of 36 km/h
    EXPECT_DOUBLE_EQ(bodies.velocity[3 * row], 1 + faster);
    EXPECT_EQ(bodies.force[3 * row], 2000);
    EXPECT_EQ(bodies.force[3 * row + 1], 0);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(bodies.position[3 * row + c], static_cast<double>(row * (c + 1)));
      EXPECT_DOUBLE_EQ(bodies.acceleration[3 * row + c], bodies.position[3 * row + c]);
    }
  }
}

TEST_P(ConversionTest, ValuesThatTheLawLeavesAloneKeepTheirBits) {
  constexpr uint32_t kSeed = 20070;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> speed(-300, 300);
  uint64_t spoilt = 0;
  for (double& value : bodies.velocity) {
    value = speed(random);
    spoilt += value * (1 / (1000.0 / 3600)) * (1000.0 / 3600) != value;
  }
  ASSERT_GT(spoilt, 0u) << "seed " << kSeed << " draws only values that survive conversion";
  const std::vector<double> before = bodies.velocity;
  engine.Load("commuter");
  EXPECT_OK(engine.Advance(1, 100));
  for (size_t i = 0; i < before.size(); ++i) {
    const bool driven = i % 6 == 0;
    EXPECT_EQ(bodies.velocity[i] != before[i], driven) << "value " << i;
  }
}

TEST_P(ConversionTest, SumsMixLawsOfDifferentUnits) {
  engine.Load("commuter");
  engine.Load("push");
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force[0], 2001);
}

TEST_P(ConversionTest, ConvertedArraysFollowARebind) {
  engine.Load("commuter");
  EXPECT_OK(engine.Advance(1, 1));
  Bodies more(9);
  for (const auto& [name, values, components] : {std::tuple{"mass", &more.mass, 1u},
                                                 {"position", &more.position, 3u},
                                                 {"velocity", &more.velocity, 3u},
                                                 {"acceleration", &more.acceleration, 3u},
                                                 {"externalForce", &more.force, 3u},
                                                 {"orientation", &more.orientation, 4u}}) {
    EXPECT_OK(engine.Rebind(name, *values, components));
  }
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_DOUBLE_EQ(more.velocity[3 * 8], 11);
  EXPECT_DOUBLE_EQ(more.acceleration[3 * 8 + 2], 24);
  EXPECT_DOUBLE_EQ(bodies.velocity[0], 11) << "the old array is left alone";
}

TEST_P(ConversionTest, ValueThatOverflowsInThePrototypesUnitIsTheLawsFault) {
  engine.Load("commuter", {{"force", 1e307}});
  const vesper_error error = engine.Advance(1, 1);
  EXPECT_REFUSED(LAW_MISBEHAVED,
                 "law commuter: property externalForce, row 0: what it wrote overflows", error);
  EXPECT_EQ(error.row, 0u);
  EXPECT_STREQ(error.property, "externalForce");
}

TEST(ConversionKernelTest, SinglePrecisionRoundsOnce) {
  const float from[] = {1, 10, 0.1f, -0.0f};
  float to[4];
  Convert(VESPER_F32, to, from, {1, 1000.0 / 3600}, 4);
  EXPECT_EQ(to[0], 3.6f);
  EXPECT_EQ(to[1], 36.0f);
  EXPECT_EQ(to[2], static_cast<float>(double{0.1f} / (1000.0 / 3600)));
  EXPECT_TRUE(std::signbit(to[3]));
}

}  // namespace
}  // namespace vesper::test
