// SPDX-License-Identifier: Apache-2.0
// Compares pictures with positions computed by geometry and optics.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "picture.hpp"

namespace vesper::render::test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

/// Returns the smallest rectangle around pixels: {left, top, right, bottom}, right and bottom
/// exclusive.
Eigen::Vector4i BoxAround(const std::vector<Eigen::Vector2i>& points) {
  Eigen::Vector4i box(INT32_MAX, INT32_MAX, 0, 0);
  for (const auto& point : points) {
    box.head<2>() = box.head<2>().cwiseMin(point);
    box.tail<2>() = box.tail<2>().cwiseMax(point + Eigen::Vector2i(1, 1));
  }
  return box;
}

TEST_F(PictureTest, SphereCoversTheSolidAngleOfItsCone) {
  // A sphere on the axis at distance d appears as a disc of radius tan(asin(r / d)) at depth 1.
  const float fov = 0.8F, r = 1.5F, d = 6;
  const Picture picture = Draw({Perspective({0, 0, d}, {0, 0, 0}, fov),
                                Instances(1, {Unlit({}, {2 * r, 2 * r, 2 * r}, kRed)})});
  const float radius = std::tan(std::asin(r / d)) / std::tan(fov / 2) * 150;
  EXPECT_NEAR(static_cast<float>(picture.Of(kRed).size()) / (kPi * radius * radius), 1, 0.005F);
}

TEST_F(PictureTest, SphereOfEverySizeIsRound) {
  for (const float radius : {3.0F, 10.0F, 40.0F, 140.0F}) {
    const float r = radius / 150;  // the view is 2 m high, 300 pixels
    const Picture picture = Draw({Orthographic({0, 0, 5}, {0, 0, 0}, 2),
                                  Instances(1, {Unlit({}, {2 * r, 2 * r, 2 * r}, kRed)})});
    for (const auto& pixel : picture.Of(kRed)) {
      ASSERT_LT((pixel.cast<float>() - Eigen::Vector2f(199.5F, 149.5F)).norm(), radius);
    }
    const auto inside = static_cast<float>(picture.Of(kRed).size());
    EXPECT_NEAR(inside, kPi * radius * radius, 1.5F * kPi * radius) << radius;
  }
}

TEST_F(PictureTest, BoxFaceHasItsProjectedCorners) {
  // The near face of a 4 x 2 x 2 box is at depth 9. Its corners are at (+-2, +-1) / 9, where
  // tan(fov / 2) corresponds to 150 px.
  const float fov = 0.7F;
  const Picture picture =
      Draw({Perspective({0, 0, 10}, {0, 0, 0}, fov), Instances(2, {Unlit({}, {4, 2, 2}, kGreen)})});
  const float scale = 150 / std::tan(fov / 2) / 9;
  const Eigen::Vector4f expected(200 - 2 * scale, 150 - scale, 200 + 2 * scale, 150 + scale);
  const Eigen::Vector4f found = BoxAround(picture.Of(kGreen)).cast<float>();
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1) << found.transpose();
}

TEST_F(PictureTest, OrientationTurnsAnticlockwiseSeenFromItsAxis) {
  // A bar along x, rotated by 90 degrees about z, is along y. Another 30 degrees tilt its upper end
  // to -x.
  const auto about_z = [](float angle) {
    return std::array<float, 4>{0, 0, std::sin(angle / 2), std::cos(angle / 2)};
  };
  Item bar = Unlit({}, {4, 0.5F, 0.5F}, kBlue);
  bar.orientation = about_z(kPi / 2);
  const Message camera = Orthographic({0, 0, 5}, {0, 0, 0}, 6);
  const Eigen::Vector4i upright = BoxAround(Draw({camera, Instances(2, {bar})}).Of(kBlue));
  EXPECT_NEAR(upright[2] - upright[0], 25, 1);
  EXPECT_NEAR(upright[3] - upright[1], 200, 1);
  bar.orientation = about_z(kPi / 2 + kPi / 6);
  const Picture leaning = Draw({camera, Instances(2, {bar})});
  const auto at = [](float along) {  // point on the bar, `along` metres from its centre
    const float angle = kPi / 2 + kPi / 6;
    return Eigen::Vector2i(200 + std::lround(50 * along * std::cos(angle)),
                           150 - std::lround(50 * along * std::sin(angle)));
  };
  EXPECT_EQ(leaning.At(at(1.8F).x(), at(1.8F).y()), kBlue);
  EXPECT_EQ(leaning.At(at(-1.8F).x(), at(-1.8F).y()), kBlue);
}

