// SPDX-License-Identifier: Apache-2.0
// Fast ways of the law beside simple ones: contacts in lanes, the search for pairs, and the axes of
// boxes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

#include "batches.hpp"
#include "broad_phase.hpp"
#include "manifold.hpp"
#include "scene.hpp"

namespace vesper::rigid {
namespace {

class Numbers {
 public:
  explicit Numbers(uint32_t seed) : random_(seed) {}

  double Draw(double low, double high) { return low + (high - low) * random_() / 4294967296.0; }
  uint32_t Below(uint32_t count) { return random_() % count; }
  template <class Real>
  Vec3<Real> Vector3(double size) {
    return {Real(Draw(-size, size)), Real(Draw(-size, size)), Real(Draw(-size, size))};
  }
  Quaternion Turn() { return Quaternion{Vector3<double>(1), Draw(-1, 1)}.Normalised(); }

 private:
  std::mt19937 random_;
};

template <class Real>
class RigidBatchTest : public ::testing::Test {};
TYPED_TEST_SUITE(RigidBatchTest, Precisions);

template <class Real>
Motion<Real> DrawMotion(Numbers& numbers) {
  Motion<Real> motion;
  motion.velocity = numbers.Vector3<Real>(3);
  motion.spin = numbers.Vector3<Real>(5);
  motion.moved = numbers.Vector3<Real>(0.01);
  motion.turned = numbers.Vector3<Real>(0.02);
  motion.inverse_mass = Real(numbers.Draw(0, 2));
  motion.inverse_inertia = {Real(numbers.Draw(1, 3)),      Real(numbers.Draw(1, 3)),
                            Real(numbers.Draw(1, 3)),      Real(numbers.Draw(-0.4, 0.4)),
                            Real(numbers.Draw(-0.4, 0.4)), Real(numbers.Draw(-0.4, 0.4))};
  return motion;
}

template <class Real>
Contact<Real> DrawContact(Numbers& numbers, uint32_t a, uint32_t b, int count) {
  Contact<Real> contact{};
  contact.a = a;
  contact.b = b;
  contact.normal = Narrow<Real>(numbers.Turn().Rotate({1, 0, 0}));
  contact.friction = Real(numbers.Below(4) == 0 ? 0 : numbers.Draw(0, 1));
  contact.count = count;
  for (int i = 0; i < count; ++i) {
    auto& point = contact.points[i];
    point.arm_a = numbers.Vector3<Real>(1);
    point.arm_b = numbers.Vector3<Real>(1);
    point.separation = Real(numbers.Draw(-0.02, 0.02));
    point.press = Real(std::max(0.0, numbers.Draw(-0.3, 1)));
    for (Real& rub : point.rub) rub = Real(numbers.Draw(-0.2, 0.2)) * point.press;
  }
  contact.FindDirections();
  return contact;
}

/// Returns whether two lists of motions have the same bits in velocity and spin.
template <class Real>
bool AreEqual(const std::vector<Motion<Real>>& one, const std::vector<Motion<Real>>& other) {
  for (size_t i = 0; i < one.size(); ++i) {
    if (std::memcmp(&one[i].velocity, &other[i].velocity, sizeof one[i].velocity) != 0)
      return false;
    if (std::memcmp(&one[i].spin, &other[i].spin, sizeof one[i].spin) != 0) return false;
  }
  return true;
}

/// Corrects contacts one by one, as a batch does.
template <class Real, class Action>
void ForEachSingly(std::vector<Contact<Real>>& contacts, std::vector<Motion<Real>>& motions,
                   Action&& action) {
  for (Contact<Real>& contact : contacts) {
    Motion<Real> still_a, still_b;
    action(contact, contact.a == kImmovable ? still_a : motions[contact.a],
           contact.b == kImmovable ? still_b : motions[contact.b]);
  }
}

TYPED_TEST(RigidBatchTest, BatchHasTheBitsOfSingleContacts) {
  using Real = TypeParam;
  constexpr int kLanes = Batch<Real>::kCount;
  Numbers numbers(7);
  const auto step = SolverStep<Real>::Of(Real(1.0 / 60), 4, 3, Real(0.5));
  for (int round = 0; round < 400; ++round) {
    const int count = 1 + round % 4, used = 1 + int(numbers.Below(kLanes));
    std::vector<Motion<Real>> motions;
    std::vector<Contact<Real>> contacts;
    std::vector<uint32_t> lanes;
    for (int lane = 0; lane < used; ++lane) {
      for (int k = 0; k < 2; ++k) motions.push_back(DrawMotion<Real>(numbers));
      const uint32_t kind = numbers.Below(4);
      const auto row = uint32_t(2 * lane);
      contacts.push_back(DrawContact<Real>(numbers, kind == 0 ? kImmovable : row,
                                           kind == 1 ? kImmovable : row + 1, count));
      lanes.push_back(uint32_t(lane));
    }
    auto singles = contacts;
    auto moving = motions;
    Batch<Real> batch;
    batch.Choose(lanes);
    batch.Load(contacts, motions);
    const auto find_masses = [](auto& contact, auto& a, auto& b) { contact.FindMasses(a, b); };
    ForEachSingly(singles, moving, find_masses);
    batch.WarmStart(motions);
    ForEachSingly(singles, moving,
                  [](auto& contact, auto& a, auto& b) { contact.WarmStart(a, b); });
    ASSERT_TRUE(AreEqual(motions, moving)) << round;
    for (int k = 0; k < 6; ++k) {
      if (k == 3) {  // the inertia of some bodies has changed
        for (size_t i = 0; i < motions.size(); i += 3) {
          motions[i].inverse_inertia.xy = moving[i].inverse_inertia.xy = Real(0.2);
        }
        batch.Renew(
            contacts, motions, [](uint32_t body) { return body != kImmovable && body % 3 == 0; },
            [&](uint32_t i) {
              const Motion<Real> still;
              contacts[i].FindMasses(contacts[i].a == kImmovable ? still : motions[contacts[i].a],
                                     contacts[i].b == kImmovable ? still : motions[contacts[i].b]);
            });
        ForEachSingly(singles, moving, find_masses);
      }
      batch.Solve(motions, step, k % 2 == 0);
      ForEachSingly(singles, moving, [&](auto& contact, auto& a, auto& b) {
        contact.Solve(a, b, step, k % 2 == 0);
      });
      ASSERT_TRUE(AreEqual(motions, moving)) << "round " << round << ", correction " << k;
    }
    batch.Store(contacts);
    for (int lane = 0; lane < used; ++lane) {
      for (int i = 0; i < count; ++i) {
        const auto &one = contacts[size_t(lane)].points[i],
                   &other = singles[size_t(lane)].points[i];
        ASSERT_EQ(one.press, other.press) << round;
        ASSERT_EQ(one.rub[0], other.rub[0]) << round;
        ASSERT_EQ(one.rub[1], other.rub[1]) << round;
      }
    }
  }
}

TYPED_TEST(RigidBatchTest, EachContactIsInOneBatchOrSingle) {
  using Real = TypeParam;
  Numbers numbers(3);
  std::vector<Contact<Real>> contacts;
  for (int i = 0; i < 700; ++i) {
    const uint32_t a = numbers.Below(60), b = a + 1 + numbers.Below(20);
    contacts.push_back(DrawContact<Real>(numbers, a, numbers.Below(5) == 0 ? kImmovable : b,
                                         1 + int(numbers.Below(4))));
    if (i % 10 == 0) contacts.back().restitution = Real(0.5);
    if (i % 10 == 1) contacts.back().rolling = Real(0.01);
    if (i % 10 == 2) contacts.back().spinning = Real(0.01);
    for (auto& point : contacts.back().points) point.press = Real(i);
  }
  Colours colours;
  colours.Choose(contacts, 80);
  Batches<Real> batches;
  std::vector<Motion<Real>> motions(80);
  for (auto& motion : motions) motion = DrawMotion<Real>(numbers);
  for (int round = 0; round < 2; ++round) {  // an object keeps its memory
    batches.Choose(contacts, colours);
    std::vector<int> found(contacts.size());
    for (const uint32_t i : batches.singles()) ++found[i];
    EXPECT_GE(batches.singles().size(), 210u);
    auto stored = contacts;
    for (auto& contact : stored) {
      for (auto& point : contact.points) point.press = -1;
    }
    for (auto& batch : batches.all()) {
      batch.Load(contacts, motions);
      batch.Store(stored);
    }
    for (size_t i = 0; i < contacts.size(); ++i) {
      found[i] += stored[i].points[0].press == Real(i);
      EXPECT_EQ(found[i], 1) << i;
    }
    uint32_t in_colours = 0;
    for (uint32_t colour = 0; colour < Colours::kMost; ++colour) {
      in_colours += uint32_t(batches.Of(colour).size());
      if (colour < Colours::kMost - 1) continue;
      EXPECT_TRUE(batches.Of(colour).empty());
    }
    EXPECT_EQ(in_colours, batches.all().size());
  }
}

TEST(RigidPairsTest, BroadPhaseFindsThePairsOfAllComparisons) {
  Numbers numbers(5);
  BroadPhase search;
  for (int round = 0; round < 60; ++round) {
    // Places far from the origin have large rounding errors in single precision.
    const Vector centre = numbers.Vector3<double>(round % 3 == 0 ? 1e7 : 10);
    std::vector<Bounds> boxes;
    for (int i = 0; i < 150; ++i) {
      const Vector low = centre + numbers.Vector3<double>(5);
      Vector extent{numbers.Draw(0, 1), numbers.Draw(0, 1), numbers.Draw(0, 1)};
      if (i % 40 == 0) extent = {1000, 1, 1000};
      boxes.push_back({low, low + extent, numbers.Below(4) != 0});
      if (i % 7 == 0) boxes.back().low.y = i > 0 ? boxes[size_t(i) - 1].high.y : low.y;  // touches
      if (i % 31 == 0)
        boxes.back() = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, false};
      if (i == 77) boxes.back() = {{-1e90, -1e90, -1e90}, {1e90, 1e90, 1e90}, true};
    }
    std::vector<std::pair<uint32_t, uint32_t>> expected, found;
    for (uint32_t a = 0; a < boxes.size(); ++a) {
      for (uint32_t b = a + 1; b < boxes.size(); ++b) {
        if ((boxes[a].movable || boxes[b].movable) && boxes[a].Overlaps(boxes[b])) {
          expected.emplace_back(a, b);
        }
      }
    }
    for (const Pair& pair : search.Find(boxes)) found.emplace_back(pair.a, pair.b);
    ASSERT_EQ(found, expected) << round;
    ASSERT_GT(found.size(), 50u);
  }
}

/// The directions along which two boxes may be separated best, and the distance there [m].
struct Separation {
  double of_faces = -HUGE_VAL, of_all = -HUGE_VAL;

