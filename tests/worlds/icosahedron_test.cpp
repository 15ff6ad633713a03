// SPDX-License-Identifier: Apache-2.0
// The paper's example 2: one icosahedron that is solid or goo, rolls or slides.
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "frames.hpp"
#include "icosahedron.hpp"
#include "program.hpp"

namespace vesper {
namespace {

using Json = nlohmann::json;
using Vector = Vec3<double>;

const std::string kIcosahedron = VESPER_WORLDS "/icosahedron/";
constexpr size_t kCorners = 12, kBodies = 15;
const double kEdge = 2 * icosahedron::HalfEdge();

/// Positions and velocities of the corners at the end of a frame.
struct Corners {
  std::array<Vector, kCorners> position, velocity;

  static Vector Mean(const std::array<Vector, kCorners>& of) {
    Vector sum;
    for (const Vector& v : of) sum += v;
    return sum * (1.0 / kCorners);
  }
  Vector Centre() const { return Mean(position); }
};

/// Returns the corners of the icosahedron in each frame. Its rows of a frame come before those of
/// the ground.
std::vector<Corners> CornersOf(const std::vector<Frame>& frames) {
  std::vector<Corners> corners;
  for (const Frame& frame : frames) {
    EXPECT_EQ(frame.size(), kBodies);
    Corners& at = corners.emplace_back();
    for (size_t row = 0; row < kCorners; ++row) {
      at.position[row] = frame.position.at(row);
      at.velocity[row] = frame.velocity.at(row);
    }
  }
  return corners;
}

struct SceneRun {
  std::vector<Corners> frames;
  std::string state_hash;
};

SceneRun RunScene(const std::string& name, int seconds, int threads) {
  const Folder folder;
  const Outcome outcome = RunProgram(
      VESPER_COMMAND, {"run", kIcosahedron + name + ".vesper", "--laws", VESPER_LAW_PATH,
                       "--frames", std::to_string(60 * seconds), "--threads",
                       std::to_string(threads), "--csv", folder / "frames.csv", "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  return {CornersOf(ReadFrames(ReadText(folder / "frames.csv"))),
          Json::parse(outcome.output)["stateHash"]};
}

/// Returns the largest relative change of an edge at the end. Edges join the corners that are
/// nearest to each other at the start.
double EdgeChange(const std::vector<Corners>& frames) {
  double change = 0;
  int edges = 0;
  for (size_t i = 0; i < kCorners; ++i) {
    for (size_t j = 0; j < i; ++j) {
      const auto length = [&](const Corners& at) {
        return Length(at.position[i] - at.position[j]);
      };
      if (std::abs(length(frames.front()) - kEdge) > 1e-3) continue;
      ++edges;
      change = std::max(change, std::abs(length(frames.back()) / kEdge - 1));
    }
  }
  EXPECT_EQ(edges, 30);
  return change;
}

/// Returns the largest depth of a corner below the slope in all frames [m].
double DeepestCorner(const std::vector<Corners>& frames, double slope) {
  double depth = 0;
  for (const Corners& at : frames) {
    for (const Vector& p : at.position) {
      depth = std::max(depth, -p.y * std::cos(slope) - p.x * std::sin(slope));
    }
  }
  return depth;
}

/// Returns the clockwise rotation about z [rad]. It is computed from the angle of the corner that
/// is farthest from the axis.
double Turned(const std::vector<Corners>& frames) {
  const auto arm = [](const Corners& at, size_t corner) {
    const Vector r = at.position[corner] - at.Centre();
    return Vector{r.x, r.y, 0};
  };
  size_t far = 0;
  for (size_t i = 1; i < kCorners; ++i) {
    if (Length(arm(frames[0], i)) > Length(arm(frames[0], far))) far = i;
  }
  double turned = 0;
  for (size_t n = 1; n < frames.size(); ++n) {
    const Vector a = arm(frames[n - 1], far), b = arm(frames[n], far);
    turned -= std::atan2(Cross(a, b).z, Dot(a, b));
  }
  return turned;
}

/// Returns all quantities that expected.json can name.
Json Measure(const std::vector<Corners>& frames, double slope) {
  const Vector path = frames.back().Centre() - frames.front().Centre();
  return {{"edgeChange", EdgeChange(frames)},
          {"deepestCorner", DeepestCorner(frames, slope)},
          {"endHeight", frames.back().Centre().y},
          {"endSpeed", Length(Corners::Mean(frames.back().velocity))},
          {"distance", path.x * std::cos(slope) - path.y * std::sin(slope)},
          {"turnedRadians", Turned(frames)}};
}

class Icosahedron : public ::testing::TestWithParam<const char*> {};

TEST_P(Icosahedron, DoesWhatIsExpectedOfIt) {
  const Json expected = Json::parse(ReadText(kIcosahedron + "expected.json"))[GetParam()];
  const SceneRun run = RunScene(GetParam(), expected["seconds"], 1);
  const double slope = expected["slopeDegrees"].get<double>() * std::numbers::pi / 180;
  const Json measured = Measure(run.frames, slope);
  int bounds = 0;
  for (const auto& [name, bound] : expected.items()) {
    if (!bound.is_object()) continue;
    EXPECT_GE(measured.at(name).get<double>(), bound["from"].get<double>()) << name;
    EXPECT_LE(measured.at(name).get<double>(), bound["to"].get<double>()) << name;
    ++bounds;
  }
  EXPECT_GE(bounds, 3);
}

TEST_P(Icosahedron, EndsInTheSameStateOnTwoThreads) {
  EXPECT_EQ(RunScene(GetParam(), 1, 1).state_hash, RunScene(GetParam(), 1, 2).state_hash);
}

/// Returns corners in the form that a scene has: `(0 11 5) (0 5 1)`.
template <class Rows>
std::string Listed(const Rows& rows) {
  std::string text;
  for (const auto& row : rows) {
    text += text.empty() ? "(" : " (";
    for (size_t i = 0; i < row.size(); ++i) text += (i > 0 ? " " : "") + std::to_string(row[i]);
    text += ")";
  }
  return text;
}

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST_P(Icosahedron, HasTheEdgesAndFacesOfARegularOne) {
  const std::string scene = ReadText(kIcosahedron + GetParam() + ".vesper");
  auto edges = icosahedron::Edges();
  std::ranges::sort(edges);
  EXPECT_EQ(Count(scene, "\nendpoints " + Listed(edges) + "\n"), 1u);
  EXPECT_EQ(Count(scene, "\nvertices " + Listed(icosahedron::kFaces) + " (12 13 14)\n"), 1u);
}

TEST(IcosahedronWorld, HasTheEdgesAndFacesOfARegularOne) {
  const std::string world = ReadText(kIcosahedron + "world.yaml");
  const auto corner = [](uint32_t row) { return "c" + std::to_string(row); };
  EXPECT_EQ(Count(world, "kind: spring"), 30u);
  for (const auto& [a, b] : icosahedron::Edges()) {
    EXPECT_EQ(Count(world, "end1: " + corner(a) + ", end2: " + corner(b) + ","), 1u);
  }
  EXPECT_EQ(Count(world, "kind: surface"), 21u);  // and the ground
  for (const auto& [a, b, c] : icosahedron::kFaces) {
    const std::string face = corner(a) + ", " + corner(b) + ", " + corner(c);
    EXPECT_EQ(Count(world, "vertices: [" + face + "]"), 1u);
  }
}

// The world file has the same items as the scene `rolling`. Both end at the same place.
TEST(IcosahedronWorld, RollingEndsWhereTheWorldFileDoes) {
  const Json expected = Json::parse(ReadText(kIcosahedron + "expected.json"));
  const SceneRun run = RunScene("rolling", expected["seconds"], 1);
  for (const Json& corner : expected["positions"]) {
    const size_t row = std::stoul(corner["item"].get<std::string>().substr(1));
    const auto [x, y, z] = corner["at"].get<std::array<double, 3>>();
    EXPECT_LE(Length(run.frames.back().position.at(row) - Vector{x, y, z}),
              corner["within"].get<double>())
        << corner;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Icosahedron,
                         ::testing::Values("solid", "goo", "rolling", "sliding"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace vesper