TEST_F(PictureTest, NearerItemsHideFartherOnesInAnyOrder) {
  const Item near = Unlit({0, 0, 2}, {1, 1, 1}, kRed), far = Unlit({0, 0, -2}, {1, 1, 1}, kBlue);
  const Message camera = Orthographic({0, 0, 9}, {0, 0, 0}, 3);
  for (const auto& order : {std::vector{near, far}, std::vector{far, near}}) {
    const Picture picture = Draw({camera, Instances(2, order)});
    EXPECT_EQ(picture.At(200, 150), kRed);
    EXPECT_TRUE(picture.Of(kBlue).empty());
  }
  const Picture behind = Draw({Orthographic({0, 0, -9}, {0, 0, 0}, 3), Instances(2, {near, far})});
  EXPECT_EQ(behind.At(200, 150), kBlue);
}

TEST_F(PictureTest, DepthStaysFineOnAPlaneThatReachesFarAway) {
  // The picture shows a red sheet 5 mm above a blue ground of 2 km, from a distance of 30 m.
  const Picture picture = Draw(
      {Perspective({0, 15, 26}, {0, 0, 0}, 0.5F),
       Instances(3, {Unlit({}, {2000, 0, 2000}, kBlue), Unlit({0, 0.005F, 0}, {8, 0, 8}, kRed)})});
  const Eigen::Vector4i box = BoxAround(picture.Of(kRed));
  for (int y = box[1] + 2; y < box[3] - 2; ++y) EXPECT_EQ(picture.At(200, y), kRed) << y;
}

TEST_F(PictureTest, LineRunsBetweenTheProjectionsOfItsEnds) {
  const float fov = 0.6F;
  const Vec3 from{-2, -1, 0}, to{2, 1.5F, -3};
  const Picture picture =
      Draw({Perspective({0, 0, 12}, {0, 0, 0}, fov), Segments({{from, to, kWhite}}, 3)});
  const auto project = [&](const Vec3& p) {
    const float scale = 150 / std::tan(fov / 2) / (12 - p[2]);
    return Eigen::Vector2f(200 + p[0] * scale, 150 - p[1] * scale);
  };
  const Eigen::Vector2f a = project(from), b = project(to), along = (b - a).normalized();
  float first = 1e9F, last = -1e9F;
  const auto covered = picture.Of(kWhite);
  for (const auto& pixel : covered) {
    const Eigen::Vector2f offset = pixel.cast<float>() + Eigen::Vector2f(0.5F, 0.5F) - a;
    ASSERT_LT(std::abs(offset.x() * along.y() - offset.y() * along.x()), 1.51F);
    first = std::min(first, offset.dot(along));
    last = std::max(last, offset.dot(along));
  }
  EXPECT_NEAR(first, 0, 1);
  EXPECT_NEAR(last, (b - a).norm(), 1);
  EXPECT_NEAR(static_cast<float>(covered.size()), 3 * (b - a).norm(), 0.02F * 3 * (b - a).norm());
}

