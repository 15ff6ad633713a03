// SPDX-License-Identifier: Apache-2.0
#include "interactions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace vesper::barnes_hut {
namespace {

using Precisions = ::testing::Types<float, double>;

template <class Real>
class InteractionsTest : public ::testing::Test {
 protected:
  static constexpr uint32_t kSeed = 11;

  Vec3<Real> Point(double size) {
    std::uniform_real_distribution<double> draw(-size, size);
    return {Real(draw(random_)), Real(draw(random_)), Real(draw(random_))};
  }

  Targets<Real> RandomTargets(double size) {
    Targets<Real> targets{};
    for (uint32_t i = 0; i < kGroup; ++i) {
      const Vec3<Real> p = Point(size);
      targets.x[i] = p.x;
      targets.y[i] = p.y;
      targets.z[i] = p.z;
    }
    return targets;
  }

  std::vector<Source<Real>> RandomSources(uint32_t count, Vec3<Real> centre, double size) {
    std::uniform_real_distribution<double> draw(0.1, 1);
    std::vector<Source<Real>> sources;
    for (uint32_t i = 0; i < count; ++i) {
      sources.push_back({centre + Point(size), Real(draw(random_))});
    }
    return sources;
  }

  /// Returns mass, centre and spread, computed from their definitions.
  static Multipole<Real> Whole(const std::vector<Source<Real>>& sources) {
    double mass = 0;
    Vec3<double> centre;
    for (const auto& s : sources) {
      mass += double{s.mass};
      centre += double{s.mass} * Wide(s.position);
    }
    centre = centre * (1 / mass);
    double spread[3][3] = {};
    for (const auto& s : sources) {
      const Vec3<double> d = Wide(s.position) - centre;
      const double x[] = {d.x, d.y, d.z};
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) spread[i][j] += 3 * double{s.mass} / mass * x[i] * x[j];
      }
    }
    return {{Real(centre.x), Real(centre.y), Real(centre.z)},
            Real(mass),
            Real(spread[0][0]),
            Real(spread[0][1]),
            Real(spread[0][2]),
            Real(spread[1][1]),
            Real(spread[1][2]),
            Real(spread[2][2]),
            Real(spread[0][0] + spread[1][1] + spread[2][2])};
  }

  /// Returns the softened sum over all sources at one target, in double.
  static Vec3<double> Direct(const Targets<Real>& targets, uint32_t i,
                             const std::vector<Source<Real>>& sources, double softening2) {
    Vec3<double> sum;
    for (const auto& s : sources) {
      const Vec3<double> d{double{s.position.x} - double{targets.x[i]},
                           double{s.position.y} - double{targets.y[i]},
                           double{s.position.z} - double{targets.z[i]}};
      sum += d * (double{s.mass} * std::pow(Dot(d, d) + softening2, -1.5));
    }
    return sum;
  }

  static Vec3<double> Wide(Vec3<Real> v) { return {double{v.x}, double{v.y}, double{v.z}}; }
  static Vec3<double> Sum(const Targets<Real>& targets, uint32_t i) {
    return Wide({targets.ax[i], targets.ay[i], targets.az[i]});
  }

  std::mt19937_64 random_{kSeed};
};
TYPED_TEST_SUITE(InteractionsTest, Precisions);

TYPED_TEST(InteractionsTest, BodiesAddUpToTheSumByDefinition) {
  const auto sources = this->RandomSources(300, {}, 1);
  const Run runs[] = {{0, 100}, {100, 1}, {101, 199}};
  for (const auto& simd : AvailableInteractions<TypeParam>()) {
    Targets<TypeParam> targets = this->RandomTargets(1);
    simd.add_bodies(targets, sources.data(), runs, 3, TypeParam(0.01));
    for (uint32_t i = 0; i < kGroup; ++i) {
      const Vec3<double> exact = this->Direct(targets, i, sources, 0.01);
      EXPECT_LT(Length(this->Sum(targets, i) - exact),
                1000 * std::numeric_limits<TypeParam>::epsilon())
          << simd.instruction_set << ", target " << i << ", seed " << this->kSeed;
    }
  }
}

TYPED_TEST(InteractionsTest, EveryInstructionSetGivesTheSameBits) {
  const auto sources = this->RandomSources(257, {}, 1);
  std::vector<Multipole<TypeParam>> cells;
  std::vector<uint32_t> list;
  for (uint32_t i = 0; i < 64; ++i) {
    cells.push_back(this->Whole(this->RandomSources(5, this->Point(10), 0.5)));
    list.push_back(i);
  }
  const Run run{0, 257};
  const Targets<TypeParam> start = this->RandomTargets(1);
  const auto sum = [&](const Interactions<TypeParam>& simd) {
    Targets<TypeParam> targets = start;
    simd.add_bodies(targets, sources.data(), &run, 1, TypeParam(1e-4));
    simd.add_cells(targets, cells.data(), list.data(), 64, TypeParam(1e-4));
    return targets;
  };
  const auto available = AvailableInteractions<TypeParam>();
  const Targets<TypeParam> first = sum(available.front());
  for (const auto& simd : available) {
    const Targets<TypeParam> other = sum(simd);
    EXPECT_EQ(std::memcmp(&first, &other, sizeof first), 0)
        << simd.instruction_set << " and " << available.front().instruction_set << ", seed "
        << this->kSeed;
  }
}

TYPED_TEST(InteractionsTest, ABodyOnTopOfATargetPullsWithNothing) {
  Targets<TypeParam> targets{};
  const Source<TypeParam> source{{}, 1};
  const Run run{0, 1};
  AvailableInteractions<TypeParam>().front().add_bodies(targets, &source, &run, 1,
                                                        kLeastSoftening2<TypeParam>);
  for (uint32_t i = 0; i < kGroup; ++i) EXPECT_EQ(Length(this->Sum(targets, i)), 0);
}

using CellTest = InteractionsTest<double>;

// The first neglected term is of third order. Half the size therefore gives an eighth of the error.
TEST_F(CellTest, ErrorOfACellFallsWithTheCubeOfItsSize) {
  const auto sources = RandomSources(20, {}, 1);
  const auto error = [&](double size, double softening2) {
    std::vector<Source<double>> small = sources;
    for (auto& s : small) s.position = s.position * size + Vec3<double>{4, 3, -2};
    const Multipole<double> cell = Whole(small);
    Targets<double> targets{};
    const uint32_t list = 0;
    AvailableInteractions<double>().front().add_cells(targets, &cell, &list, 1, softening2);
    return Length(Sum(targets, 0) - Direct(targets, 0, small, softening2));
  };
  for (const double softening2 : {1e-12, 1.0}) {
    EXPECT_NEAR(error(0.02, softening2) / error(0.01, softening2), 8, 0.3)
        << "softening2 " << softening2 << ", seed " << kSeed;
  }
}

}  // namespace
}  // namespace vesper::barnes_hut