  Separation(const Shape& a, const Shape& b) {
    const auto along = [&](const Vector& axis) {
      return std::abs(Dot(b.position - a.position, axis)) - a.Reach(axis) - b.Reach(axis);
    };
    for (int i = 0; i < 3; ++i) {
      of_faces = std::max({of_faces, along(a.axes[i]), along(b.axes[i])});
    }
    of_all = of_faces;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Vector axis = Cross(a.axes[i], b.axes[j]);
        const double length = Length(axis);
        if (length > 2e-3) of_all = std::max(of_all, along(axis * (1 / length)));
      }
    }
  }
};

// Boxes touch if no axis separates them by more than the margin. The contact normal is the best
// axis, except that edges must be better than faces by a slack.
TEST(RigidPairsTest, BoxesTouchAlongTheBestOfAllAxes) {
  Numbers numbers(9);
  int edges = 0, faces = 0, apart = 0;
  for (int round = 0; round < 20000; ++round) {
    const auto box = [&](const Vector& at) {
      const Vector size{numbers.Draw(0.3, 2), numbers.Draw(0.3, 2), numbers.Draw(0.3, 2)};
      return Shape::Of(int32_t(ShapeCode::kBox), size, at, numbers.Turn());
    };
    const Shape a = box({0, 0, 0}), b = box(numbers.Vector3<double>(1.2));
    const double margin = numbers.Draw(0, 0.1);
    const Separation best(a, b);
    const Manifold manifold = Collide(a, b, margin);
    if (best.of_all > margin - 1e-5) {  // the law neglects differences of axes below 1e-5 m
      ASSERT_TRUE(manifold.count == 0 || best.of_all < margin + 1e-5) << round;
      ++apart;
      continue;
    }
    const double slack = 0.02 * std::min(a.Thickness(), b.Thickness());
    const double found = Dot(b.position - a.position, manifold.normal) - a.Reach(manifold.normal) -
                         b.Reach(manifold.normal);
    const double bound = best.of_faces < 0 ? 0.95 * best.of_faces + slack : best.of_faces + slack;
    if (best.of_all > bound + 1e-9) {
      ASSERT_NEAR(found, best.of_all, 1e-9) << round;
      ++edges;
    } else if (best.of_all < bound - 1e-9) {
      ASSERT_NEAR(found, best.of_faces, 1e-3 * slack + 1e-9) << round;
      ++faces;
    }
  }
  EXPECT_GT(edges, 100);
  EXPECT_GT(faces, 1000);
  EXPECT_GT(apart, 1000);
}

}  // namespace
}  // namespace vesper::rigid
