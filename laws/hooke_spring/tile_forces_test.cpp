// SPDX-License-Identifier: Apache-2.0
#include "tile_forces.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace vesper::hooke_spring {
namespace {

constexpr uint32_t kSeed = 31;

/// Springs between random bodies. A fifth of the springs connect a body with itself, or two bodies
/// at one place.
template <class Real>
struct Network {
  explicit Network(uint32_t bodies, uint32_t springs, bool in_order) {
    std::mt19937 random(kSeed);
    const auto draw = [&](double low, double high) {
      return static_cast<Real>(low + (high - low) * random() / 4294967296.0);
    };
    for (uint32_t i = 0; i < bodies; ++i) {
      position.push_back({draw(-9, 9), draw(-9, 9), draw(-9, 9)});
      velocity.push_back({draw(-1, 1), draw(-1, 1), draw(-1, 1)});
      if (i % 5 == 4) position[i] = position[i - 1];
    }
    for (uint32_t s = 0; s < springs; ++s) {
      const auto a =
          static_cast<uint32_t>(in_order ? uint64_t{s} * bodies / springs : random() % bodies);
      endpoints.push_back({a, s % 10 == 0 ? (a + a % 2) % bodies : uint32_t(random() % bodies)});
      length.push_back(draw(0.1, 5));
      hooke.push_back(draw(1, 100));
      damping.push_back(draw(0, 2));
    }
    tiles.Build(endpoints, bodies);
  }

  /// Returns the forces as the law computes them.
  std::vector<Vec3<Real>> Forces(const TileForces<Real>& compiled, bool damped) const {
    std::vector<Vec3<Real>> sums(position.size());
    std::vector<Motion<Real>> motions(tiles.most_bodies());
    std::vector<hooke_spring::Forces<Real>> forces(tiles.most_slots() / kBatch);
    for (const Tile& tile : tiles.tiles()) {
      compiled.take(position.data(), velocity.data(), position.size(), nullptr, tile.first_body,
                    tile.body_count, motions.data());
      for (uint64_t i = 0; i < tile.part_count; ++i) {
        const Part& part = tiles.parts()[tile.first_part + i];
        compiled.take(position.data(), velocity.data(), position.size(),
                      tiles.others().data() + part.first_other, 0, part.other_count,
                      motions.data() + tile.body_count);
        compiled.pull(SpringsOf(part, damped), motions.data(), forces.data());
        compiled.sum(forces.data(), tiles.pulls().data() + part.first_pull,
                     tiles.pull_counts().data() + part.first_count, tile.body_count,
                     &sums[tile.first_body]);
      }
    }
    return sums;
  }

  TileSprings<Real> SpringsOf(const Part& part, bool damped) const {
    TileSprings<Real> springs{};
    springs.count = part.slot_count;
    springs.first_ends = tiles.first_ends().data() + part.first_slot;
    springs.second_ends = tiles.second_ends().data() + part.first_slot;
    springs.rows = tiles.rows().data() + part.first_slot;
    springs.first_rows = tiles.first_rows().data() + part.first_slot / kBatch;
    springs.length = length.data();
    springs.hooke = hooke.data();
    if (damped) springs.damping = damping.data();
    return springs;
  }

  /// Returns the forces by the equation, for each spring in double.
  std::vector<Vec3<double>> Expected(bool damped) const {
    std::vector<Vec3<double>> sums(position.size());
    for (uint64_t s = 0; s < endpoints.size(); ++s) {
      const auto [a, b] = endpoints[s];
      const Vec3<double> axis = Wide(position[b]) - Wide(position[a]);
      const double distance = Length(axis);
      if (distance == 0) continue;
      const Vec3<double> direction = axis * (1 / distance);
      double pull = double{hooke[s]} * (distance - double{length[s]});
      const Vec3<double> parting = Wide(velocity[b]) - Wide(velocity[a]);
      if (damped) pull += double{damping[s]} * Dot(parting, direction);
      sums[a] += direction * pull;
      sums[b] -= direction * pull;
    }
    return sums;
  }

  static Vec3<double> Wide(Vec3<Real> v) { return {double{v.x}, double{v.y}, double{v.z}}; }

