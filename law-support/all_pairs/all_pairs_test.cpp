// SPDX-License-Identifier: Apache-2.0
#include "all_pairs/all_pairs.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace vesper {
namespace {

/// Replacement of an engine step that runs ranges in reverse order, to reveal a dependence on it.
struct Backwards {
  template <class Body>
  void ParallelFor(uint64_t count, uint64_t grain, Body&& body) const {
    for (uint64_t range = (count + grain - 1) / grain; range-- > 0;) {
      body(range * grain, std::min((range + 1) * grain, count));
    }
  }
};
struct Forwards {
  template <class Body>
  void ParallelFor(uint64_t count, uint64_t grain, Body&& body) const {
    for (uint64_t begin = 0; begin < count; begin += grain) {
      body(begin, std::min(begin + grain, count));
    }
  }
};

/// Bodies in a cube; about one in ten has no weight, and some pairs coincide.
template <class Real>
struct Cloud {
  std::vector<Real> weight;
  std::vector<Vec3<Real>> position, force;

  explicit Cloud(uint64_t bodies, double size = 1, uint32_t seed = 7) : force(bodies) {
    std::mt19937 random(seed);
    const auto draw = [&](double low, double high) {
      return static_cast<Real>(low + (high - low) * (random() / 4294967296.0));
    };
    for (uint64_t i = 0; i < bodies; ++i) {
      weight.push_back(random() % 10 == 0 ? 0 : draw(-1, 3));
      position.push_back({draw(-size, size), draw(-size, size), draw(-size, size)});
      if (i % 50 == 49) position[i] = position[i / 2];
    }
  }

  template <class Step = Forwards>
  void Attract(InstructionSet set, double softening,
               ReciprocalRoot root = ReciprocalRoot::kPortable) {
    AllPairs<Real> pairs(set);
    pairs.Resize(weight.size());
    force.assign(weight.size(), {});
    pairs.Attract(Step{}, root, 2.5, softening, weight, position, force);
  }

