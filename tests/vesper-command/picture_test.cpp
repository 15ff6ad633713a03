// SPDX-License-Identifier: Apache-2.0
// `vesper run --png`: what is where in the pictures, and what is said when there are none.
#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "program.hpp"

namespace vesper {
namespace {

using Colour = std::array<uint8_t, 3>;
constexpr Colour kRed{255, 0, 0}, kBlue{0, 0, 255};

/// The camera looks along -z from a distance of 10 m. The picture is 90 degrees high. Therefore 1 m
/// at z = 0 is 12 pixels, and the origin is in the middle.
constexpr auto kHead =
    "scene 1\ndt 1\nimage 320 240\ncamera from (0 0 10) at (0 0 0) fov 90\n"
    "background #ffffff\n";
constexpr double kPixelsPerMetre = 12;

struct Spot {
  double x = 0, y = 0;  // mean [px], from the middle of the picture, y up
  double pixels = 0;
};

class Picture {
 public:
  explicit Picture(const std::string& path) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0) << image.message;
    image.format = PNG_FORMAT_RGB;
    width_ = image.width;
    pixels_.resize(PNG_IMAGE_SIZE(image) / 3);
    EXPECT_NE(png_image_finish_read(&image, nullptr, pixels_.data(), 0, nullptr), 0);
  }

  Colour At(size_t x, size_t y) const { return pixels_.at(y * width_ + x); }
  size_t width() const { return width_; }
  size_t height() const { return pixels_.size() / width_; }

  /// Returns the spot of all pixels that have exactly this colour.
  Spot Of(const Colour& colour) const {
    Spot spot;
    for (size_t i = 0; i < pixels_.size(); ++i) {
      if (pixels_[i] != colour) continue;
      ++spot.pixels;
      spot.x += static_cast<double>(i % width_) + 0.5 - static_cast<double>(width_) / 2;
      spot.y -= static_cast<double>(i / width_) + 0.5 - static_cast<double>(height()) / 2;
    }
    spot.x /= spot.pixels;
    spot.y /= spot.pixels;
    return spot;
  }

 private:
  size_t width_ = 0;
  std::vector<Colour> pixels_;
};

