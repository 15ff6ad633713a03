// SPDX-License-Identifier: Apache-2.0
#include "view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "draw_list.hpp"

namespace vesper::render {
namespace {

View WideView(float near_ball_depth) {
  const Camera camera{false, {0, 0, 0}, {0, 0, -4}, {0, 1, 0}, 1.2F};
  const Image image{320, 240, 0, false};
  Extent extent;  // relative to the target
  extent.items.push_back({{0, 0, 4 - near_ball_depth}, 0});
  extent.items.push_back({{0, 0, -96}, 0});
  return View(camera, image, extent);
}

TEST(ViewTest, NoVisiblePointOfABallIsLargerThanTheBallsBound) {
  const View view = WideView(0.05F);
  std::mt19937 random(20);
  std::uniform_real_distribution<float> place(-6, 6), unit(-1, 1), size(0.1F, 3);
  int visible = 0;
  for (int i = 0; i < 200'000; ++i) {
    const Ball ball{{place(random), place(random), 4 + place(random)}, size(random)};
    Eigen::Vector3f way(unit(random), unit(random), unit(random));
    if (way.norm() < 0.1F || way.norm() > 1) continue;
    const Eigen::Vector3f point = ball.centre + ball.radius * way.normalized();
    const Eigen::Vector4f clip = view.clip() * point.homogeneous();
    if (!(clip.w() > view.near()) || clip.head<2>().cwiseAbs().maxCoeff() > clip.w()) continue;
    ++visible;
    ASSERT_LE(view.PixelsPerMetre(view.Depth(point)), view.PixelsPerMetre(ball) * 1.0001F)
        << point.transpose();
  }
  EXPECT_GT(visible, 5'000);
}

TEST(ViewTest, BallsBehindAndBesideTheEyeAreAsFineAsTheirDistanceNeeds) {
  const View view = WideView(0.05F);
  const float ahead = view.PixelsPerMetre(Ball{{0, 0, -6}, 0.5F});  // 10 m before the eye
  for (const Eigen::Vector3f& place :
       {Eigen::Vector3f(0, 0, 14), Eigen::Vector3f(10, 0, 4), Eigen::Vector3f(0, -10, 4)}) {
    EXPECT_LT(view.PixelsPerMetre(Ball{place, 0.5F}), 1.6F * ahead) << place.transpose();
  }
  EXPECT_EQ(view.PixelsPerMetre(Ball{{0, 0, 4}, 0.5F}), view.PixelsPerMetre(view.near()))
      << "a ball around the eye";
}

}  // namespace
}  // namespace vesper::render
