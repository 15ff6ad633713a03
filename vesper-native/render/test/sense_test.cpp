// SPDX-License-Identifier: Apache-2.0
// Tests item and depth of each pixel, against closed forms and a separate ray caster.
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "picture.hpp"

namespace vesper::render::test {
namespace {

using Eigen::Vector3f;

constexpr uint32_t kWidth = 400, kHeight = 300;

class SenseTest : public PictureTest {};

uint32_t Count(const Seen& seen, uint32_t item) {
  return static_cast<uint32_t>(std::count(seen.item.begin(), seen.item.end(), item));
}

TEST_F(SenseTest, ABallOnTheAxisIsADiscOfItsAngularSizeAsDeepAsItsSurface) {
  const float fov = 0.8F, distance = 5, radius = 0.7F;
  const Seen seen = Sense(
      {Perspective({0, 0, distance}, {0, 0, 0}, fov),
       Instances(
           1, {Item{{0, 0, 0}, {2 * radius, 2 * radius, 2 * radius}, kRed, 0, {0, 0, 0, 1}, 77}})});
  ASSERT_EQ(seen.width, kWidth);
  ASSERT_EQ(seen.height, kHeight);
  const float angle = std::asin(radius / distance);
  const float disc = std::tan(angle) / std::tan(fov / 2) * kHeight / 2;
  EXPECT_NEAR(std::sqrt(Count(seen, 77) / M_PI), disc, 0.4);
  EXPECT_EQ(Count(seen, 77) + Count(seen, 0), kWidth * kHeight);
  const size_t middle = size_t{kHeight / 2} * kWidth + kWidth / 2;
  EXPECT_NEAR(seen.depth[middle], distance - radius, 2e-3);
  EXPECT_EQ(seen.depth[0], 0);
}

TEST_F(SenseTest, DepthIsAlongTheViewAndNotAlongTheRay) {
  const Item wall{{0, 0, -1}, {100, 100, 1}, kRed, 0, {0, 0, 0, 1}, 1};
  const Seen seen = Sense({Perspective({0, 0, 5}, {0, 0, 0}, 1.0F), Instances(2, {wall})});
  for (const float depth : seen.depth) ASSERT_NEAR(depth, 5.5F, 1e-4F);
}

TEST_F(SenseTest, LinesAndLooseTrianglesAreItemsToo) {
  const Seen seen = Sense(
      {Perspective({0, 0, 5}, {0, 0, 0}, 0.8F), Segments({{{-2, 1, 0}, {2, 1, 0}, kWhite, 5}}, 3),
       Triangles({{{Vec3{-1, -1, 0}, Vec3{1, -1, 0}, Vec3{0, 0, 0}}, {kRed, kRed, kRed}, 6}})});
  EXPECT_NEAR(Count(seen, 5), 3 * kWidth, kWidth);
  const double pixels_per_metre = kHeight / (2 * 5 * std::tan(0.4));
  EXPECT_NEAR(Count(seen, 6), pixels_per_metre * pixels_per_metre, 100);
}

struct Box {
  Vector3f centre, half;
  Eigen::Quaternionf turn;
};

/// Returns the distance along a ray to a box, in lengths of its direction; negative if the ray
/// misses.
float Hit(const Box& box, const Vector3f& from, const Vector3f& direction) {
  const Vector3f at = box.turn.conjugate() * (from - box.centre);
  const Vector3f along = box.turn.conjugate() * direction;
  float in = -1e30F, out = 1e30F;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = (-box.half[axis] - at[axis]) / along[axis];
    const float b = (box.half[axis] - at[axis]) / along[axis];
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  return in <= out ? in : -1;
}

TEST_F(SenseTest, RandomBoxesAreSeenWhereRaysHitThem) {
  const unsigned seed = 20261121;
  std::mt19937 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int scene = 0; scene < 8; ++scene) {
    std::vector<Box> boxes;
    std::vector<Item> items;
    for (uint32_t i = 0; i < 15; ++i) {
      const Vector3f centre(3 * unit(random), 2 * unit(random), 2 * unit(random));
      const Vector3f half(0.35F + 0.3F * unit(random), 0.35F + 0.3F * unit(random), 0.5F);
      const Eigen::Quaternionf turn =
          Eigen::Quaternionf(unit(random), unit(random), unit(random), unit(random)).normalized();
      boxes.push_back({centre, half, turn});
      items.push_back({{centre.x(), centre.y(), centre.z()},
                       {2 * half.x(), 2 * half.y(), 2 * half.z()},
                       kRed,
                       0,
                       {turn.x(), turn.y(), turn.z(), turn.w()},
                       i + 1});
    }
    const float fov = 0.9F;
    const Vector3f eye(0, 0, 8);
    const Seen seen = Sense({Perspective({0, 0, 8}, {0, 0, 0}, fov), Instances(2, items)});
    std::vector<uint32_t> item(seen.item.size());
    std::vector<float> depth(seen.item.size());
    for (uint32_t y = 0; y < kHeight; ++y) {
      for (uint32_t x = 0; x < kWidth; ++x) {
        const float step = 2 * std::tan(fov / 2) / kHeight;
        const Vector3f ray((x + 0.5F - kWidth / 2.0F) * step, (y + 0.5F - kHeight / 2.0F) * step,
                           -1);
        float nearest = 1e30F;
        const size_t at = size_t{y} * kWidth + x;
        for (uint32_t i = 0; i < boxes.size(); ++i) {
          const float hit = Hit(boxes[i], eye, ray);
          if (hit > 0 && hit < nearest) {
            nearest = hit;
            item[at] = i + 1;
            depth[at] = hit;
          }
        }
      }
    }
    int compared = 0;
    for (uint32_t y = 1; y + 1 < kHeight; ++y) {
      for (uint32_t x = 1; x + 1 < kWidth; ++x) {
        const size_t at = size_t{y} * kWidth + x;
        bool edge = false;  // near an edge, rounding decides
        for (const int to : {-1, 1, -static_cast<int>(kWidth), static_cast<int>(kWidth)}) {
          edge |= item[at + to] != item[at];
        }
        if (edge) continue;
        ++compared;
        ASSERT_EQ(seen.item[at], item[at]) << "scene " << scene << " at " << x << ", " << y;
        ASSERT_NEAR(seen.depth[at], depth[at], 1e-3F * (1 + depth[at]));
      }
    }
    EXPECT_GT(compared, 100'000);
  }
}

TEST_F(SenseTest, TheSameSceneIsSensedTheSameAfterOthers) {
  const auto scene = [] {
    const Item item{{0, 0, 0}, {1, 1, 1}, kRed, 0, {0, 0, 0, 1}, 9};
    return std::vector<Message>{Perspective({3, 2, 5}, {0, 0, 0}, 0.6F), Instances(1, {item})};
  };
  const Seen before = Sense(scene());
  Draw({Perspective({0, 0, 5}, {0, 0, 0}, 1.0F), Instances(2, {Item{}})});
  const Seen after = Sense(scene());
  EXPECT_EQ(before.item, after.item);
  EXPECT_EQ(before.depth, after.depth);
}

}  // namespace
}  // namespace vesper::render::test
