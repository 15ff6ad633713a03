// SPDX-License-Identifier: Apache-2.0
// Tests materials, textures and coloured triangles.
#include <gtest/gtest.h>

#include <algorithm>

#include "picture.hpp"

namespace vesper::render::test {
namespace {

using MaterialTest = PictureTest;

/// The colours of the quarters of a texture: upper left, upper right, lower left, lower right.
constexpr std::array kQuarters{kRed, kGreen, kBlue, kWhite};

/// Returns a camera that looks along -z. Its view is 4 m wide and 3 m high, with 100 pixels per
/// metre.
Message Front() { return Orthographic({0, 0, 9}, {0, 0, 0}, 3); }

Message Quarters() { return Texture(1, 2, 2, {kQuarters.begin(), kQuarters.end()}); }

/// Returns the pure colour that is nearest to the colour of a pixel. The pixel is half a pixel off
/// the centre, so neighbours mix in a little.
Rgba Pure(Rgba pixel) {
  for (int i = 0; i < 3; ++i) pixel[i] = pixel[i] > 127 ? 255 : 0;
  return pixel;
}

/// Returns the colours at the centres of the quarters of a square of 2 m around the picture's
/// centre.
std::array<Rgba, 4> QuartersOf(const Picture& picture) {
  return {Pure(picture.At(150, 100)), Pure(picture.At(250, 100)), Pure(picture.At(150, 200)),
          Pure(picture.At(250, 200))};
}

TEST_F(MaterialTest, TextureStandsUprightOnTheSidesOfABox) {
  const Item box = Unlit({}, {2, 2, 2}, kWhite);
  for (const Vec3 eye : {Vec3{0, 0, 9}, Vec3{9, 0, 0}, Vec3{0, 0, -9}, Vec3{-9, 0, 0}}) {
    const Picture picture = Draw({Orthographic(eye, {0, 0, 0}, 3), Quarters(),
                                  Material(1, kWhite, 1, 0, 1), Instances(2, {box}, 0, {1})});
    EXPECT_EQ(QuartersOf(picture), kQuarters);
  }
}

TEST_F(MaterialTest, TextureLiesOnAPlaneWithItsTopTowardsMinusZ) {
  const Picture picture =
      Draw({Orthographic({0, 9, 0}, {0, 0, 0}, 3, {0, 0, -1}), Quarters(),
            Material(1, kWhite, 1, 0, 1), Instances(3, {Unlit({}, {2, 0, 2}, kWhite)}, 0, {1})});
  EXPECT_EQ(QuartersOf(picture), kQuarters);
}

TEST_F(MaterialTest, TextureRunsAroundASphereWithoutASeam) {
  // The texture is red to the west of the centre, green to the east, and red where its ends meet at
  // the back.
  const std::vector<Message> scene{Texture(1, 4, 1, {kRed, kRed, kGreen, kRed}),
                                   Material(1, kWhite, 1, 0, 1),
                                   Instances(1, {Unlit({}, {2, 2, 2}, kWhite)}, 0, {1})};
  const auto from = [&](Vec3 eye) {
    std::vector<Message> messages = scene;
    messages.push_back(Orthographic(eye, {0, 0, 0}, 3));
    return Draw(messages);
  };
  const Picture front = from({0, 0, 9});
  EXPECT_EQ(Pure(front.At(130, 150)), kRed);
  EXPECT_EQ(Pure(front.At(200 + 71, 150)), kGreen);
  const Picture back = from({0, 0, -9});
  for (int x = 165; x < 235; ++x) {
    EXPECT_EQ(Pure(back.At(x, 150)), kRed) << "at the seam, " << x;
  }
}

TEST_F(MaterialTest, PartsOfAMeshHaveMaterialsOfTheirOwn) {
  const std::vector<Vec3> square{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const Item item = Unlit({}, {1, 1, 1}, kWhite);
  const Picture picture =
      Draw({Front(), Mesh(7, square, {{0, 1, 2}, {0, 2, 3}}), Material(1, kRed, 1, 0),
            Material(2, kBlue, 1, 0), Instances(4, {item}, 7, {1, 0, 1}),
            Instances(4, {item}, 7, {2, 1, 1})});
  EXPECT_EQ(picture.At(250, 200), kRed);
  EXPECT_EQ(picture.At(150, 100), kBlue);
}

TEST_F(MaterialTest, MeshesWearTexturesWhereTheirCoordinatesSay) {
  Message mesh(5);  // like the quarters, but rotated by 90 degrees
  mesh.U32(7).U32(4).U32(2).U32(2);
  for (const Vec3& at : {Vec3{-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {1, 1, 0}}) mesh.Put(at);
  for (const auto& at : {std::array{1.0F, 0.0F}, {0.0F, 0.0F}, {0.0F, 1.0F}, {1.0F, 1.0F}}) {
    mesh.Put(at);
  }
  mesh.Put(std::array<uint32_t, 6>{0, 1, 2, 0, 2, 3});
  const Picture picture = Draw({Front(), mesh, Quarters(), Material(1, kWhite, 1, 0, 1),
                                Instances(4, {Unlit({}, {1, 1, 1}, kWhite)}, 7, {1})});
  EXPECT_EQ(QuartersOf(picture), (std::array{kGreen, kWhite, kRed, kBlue}));
}

TEST_F(MaterialTest, ColoursOfItemMaterialAndTextureMultiplyInLinearLight) {
  const Picture picture = Draw({Front(), Texture(1, 1, 1, {{255, 188, 255, 255}}),
                                Material(1, {188, 255, 255, 255}, 1, 0, 1),
                                Instances(2, {Unlit({}, {2, 2, 2}, {188, 188, 0, 255})}, 0, {1})});
  const Rgba shown = picture.At(200, 150);  // the sRGB value 188 is half the light of 255
  EXPECT_NEAR(shown[0], 137, 2);
  EXPECT_NEAR(shown[1], 137, 2);
  EXPECT_EQ(shown[2], 0);
}

TEST_F(MaterialTest, LooseTrianglesBlendTheColoursOfTheirCorners) {
  const Vec3 a{-1, -1, 0}, b{1, -1, 0}, c{0, 1, 0};
  const Picture picture = Draw({Front(), Environment(kBlack, kBlack, {0, 0, 1}, 0, 1),
                                Triangles({{{a, b, c}, {kRed, kGreen, kBlue}}})});
  const auto lit = picture.Where([](Rgba pixel) { return pixel != kBlack; });
  EXPECT_NEAR(static_cast<double>(lit.size()), 100 * 200, 200);
  const auto near = [&](int x, int y) { return picture.At(x, y); };
  EXPECT_GT(near(110, 245)[0], 2 * near(110, 245)[1]);
  EXPECT_GT(near(290, 245)[1], 2 * near(290, 245)[0]);
  EXPECT_GT(near(200, 60)[2], 2 * near(200, 60)[0]);
  const Rgba middle = picture.At(200, 183);
  EXPECT_NEAR(middle[0], middle[1], 3);
  EXPECT_NEAR(middle[1], middle[2], 3);
}

TEST_F(MaterialTest, LooseTrianglesCastShadows) {
  const Vec3 a{-1, 1, -1}, b{1, 1, -1}, c{0, 1, 1};
  const Message ground = Instances(3, {{{}, {4, 0, 4}, kWhite, 0}});
  const std::vector<Message> scene{Image(400, 300, 0, 1),
                                   Orthographic({0, 0.5F, 9}, {0, 0.5F, 0}, 3), ground,
                                   Perspective({0, 4, 8}, {0, 0, 0}, 0.5F)};
  std::vector<Message> covered = scene;
  covered.push_back(Triangles({{{a, c, b}, {kRed, kRed, kRed}}}));
  const auto dark = [](const Picture& picture) {
    return picture.Where([](Rgba p) { return p[0] == p[1] && p[0] > 60 && p[0] < 150; }).size();
  };
  EXPECT_GT(dark(Draw(covered)), dark(Draw(scene)) + 1000);
}

/// Returns the pixels of a ball that are much brighter than most of it.
std::pair<size_t, int> Highlight(const Picture& picture) {
  const auto bright = picture.Where([](Rgba pixel) { return pixel[2] > 60; });
  int brightest = 0;
  for (const auto& at : bright) {
    brightest = std::max<int>(brightest, picture.At(at.x(), at.y())[2]);
  }
  return {bright.size(), brightest};
}

TEST_F(MaterialTest, RougherSurfacesHaveLargerAndDimmerHighlights) {
  const auto ball = [](float roughness) {
    return Draw({Front(), Environment(kBlack, kBlack, {0, 0, 1}, 0.6F, 0.3F),
                 Material(1, kWhite, roughness, 0),
                 Instances(1, {{{}, {2, 2, 2}, kRed, 0}}, 0, {1})});
  };
  const auto [smooth_size, smooth_peak] = Highlight(ball(0.25F));
  const auto [plain_size, plain_peak] = Highlight(ball(0.45F));
  const auto [rough_size, rough_peak] = Highlight(ball(1));
  EXPECT_GT(plain_size, smooth_size);
  EXPECT_GT(smooth_peak, plain_peak);
  EXPECT_GT(plain_peak, rough_peak);
}

TEST_F(MaterialTest, MetalsColourWhatTheyMirror) {
  const Picture picture = Draw({Front(), Material(1, kWhite, 0.3F, 1),
                                Instances(1, {{{}, {2, 2, 2}, {255, 188, 0, 255}, 0}}, 0, {1})});
  for (const auto& at : picture.Where([](Rgba pixel) { return pixel != kBlack; })) {
    EXPECT_EQ(picture.At(at.x(), at.y())[2], 0) << "a blue gleam at " << at.transpose();
  }
  EXPECT_GT(picture.At(200, 80)[0], picture.At(200, 220)[0] + 40) << "sky above, ground below";
}

TEST_F(MaterialTest, TrianglesWithoutANormalAreFlat) {
  const auto seen = [](const std::array<Vec3, 3>& normals) {
    Message mesh(5);
    mesh.U32(7).U32(3).U32(1).U32(1);
    for (const Vec3& at : {Vec3{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}) mesh.Put(at);
    for (const Vec3& normal : normals) mesh.Put(normal);
    mesh.Put(std::array<uint32_t, 3>{0, 1, 2});
    return Draw({Front(), Environment(kBlack, kBlack, {0, 0, 1}, 0.6F, 0.3F), mesh,
                 Instances(4, {{{}, {1, 1, 1}, kRed, 0}}, 7)})
        .At(200, 150);
  };
  const Vec3 ahead{0, 0, 1}, aside{1, 0, 0}, none{0, 0, 0};
  EXPECT_EQ(seen({none, none, none}), seen({ahead, ahead, ahead}));
  EXPECT_EQ(seen({none, aside, aside}), seen({ahead, ahead, ahead}));
  EXPECT_NE(seen({aside, aside, aside}), seen({ahead, ahead, ahead}));
}

}  // namespace
}  // namespace vesper::render::test