  /// Returns the root mean square of the relative error, against sums in long double for every
  /// tenth body.
  double Error(double softening) const {
    using Wide = long double;
    double square = 0;
    int bodies = 0;
    for (uint64_t i = 0; i < weight.size(); i += 10) {
      if (weight[i] == 0) continue;
      Wide x = 0, y = 0, z = 0;
      for (uint64_t j = 0; j < weight.size(); ++j) {
        const Wide dx = Wide(position[j].x) - position[i].x;
        const Wide dy = Wide(position[j].y) - position[i].y;
        const Wide dz = Wide(position[j].z) - position[i].z;
        const Wide r2 = dx * dx + dy * dy + dz * dz + Wide(softening) * softening;
        if (r2 == 0) continue;
        const Wide pull = 2.5L * weight[i] * weight[j] / (r2 * std::sqrt(r2));
        x += pull * dx;
        y += pull * dy;
        z += pull * dz;
      }
      const Wide ex = x - force[i].x, ey = y - force[i].y, ez = z - force[i].z;
      square += static_cast<double>((ex * ex + ey * ey + ez * ez) / (x * x + y * y + z * z));
      ++bodies;
    }
    return std::sqrt(square / bodies);
  }
};

std::vector<InstructionSet> Sets() {
  using enum InstructionSet;
  std::vector<InstructionSet> sets;
  for (const auto set : {kBaseline, kAvx2, kAvx512}) {
    if (set <= BestInstructionSet()) sets.push_back(set);
  }
  return sets;
}

template <class T>
bool SameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

template <class Real>
class AllPairsTest : public ::testing::Test {};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(AllPairsTest, Precisions);

TYPED_TEST(AllPairsTest, EveryInstructionSetGivesTheSameBits) {
  for (const uint64_t bodies : {1, 2, 15, 16, 17, 300, 2100}) {
    for (const double softening : {0.0, 0.01}) {
      Cloud<TypeParam> baseline(bodies), other(bodies);
      baseline.Attract(InstructionSet::kBaseline, softening);
      for (const InstructionSet set : Sets()) {
        other.Attract(set, softening);
        EXPECT_TRUE(SameBits(other.force, baseline.force))
            << bodies << " bodies, instruction set " << static_cast<int>(set);
      }
    }
  }
}

TYPED_TEST(AllPairsTest, OrderOfTheSharesChangesNoBit) {
  for (const auto root : {ReciprocalRoot::kPortable, ReciprocalRoot::kApproximate}) {
    Cloud<TypeParam> a(5000), b(5000);
    a.Attract(BestInstructionSet(), 0, root);
    b.template Attract<Backwards>(BestInstructionSet(), 0, root);
    EXPECT_TRUE(SameBits(a.force, b.force)) << "root " << static_cast<int>(root);
  }
}

TYPED_TEST(AllPairsTest, ErrorIsThatOfRounding) {
  for (const uint64_t bodies : {17, 1000, 5000}) {
    for (const double softening : {0.0, 0.125}) {
      Cloud<TypeParam> cloud(bodies);
      cloud.Attract(BestInstructionSet(), softening);
      EXPECT_LT(cloud.Error(softening), sizeof(TypeParam) == 4 ? 1e-6 : 1e-14)
          << bodies << " bodies, softening " << softening;
    }
  }
}

TYPED_TEST(AllPairsTest, ErrorWithApproximateRootsIsThatOfRoundingToo) {
  for (const InstructionSet set : Sets()) {
    for (const double softening : {0.0, 0.125}) {
      Cloud<TypeParam> cloud(1000);
      cloud.Attract(set, softening, ReciprocalRoot::kApproximate);
      EXPECT_LT(cloud.Error(softening), sizeof(TypeParam) == 4 ? 1e-6 : 1e-14)
          << "instruction set " << static_cast<int>(set) << ", softening " << softening;
    }
  }
}

// r^3 of these lengths exceeds the range of float.
TYPED_TEST(AllPairsTest, LengthsNeedNotBeOfOrderOne) {
  for (const double size : {1e-14, 1e14}) {
    Cloud<TypeParam> cloud(300, size);
    cloud.Attract(BestInstructionSet(), size / 8);
    EXPECT_LT(cloud.Error(size / 8), sizeof(TypeParam) == 4 ? 1e-6 : 1e-14) << "size " << size;
  }
}

TYPED_TEST(AllPairsTest, OneMayBeFarHeavierThanTheOthers) {
  Cloud<TypeParam> cloud(300);
  for (uint64_t i = 1; i < 300; ++i) cloud.weight[i] *= TypeParam(1e-30);
  cloud.Attract(BestInstructionSet(), 0);
  EXPECT_LT(cloud.Error(0), sizeof(TypeParam) == 4 ? 1e-6 : 1e-14);
}

TYPED_TEST(AllPairsTest, OneMayBeFarAwayFromTheOthers) {
  Cloud<TypeParam> cloud(300, 1e-5);
  cloud.position[0] = {0, 0, 1};
  cloud.Attract(BestInstructionSet(), 0);
  EXPECT_LT(cloud.Error(0), sizeof(TypeParam) == 4 ? 1e-6 : 1e-14);
}

TYPED_TEST(AllPairsTest, PotentialsOfAllPairsAreCountedOnce) {
  const double softening = 0.25;
  const Cloud<TypeParam> cloud(301);
  double expected = 0;
  for (uint64_t i = 0; i < 301; ++i) {
    for (uint64_t j = 0; j < i; ++j) {
      const Vec3<TypeParam> a = cloud.position[i], b = cloud.position[j];
      const double dx = double{a.x} - b.x, dy = double{a.y} - b.y, dz = double{a.z} - b.z;
      expected += double{cloud.weight[i]} * cloud.weight[j] /
                  std::sqrt(dx * dx + dy * dy + dz * dz + softening * softening);
    }
  }
  for (const InstructionSet set : Sets()) {
    const double sum =
        AllPairs<TypeParam>(set).SumOfPotentials(softening, cloud.weight, cloud.position);
    EXPECT_NEAR(sum, expected, 1e-13 * expected);
    EXPECT_EQ(sum, AllPairs<TypeParam>(InstructionSet::kBaseline)
                       .SumOfPotentials(softening, cloud.weight, cloud.position));
  }
}

}  // namespace
}  // namespace vesper
