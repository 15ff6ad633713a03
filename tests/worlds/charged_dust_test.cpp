// SPDX-License-Identifier: Apache-2.0
// Charged dust in a magnetic field: three clouds that part.
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "frames.hpp"
#include "program.hpp"

namespace vesper {
namespace {

using Json = nlohmann::json;
using Vector = Vec3<double>;

const std::string kDust = VESPER_WORLDS "/charged-dust/";
constexpr size_t kGrains = 1200, kCloud = 400;  // light, negative, heavy
constexpr double kFlux = 1, kDrag = 3e-15;      // [T], [kg/s]

double MassOf(size_t grain) { return grain < 2 * kCloud ? 2e-14 : 4e-14; }
double ChargeOf(size_t grain) { return grain / kCloud == 1 ? -2e-14 : 2e-14; }

/// All grains at one time.
struct Dust : Frame {
  /// Returns m v - q x cross B + c x [N s], which only rounding changes.
  Vector KeptMomentum() const {
    Vector sum;
    for (size_t i = 0; i < kGrains; ++i) {
      const Vector x = position[i];
      sum += velocity[i] * MassOf(i) - Cross(x, Vector{0, 0, kFlux}) * ChargeOf(i) + x * kDrag;
    }
    return sum;
  }
  double Momentum() const {
    Vector sum;
    for (size_t i = 0; i < kGrains; ++i) sum += velocity[i] * MassOf(i);
    return Length(sum);
  }
  double KineticEnergy() const {
    double sum = 0;
    for (size_t i = 0; i < kGrains; ++i) sum += MassOf(i) / 2 * Dot(velocity[i], velocity[i]);
    return sum;
  }
  double MeanX(size_t cloud) const {
    double sum = 0;
    for (size_t i = cloud * kCloud; i < (cloud + 1) * kCloud; ++i) sum += position[i].x;
    return sum / kCloud;
  }
};

struct DustRun {
  Dust begin, end;
  std::string state_hash;
};

DustRun RunDust(int seconds, int threads) {
  const Folder folder;
  const std::string frames = std::to_string(60 * seconds);
  const Outcome outcome =
      RunProgram(VESPER_COMMAND, {"run", kDust + "charged-dust.vesper", "--laws", VESPER_LAW_PATH,
                                  "--frames", frames, "--every", frames, "--threads",
                                  std::to_string(threads), "--csv", folder / "dust.csv", "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  const std::vector<Frame> written = ReadFrames(ReadText(folder / "dust.csv"));
  EXPECT_EQ(written.size(), 2u);
  return {{written.front()}, {written.back()}, Json::parse(outcome.output)["stateHash"]};
}

void ExpectWithin(const Json& range, double value, const std::string& what) {
  EXPECT_GE(value, range["from"].get<double>()) << what;
  EXPECT_LE(value, range["to"].get<double>()) << what;
}

TEST(ChargedDust, PartsAndKeepsItsBooksOfMomentum) {
  const Json expected = Json::parse(ReadText(kDust + "expected.json"));
  const int seconds = expected["seconds"];
  const DustRun run = RunDust(seconds, 1);
  ASSERT_EQ(run.end.position.size(), kGrains);
  const double error = Length(run.end.KeptMomentum() - run.begin.KeptMomentum());
  ExpectWithin(expected["momentumError"], error / run.begin.Momentum(), "momentum error");
  ExpectWithin(expected["kineticEnergyLeft"], run.end.KineticEnergy() / run.begin.KineticEnergy(),
               "kinetic energy left");
  const std::array<std::string, 3> clouds = {"light", "negative", "heavy"};
  for (size_t cloud = 0; cloud < clouds.size(); ++cloud) {
    ExpectWithin(expected["meanX"][clouds[cloud]], run.end.MeanX(cloud), clouds[cloud]);
  }
  EXPECT_EQ(RunDust(1, 1).state_hash, RunDust(1, 2).state_hash);
}

}  // namespace
}  // namespace vesper
