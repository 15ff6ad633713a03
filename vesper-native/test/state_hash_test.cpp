// SPDX-License-Identifier: Apache-2.0
// Compares the state hash with XXH3-64 of the documented bytes.
#include <xxhash.h>

#include <cmath>
#include <cstring>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

void Append(std::vector<unsigned char>& bytes, const void* data, size_t size) {
  const size_t end = bytes.size();
  bytes.resize(end + size);
  std::memcpy(bytes.data() + end, data, size);
}

TEST(StateHashTest, IsXxh3OfStepCountAndColumnsInPrototypeOrder) {
  Bodies bodies(700);
  TestEngine engine;
  EXPECT_OK(engine.Add("velocity", bodies.velocity, 3));
  EXPECT_OK(engine.Add("position", bodies.position, 3));
  EXPECT_OK(engine.Advance(1, 5));
  const uint64_t steps = 5;
  std::vector<unsigned char> bytes;
  Append(bytes, &steps, sizeof steps);
  Append(bytes, bodies.position.data(), bodies.position.size() * sizeof(double));
  Append(bytes, bodies.velocity.data(), bodies.velocity.size() * sizeof(double));
  EXPECT_EQ(engine.StateHash(), XXH3_64bits(bytes.data(), bytes.size()));
}

TEST(StateHashTest, SharedValuesAreHashedAsRows) {
  std::vector<double> dense = {7, 5, 5}, shared = {5, 7};
  const std::vector<uint32_t> indices = {1, 0, 0};
  TestEngine first, second;
  EXPECT_OK(first.Add("mass", dense, 1));
  EXPECT_EQ(vesper_provider_add_physical_property(second.provider(), "mass", shared.data(), 2,
                                                  indices.data(), 3, nullptr),
            VESPER_OK);
  EXPECT_EQ(first.StateHash(), second.StateHash());
}

TEST(StateHashTest, NegativeZeroCountsAsZero) {
  std::vector<double> zero = {0, 1}, negative = {-0.0, 1};
  TestEngine first, second;
  EXPECT_OK(first.Add("mass", zero, 1));
  EXPECT_OK(second.Add("mass", negative, 1));
  EXPECT_EQ(first.StateHash(), second.StateHash());
}

TEST(StateHashTest, OneBitChangesTheHash) {
  std::vector<double> mass(1000, 1);
  TestEngine engine;
  EXPECT_OK(engine.Add("mass", mass, 1));
  const uint64_t before = engine.StateHash();
  mass[999] = std::nextafter(1.0, 2.0);
  EXPECT_NE(engine.StateHash(), before);
}

TEST(StateHashTest, CoversSinglePrecision) {
  std::vector<float> mass = {1, 2, 3};
  TestEngine engine({.prototype = "si-f32"});
  EXPECT_EQ(vesper_provider_add_physical_property(engine.provider(), "mass", mass.data(), 3,
                                                  nullptr, 3, nullptr),
            VESPER_OK);
  unsigned char bytes[8 + 12] = {};
  std::memcpy(bytes + 8, mass.data(), 12);
  EXPECT_EQ(engine.StateHash(), XXH3_64bits(bytes, sizeof bytes));
}

}  // namespace
}  // namespace vesper::test