TEST_F(PictureTest, LineThatPassesTheEyeIsCutInFrontOfIt) {
  // The plane is below the eye and extends from far ahead to behind the eye. Therefore only the
  // lower half of the picture shows it.
  const Picture picture = Draw(
      {Perspective({0, 1, 0}, {0, 1, -10}, 1), Segments({{{0, 0, -50}, {0, 0, 20}, kWhite}}, 4)});
  const auto covered = picture.Of(kWhite);
  const Eigen::Vector4i box = BoxAround(covered);
  EXPECT_NEAR(box[1], 150 + 150 / std::tan(0.5F) / 50, 2);
  EXPECT_EQ(box[3], 300);
  EXPECT_NEAR(box[2] - box[0], 4, 1);
}

TEST_F(PictureTest, ItemsHideLines) {
  const Picture picture = Draw({Orthographic({0, 0, 9}, {0, 0, 0}, 3),
                                Instances(2, {Unlit({0, 0, 2}, {1, 1, 1}, kRed)}),
                                Segments({{{-1.5F, 0, 0}, {1.5F, 0, 0}, kWhite}}, 2)});
  EXPECT_EQ(picture.At(200, 150), kRed);
  EXPECT_EQ(picture.At(100, 150), kWhite);
}

TEST_F(PictureTest, UnlitItemsShowTheirExactColour) {
  for (const Rgba colour : {Rgba{1, 2, 3, 255}, Rgba{93, 173, 226, 255}, Rgba{128, 64, 250, 0}}) {
    const Picture picture =
        Draw({Orthographic({0, 0, 9}, {0, 0, 0}, 3), Instances(2, {Unlit({}, {2, 2, 2}, colour)}),
              Segments({{{-2, 1.2F, 0}, {2, 1.2F, 0}, colour}}, 8)});
    const Rgba box = picture.At(200, 150), line = picture.At(200, 30);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(box[i], colour[i], 1);
      EXPECT_NEAR(line[i], colour[i], 1);
    }
  }
}

float ToSrgb(float linear) {
  return 255 *
         (linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F);
}

TEST_F(PictureTest, LitPlaneFollowsLambertsLaw) {
  // The scene is seen from above. The light is tilted by an angle, and the ambient light from the
  // sky is white.
  for (const float lean : {0.0F, 0.6F, 1.2F}) {
    const Picture picture =
        Draw({Environment(kBlack, kBlack, {std::sin(lean), std::cos(lean), 0}, 0.5F, 0.25F),
              Orthographic({0, 9, 0}, {0, 0, 0}, 3, {0, 0, -1}),
              Instances(3, {{{}, {2, 0, 2}, {188, 255, 0, 255}, 0}})});
    const float light = 0.25F + 0.5F * std::cos(lean);
    EXPECT_NEAR(picture.At(200, 150)[0], ToSrgb(light * ToLinear(188)), 1.5F) << lean;
    EXPECT_NEAR(picture.At(200, 150)[1], ToSrgb(light), 1.5F) << lean;
    EXPECT_EQ(picture.At(200, 150)[2], 0) << lean;
  }
}

TEST_F(PictureTest, ShadowFallsWhereTheLightIsHidden) {
  // The light comes from the direction (-1, 1, 0), so a ball at height 2 shades the ground around
  // (2, 0).
  const std::vector scene{Environment(kBlack, kBlack, {-1, 1, 0}, 0.6F, 0.3F),
                          Orthographic({0, 50, 0}, {0, 0, 0}, 6, {0, 0, -1}),
                          Instances(3, {{{}, {20, 0, 20}, kWhite, 0}}),
                          Instances(1, {{{0, 2, 0}, {1, 1, 1}, kRed, 0}})};
  const auto draw = [&](uint32_t shadows) {
    auto messages = scene;
    messages.push_back(Image(400, 300, 0, shadows));
    return Draw(messages);
  };
  const Picture with = draw(1), without = draw(0);
  const float sun = 0.6F * std::sqrt(0.5F);
  EXPECT_NEAR(with.At(300, 150)[0], ToSrgb(0.3F), 1.5F);  // 50 pixels per metre
  EXPECT_NEAR(with.At(100, 150)[0], ToSrgb(0.3F + sun), 1.5F);
  EXPECT_NEAR(without.At(300, 150)[0], ToSrgb(0.3F + sun), 1.5F);
  // The shadow of a ball is an ellipse as wide as the ball and stretched by 1 / cos(45 degrees).
  const auto shadow = with.Where([](Rgba p) { return p[0] == p[1] && p[0] < ToSrgb(0.5F); });
  EXPECT_NEAR(static_cast<float>(shadow.size()), kPi * 25 * 25 * std::sqrt(2.0F), 120);
}