  std::vector<Vec3<Real>> position, velocity;
  std::vector<Ends> endpoints;
  std::vector<Real> length, hooke, damping;
  SpringTiles tiles;
};

template <class Real>
class TileForcesTest : public ::testing::Test {};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(TileForcesTest, Precisions);

TYPED_TEST(TileForcesTest, SumsAreThoseOfTheEquation) {
  for (const bool in_order : {true, false}) {
    const Network<TypeParam> network(9000, 50000, in_order);
    for (const auto& compiled : AvailableTileForces<TypeParam>()) {
      for (const bool damped : {true, false}) {
        const auto sums = network.Forces(compiled, damped);
        const auto expected = network.Expected(damped);
        for (uint32_t i = 0; i < sums.size(); ++i) {
          ASSERT_LT(Length(Network<TypeParam>::Wide(sums[i]) - expected[i]),
                    1e5 * std::numeric_limits<TypeParam>::epsilon())
              << compiled.instruction_set << ", body " << i << ", in order " << in_order
              << ", seed " << kSeed;
        }
      }
    }
  }
}

TYPED_TEST(TileForcesTest, EveryInstructionSetGivesTheSameBits) {
  for (const bool in_order : {true, false}) {
    const Network<TypeParam> network(9000, 50000, in_order);
    const auto available = AvailableTileForces<TypeParam>();
    for (const bool damped : {true, false}) {
      const auto first = network.Forces(available.front(), damped);
      for (const auto& compiled : available) {
        EXPECT_EQ(network.Forces(compiled, damped), first)
            << compiled.instruction_set << " and " << available.front().instruction_set << ", seed "
            << kSeed;
      }
    }
  }
}

TEST(SpringTilesTest, EachBodyIsOfOneTileThatHasAllItsSprings) {
  for (const uint32_t bodies : {1u, 2u, 5000u, 9000u, 20000u}) {
    const Network<float> network(bodies, 4 * bodies, false);
    std::vector<std::multiset<uint32_t>> of_body(bodies), found(bodies);
    for (uint32_t s = 0; s < network.endpoints.size(); ++s) {
      for (const uint32_t body : network.endpoints[s]) of_body[body].insert(s);
    }
    uint64_t next = 0;
    const SpringTiles& tiles = network.tiles;
    for (const Tile& tile : tiles.tiles()) {
      ASSERT_EQ(tile.first_body, next);
      next += tile.body_count;
      for (uint64_t i = 0; i < tile.part_count; ++i) {
        const Part& part = tiles.parts()[tile.first_part + i];
        const uint16_t* pull = tiles.pulls().data() + part.first_pull;
        for (uint64_t list = 0; list < 2 * uint64_t{tile.body_count}; ++list) {
          for (uint32_t n = tiles.pull_counts()[part.first_count + list]; n > 0; --n) {
            found[tile.first_body + list / 2].insert(tiles.rows()[part.first_slot + *pull++]);
          }
        }
      }
    }
    EXPECT_EQ(next, bodies);
    EXPECT_EQ(found, of_body) << bodies << " bodies, seed " << kSeed;
  }
}

// The test includes more springs than 16 bits can count, for which the tile has several parts.
TEST(SpringTilesTest, ABodyThatHoldsManySpringsFeelsThemAll) {
  for (const uint32_t springs : {30000u, 200000u}) {
    Network<double> star(9000, springs, true);
    for (Ends& ends : star.endpoints) ends[1] = 7000;
    star.tiles.Build(star.endpoints, star.position.size());
    EXPECT_EQ(star.tiles.parts().size() > star.tiles.tiles().size(), springs > kMost);
    const auto expected = star.Expected(true);
    for (const auto& compiled : AvailableTileForces<double>()) {
      const auto sums = star.Forces(compiled, true);
      for (uint32_t i = 0; i < sums.size(); ++i) {
        ASSERT_LT(Length(Network<double>::Wide(sums[i]) - expected[i]),
                  1e-2)  // for springs with forces of some hundred N each
            << compiled.instruction_set << ", body " << i << ", seed " << kSeed;
      }
    }
  }
}

// The tile of this test is connected with many bodies of other tiles.
TEST(SpringTilesTest, ABodyHeldFromEverywhereFeelsAll) {
  Network<double> star(150000, 150000, true);
  for (uint32_t i = 0; i < star.endpoints.size(); ++i) star.endpoints[i] = {i, 70000};
  star.tiles.Build(star.endpoints, star.position.size());
  EXPECT_GT(star.tiles.parts().size(), star.tiles.tiles().size());
  EXPECT_LE(star.tiles.most_bodies(), kMost);
  const Vec3<double> sum = star.Forces(AvailableTileForces<double>().front(), true)[70000];
  EXPECT_LT(Length(Network<double>::Wide(sum) - star.Expected(true)[70000]),
            1e-2)  // for springs with forces of some hundred N each
      << "seed " << kSeed;
}

TEST(SpringTilesTest, SpringsInOrderAreReadAsTheyAreAndOthersSorted) {
  EXPECT_TRUE(Network<float>(3000, 9000, true).tiles.in_row_order());
  EXPECT_FALSE(Network<float>(3000, 9000, false).tiles.in_row_order());
}

TEST(SpringTilesTest, NoBodiesAreNoTiles) {
  SpringTiles tiles;
  tiles.Build({}, 0);
  EXPECT_TRUE(tiles.tiles().empty());
}

}  // namespace
}  // namespace vesper::hooke_spring
