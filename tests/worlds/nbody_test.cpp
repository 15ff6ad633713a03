// SPDX-License-Identifier: Apache-2.0
// 1536 suns: the laws of the CPU, those of an OpenCL device, and both mixed.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "frames.hpp"
#include "program.hpp"

namespace vesper {
namespace {

using Json = nlohmann::json;
using Vector = Vec3<double>;

const std::string kNBody = VESPER_WORLDS "/nbody-1536/";
constexpr size_t kSuns = 1536;
constexpr double kMass = 1.0 / kSuns, kSoftening = 0.05;  // [kg], [m]; G is 1

struct Suns : Frame {
  double Energy() const {
    double energy = 0;
    for (size_t i = 0; i < kSuns; ++i) {
      energy += kMass / 2 * Dot(velocity[i], velocity[i]);
      for (size_t j = 0; j < i; ++j) {
        const Vector d = position[j] - position[i];
        energy -= kMass * kMass / std::sqrt(Dot(d, d) + kSoftening * kSoftening);
      }
    }
    return energy;
  }
  Vector Momentum() const {
    Vector sum;
    for (const Vector& v : velocity) sum += v * kMass;
    return sum;
  }
};

struct SunsRun {
  Suns begin, end;
};

SunsRun RunSuns(const std::string& scene, int frames) {
  const Folder folder;
  const std::string count = std::to_string(frames);
  const Outcome outcome = RunProgram(
      VESPER_COMMAND, {"run", kNBody + scene + ".vesper", "--laws", VESPER_LAW_PATH, "--frames",
                       count, "--every", count, "--threads", "2", "--csv", folder / "suns.csv"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  const std::vector<Frame> written = ReadFrames(ReadText(folder / "suns.csv"));
  EXPECT_EQ(written.size(), 2u);
  EXPECT_EQ(written.back().size(), kSuns);
  return {{written.front()}, {written.back()}};
}

double LargestDistance(const Suns& a, const Suns& b) {
  double largest = 0;
  for (size_t i = 0; i < kSuns; ++i) {
    largest = std::max(largest, Length(a.position[i] - b.position[i]));
  }
  return largest;
}

class NBodyWorldTest : public ::testing::Test {
 protected:
  const Json expected_ = Json::parse(ReadText(kNBody + "expected.json"));
  const int frames_ = expected_["frames"];
};

TEST_F(NBodyWorldTest, EveryVariantKeepsEnergyAndMomentum) {
  for (const char* scene : {"cpu", "opencl", "mixed"}) {
    SCOPED_TRACE(scene);
    const SunsRun run = RunSuns(scene, frames_);
    const double energy = run.begin.Energy();
    EXPECT_LE(std::abs(run.end.Energy() / energy - 1), expected_["energyRelativeChangeAtMost"]);
    EXPECT_LE(Length(run.end.Momentum() - run.begin.Momentum()), expected_["momentumChangeAtMost"]);
    EXPECT_GE(LargestDistance(run.begin, run.end), expected_["farthestMoveAtLeast"]);
  }
}

TEST_F(NBodyWorldTest, SunsMoveAlikeWhereverTheirLawsAreComputed) {
  const Suns cpu = RunSuns("cpu", frames_).end;
  for (const char* scene : {"opencl", "mixed"}) {
    EXPECT_LE(LargestDistance(cpu, RunSuns(scene, frames_).end), expected_["variantsApartAtMost"])
        << scene;
  }
}

}  // namespace
}  // namespace vesper