TEST_F(PictureTest, UnlitItemsCastNoShadow) {
  const Picture picture =
      Draw({Image(400, 300, 0, 1), Orthographic({0, 50, 0}, {0, 0, 0}, 6, {0, 0, -1}),
            Environment(kBlack, kBlack, {-1, 1, 0}, 0.6F, 0.3F),
            Instances(3, {{{}, {20, 0, 20}, kWhite, 0}}),
            Instances(1, {Unlit({0, 2, 0}, {1, 1, 1}, kRed),
                          {{-1, 2, 0}, {0.5F, 0.5F, 0.5F}, kGreen, 0}})});
  EXPECT_EQ(picture.At(300, 150), picture.At(300, 280));
  EXPECT_NE(picture.At(250, 150), picture.At(300, 280));
}

TEST_F(PictureTest, MultisamplingBlendsEdgesInLinearLight) {
  // The edge of a white sheet crosses a column of pixels in the middle and covers half of each.
  const Picture picture = Draw({Image(400, 300, 4, 0), Orthographic({0, 0, 9}, {0, 0, 0}, 3),
                                Instances(2, {Unlit({-0.995F, 0, 0}, {2, 9, 1}, kWhite)})});
  EXPECT_EQ(picture.At(199, 150), kWhite);
  EXPECT_NEAR(picture.At(200, 150)[0], ToSrgb(0.5F), 1);
  EXPECT_EQ(picture.At(201, 150), kBlack);
}

TEST_F(PictureTest, BackgroundRunsFromTopToBottom) {
  const Picture picture = Draw(
      {Environment(kRed, kBlue, {0, 1, 0}, 0.5F, 0.25F), Orthographic({0, 0, 9}, {0, 0, 0}, 3)});
  EXPECT_GT(picture.At(200, 0)[0], 250);
  EXPECT_GT(picture.At(200, 299)[2], 250);
  EXPECT_NEAR(picture.At(200, 150)[0], ToSrgb(0.5F), 2);
}

TEST_F(PictureTest, FadingPlaneEndsInTheBackground) {
  const Item ground{{0, -1, 0}, {1e4F, 0, 1e4F}, kWhite, kFade | kGrid};
  const Message camera = Perspective({0, 3, 12}, {0, 0, 0}, 0.9F);
  const Message background = Environment(kBlue, kBlue, {0, 1, 0}, 0.6F, 0.4F);
  const Message ball = Instances(1, {Unlit({}, {2, 2, 2}, kRed)});
  const Picture picture = Draw({background, camera, ball, Instances(3, {ground})});
  EXPECT_EQ(picture.At(3, 100), kBlue);  // at the horizon
  EXPECT_GT(picture.At(200, 200)[0], 100);
  Item solid = ground;
  solid.flags = 0;
  EXPECT_GT(Draw({background, camera, ball, Instances(3, {solid})}).At(3, 110)[0], 100);
}