/// Draws the first picture of a scene.
Picture Draw(const std::string& body) {
  const Folder folder;
  const Outcome outcome = RunScene(folder.Write("s.vesper", kHead + body),
                                   {"--frames", "0", "--png", folder / "%d.png"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  return Picture(folder / "0.png");
}

TEST(PictureTest, BallIsWhereTheProjectionSaysAndAsLarge) {
  const Picture picture = Draw(
      "rows body 1\nposition (5 -3 0)\n"
      "draw body radius 1 colour #ff0000 unlit\n");
  ASSERT_EQ(picture.width(), 320u);
  ASSERT_EQ(picture.height(), 240u);
  const Spot spot = picture.Of(kRed);
  EXPECT_NEAR(spot.x, 5 * kPixelsPerMetre, 1);
  EXPECT_NEAR(spot.y, -3 * kPixelsPerMetre, 1);
  // The outline of a ball beside the axis is an ellipse. Its length is its width times 1 / cos of
  // the angle.
  const double stretch = std::hypot(10, std::hypot(5, 3)) / 10;
  EXPECT_NEAR(spot.pixels, M_PI * kPixelsPerMetre * kPixelsPerMetre * stretch, 40);
}

TEST(PictureTest, PicturesFollowTheLaws) {
  const Folder folder;
  const Outcome outcome = RunScene(
      folder.Write("s.vesper", std::string(kHead) +
                                   "law newton_motion\nrows body 1\nmass 1\nposition (-8 0 0)\n"
                                   "velocity (2 1 0)\ndraw body radius 0.5 colour #0000ff unlit\n"),
      {"--frames", "8", "--every", "4", "--png", folder / "a%03d%%.png"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find(", 3 pictures"), std::string::npos) << outcome.output;
  for (const int frame : {0, 4, 8}) {
    const Spot spot = Picture(folder / ("a00" + std::to_string(frame) + "%.png")).Of(kBlue);
    EXPECT_NEAR(spot.x, (-8 + 2 * frame) * kPixelsPerMetre, 1) << frame;
    EXPECT_NEAR(spot.y, frame * kPixelsPerMetre, 1) << frame;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a001%.png"));
}

TEST(PictureTest, SpringIsALineOfItsWidthBetweenItsEnds) {
  const Spot spot = Draw(
                        "rows body 2\nposition (-5 2 0) (5 2 0)\nrows spring 1\nendpoints (0 1)\n"
                        "draw spring width 6 colour #ff0000\n")
                        .Of(kRed);
  EXPECT_NEAR(spot.x, 0, 0.5);
  EXPECT_NEAR(spot.y, 2 * kPixelsPerMetre, 0.5);
  EXPECT_NEAR(spot.pixels, 10 * kPixelsPerMetre * 6, 20);
}

TEST(PictureTest, SurfaceIsATriangleBetweenItsCorners) {
  const Spot spot = Draw(
                        "rows body 3\nposition (0 0 0) (9 0 0) (0 6 0)\nrows surface 1\n"
                        "vertices (0 1 2)\ndraw surface colour #ff0000 unlit\n")
                        .Of(kRed);
  EXPECT_NEAR(spot.x, 3 * kPixelsPerMetre, 0.5);
  EXPECT_NEAR(spot.y, 2 * kPixelsPerMetre, 0.5);
  EXPECT_NEAR(spot.pixels, 27 * kPixelsPerMetre * kPixelsPerMetre, 200);
}

TEST(PictureTest, ColourFollowsTheLengthOfAVectorFromFirstToLast) {
  const Picture picture = Draw(
      "rows body 4\nposition (-6 0 0) (-2 0 0) (2 0 0) (6 0 0)\n"
      "velocity (0 0 0) (3 0 4) (0 10 0) (99 0 0)\n"
      "draw body radius 1 colour #ff0000 #000000 #0000ff by velocity 0 10 unlit\n");
  const auto colour_at = [&](double x) {
    return picture.At(static_cast<size_t>(160 + x * kPixelsPerMetre), 120);
  };
  EXPECT_EQ(colour_at(-6), kRed);
  EXPECT_EQ(colour_at(-2), (Colour{0, 0, 0}));
  EXPECT_EQ(colour_at(2), kBlue);
  EXPECT_EQ(colour_at(6), kBlue);
}

TEST(PictureTest, LastLineThatNamesARowDrawsIt) {
  const Picture picture = Draw(
      "rows body 3\nposition (-6 0 0) (0 0 0) (6 0 0)\n"
      "draw body radius 1 colour #ff0000 unlit\n"
      "draw body 1..2 radius 1 colour #0000ff unlit\n"
      "draw body 2 radius 0\n");
  EXPECT_NEAR(picture.Of(kRed).x, -6 * kPixelsPerMetre, 1);
  EXPECT_NEAR(picture.Of(kBlue).x, 0, 1);
}

TEST(PictureTest, RadiusOfARowIsItsProperty) {
  const Picture picture = Draw(
      "rows body 2\nposition (-6 0 0) (6 0 0)\nradius 1 2\n"
      "draw body colour #ff0000 #0000ff by radius 1 2 unlit\n");
  EXPECT_NEAR(picture.Of(kBlue).pixels / picture.Of(kRed).pixels, 4, 0.4);
}

TEST(PictureTest, WithoutACameraAllIsInThePicture) {
  const Folder folder;
  const Outcome outcome =
      RunScene(folder.Write("s.vesper",
                            "scene 1\ndt 1\nbackground #ffffff\nrows body 2\n"
                            "position (1000 5 -70) (1300 90 -70)\n"
                            "draw body colour #ff0000 #0000ff by position 1005 1300 unlit\n"),
               {"--frames", "0", "--png", folder / "%d.png"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const Picture picture(folder / "0.png");
  const Spot near = picture.Of(kBlue), far = picture.Of(kRed);
  EXPECT_NEAR(near.x, 0.82 * 480, 40);  // the fit leaves a margin of 18 %
  EXPECT_LT(far.x, -200);
  EXPECT_GT(near.y, far.y);
  EXPECT_GT(near.pixels, far.pixels);
}

// --- no pictures ---

constexpr auto kBall = "rows body 1\nposition (0 0 0)\n";

TEST(PictureErrorTest, PatternNeedsOnePlaceForTheNumber) {
  for (const auto& [pattern, found] : {std::pair{"a.png", "no place for the frame's number"},
                                       {"%d%d.png", "expected one %d"},
                                       {"%s.png", "expected one %d"},
                                       {"%4d.png", "expected one %d"},
                                       {"%", "expected one %d"}}) {
    const Outcome outcome = RunScene("nowhere.vesper", {"--png", pattern});
    EXPECT_EQ(outcome.exit_code, 2) << pattern;
    EXPECT_NE(outcome.errors.find(found), std::string::npos) << outcome.errors;
  }
}

TEST(PictureErrorTest, FileThatCannotBeWrittenEndsWith1) {
  const Folder folder;
  const Outcome outcome = RunScene(folder.Write("s.vesper", std::string(kHead) + kBall),
                                   {"--png", "/nowhere/at/all%d.png"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.errors.find("/nowhere/at/all0.png"), std::string::npos) << outcome.errors;
}

TEST(PictureErrorTest, ReferenceOutOfRangeIsRefusedAtItsLine) {
  const Folder folder;
  const std::string scene =
      folder.Write("s.vesper", std::string(kHead) + kBall + "rows spring 1\nendpoints (0 7)\n");
  const Outcome outcome = RunScene(scene, {"--png", folder / "%d.png"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.errors, "vesper: " + scene +
                                ":9:1: row 0 of 'endpoints' refers to row 7 of body, which does "
                                "not exist\n");
}

TEST(PictureErrorTest, SceneWithNothingToDrawEndsWith3) {
  const Folder folder;
  const Outcome outcome = RunScene(folder.Write("s.vesper", "scene 1\ndt 1\nrows body 1\nmass 1\n"),
                                   {"--png", folder / "%d.png"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.errors.find("nothing to draw"), std::string::npos) << outcome.errors;
}

/// Runs the program in a folder with its library and another renderer, or without one.
Outcome RunBeside(const std::string& renderer) {
  const Folder folder;
  const std::filesystem::path program = VESPER_COMMAND;
  std::filesystem::copy_file(program, folder / "vesper");
  std::filesystem::copy_file(program.parent_path() / "libvesper.so.1", folder / "libvesper.so.1");
  if (!renderer.empty()) {
    std::filesystem::permissions(folder.Write("vesper-render", renderer),
                                 std::filesystem::perms::owner_all);
  }
  return RunProgram(folder / "vesper", {"run", folder.Write("s.vesper", std::string(kHead) + kBall),
                                        "--png", folder / "%d.png"});
}

TEST(PictureErrorTest, MissingRendererEndsWith4) {
  const Outcome outcome = RunBeside("");
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_NE(outcome.errors.find("/vesper-render, which draws pictures, cannot be started: No such "
                                "file"),
            std::string::npos)
      << outcome.errors;
}

TEST(PictureErrorTest, RendererThatEndsIsReportedWithItsExitCode) {
  const Outcome outcome = RunBeside("#!/bin/sh\nexit 7\n");
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_NE(outcome.errors.find("ended with exit code 7 before its picture was done"),
            std::string::npos)
      << outcome.errors;
}

TEST(PictureErrorTest, RendererThatIsKilledIsReportedWithItsSignal) {
  const Outcome outcome = RunBeside("#!/bin/sh\nkill -ABRT $$\n");
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_NE(outcome.errors.find("ended by signal 6"), std::string::npos) << outcome.errors;
}

}  // namespace
}  // namespace vesper