TEST_F(PictureTest, GridLinesAreOneUnitApart) {
  // The view from above is 12 m high. It shows a line at each metre, 25 pixels apart, with stronger
  // lines at 0 and 10 m.
  const Picture picture = Draw({Orthographic({0.5F, 9, 0.5F}, {0.5F, 0, 0.5F}, 12, {0, 0, -1}),
                                Instances(3, {{{0.3F, 0, 0.1F}, {40, 0, 40}, kWhite, kGrid}})});
  const int plain = picture.At(200, 150)[0];
  std::vector<uint32_t> lines;
  for (uint32_t x = 0; x < 400; ++x) {
    if (picture.At(x, 150)[0] < plain - 3 && (lines.empty() || x - lines.back() > 2)) {
      lines.push_back(x);
    }
  }
  ASSERT_EQ(lines.size(), 16U);
  for (size_t i = 1; i < lines.size(); ++i) EXPECT_NEAR(lines[i] - lines[i - 1], 25, 1);
  const int minor = picture.At(212, 150)[0], major = picture.At(187, 150)[0];
  EXPECT_LT(major, minor);  // x = 0 is a multiple of ten, x = 1 is not
}

TEST_F(PictureTest, MeshOfABoxLooksLikeTheBox) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back({i & 1 ? 0.5F : -0.5F, i & 2 ? 0.5F : -0.5F, i & 4 ? 0.5F : -0.5F});
  }
  const std::vector<std::array<uint32_t, 3>> faces{{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                                   {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                                   {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  Item item{{0.2F, 0.1F, 0}, {2, 1, 3}, {180, 90, 30, 255}, 0, {0.5F, 0.5F, 0.5F, 0.5F}};
  const std::vector scene{Perspective({4, 3, 6}, {0, 0, 0}, 0.6F),
                          Environment(kBlack, kBlack, {0.3F, 1, 0.5F}, 0.6F, 0.3F)};
  auto box = scene, mesh = scene;
  box.push_back(Instances(2, {item}));
  mesh.push_back(Mesh(5, corners, faces));
  mesh.push_back(Instances(4, {item}, 5));
  const Picture a = Draw(box), b = Draw(mesh);
  size_t different = 0;
  for (uint32_t y = 0; y < 300; ++y) {
    for (uint32_t x = 0; x < 400; ++x) {
      for (int i = 0; i < 3; ++i) {
        if (std::abs(a.At(x, y)[i] - b.At(x, y)[i]) > 1) ++different;
      }
    }
  }
  EXPECT_GT(a.Where([](Rgba p) { return p != kBlack; }).size(), 10'000U);
  EXPECT_EQ(different, 0U);
}

TEST_F(PictureTest, SameSceneGivesSameBytes) {
  std::vector<Item> items;
  for (int i = 0; i < 60; ++i) {
    const auto t = static_cast<float>(i);
    items.push_back({{std::sin(t), std::cos(2 * t), t / 30}, {0.3F, 0.3F, 0.3F}, kBlue});
  }
  const std::vector scene{Image(400, 300, 4, 1), Perspective({3, 2, 6}, {0, 0, 1}, 0.6F),
                          Instances(1, items),
                          Instances(3, {{{0, -2, 0}, {50, 0, 50}, kWhite, kGrid | kFade}})};
  const Picture first = Draw(scene);
  Draw({Image(64, 64, 0, 0), Orthographic({0, 0, 9}, {0, 0, 0}, 3)});
  EXPECT_EQ(first.pixels.rgb, Draw(scene).pixels.rgb);
}

TEST_F(PictureTest, ItemsFarFromTheOriginOfTheWorldKeepTheirShape) {
  const auto draw = [](float far) {
    return Draw({Orthographic({far, 0, 9}, {far, 0, 0}, 3),
                 Instances(2, {Unlit({far + 0.5F, 0, 0}, {1, 1, 1}, kRed)})});
  };
  EXPECT_EQ(draw(0).pixels.rgb, draw(65536).pixels.rgb);
}

TEST_F(PictureTest, ItemsWithoutAnySizeAreNotSeen) {
  const Picture picture =
      Draw({Orthographic({0, 0, 9}, {0, 0, 0}, 3), Instances(1, {Unlit({}, {0, 0, 0}, kRed)}),
            Segments({{{0, 0, 0}, {0, 0, 0}, kRed}}, 9)});
  EXPECT_TRUE(picture.Of(kRed).empty());
}

}  // namespace
}  // namespace vesper::render::test
