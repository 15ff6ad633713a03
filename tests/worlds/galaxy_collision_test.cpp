// SPDX-License-Identifier: Apache-2.0
// Two galaxies that collide; here with fewer bodies than the scene has.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "frames.hpp"
#include "program.hpp"

namespace vesper {
namespace {

using Json = nlohmann::json;
using Vector = Vec3<double>;

const std::string kGalaxies = VESPER_WORLDS "/galaxy-collision/";
constexpr uint64_t kFewer = 25;  // times
constexpr size_t kBodies = 100000 / kFewer;

/// Returns the scene with every row number and count divided by kFewer.
std::string SmallScene() {
  std::string text = ReadText(kGalaxies + "galaxy-collision.vesper");
  for (const uint64_t rows : {100000, 75000, 50000, 25000}) {
    const auto replace = [&](uint64_t number, uint64_t by) {
      text = std::regex_replace(text, std::regex("\\b" + std::to_string(number) + "\\b"),
                                std::to_string(by));
    };
    replace(rows, rows / kFewer);
    replace(rows - 1, rows / kFewer - 1);
  }
  return text;
}

Vector Momentum(const Frame& bodies) {
  Vector sum;
  for (size_t i = 0; i < bodies.size(); ++i) sum += bodies.velocity[i] * bodies.mass[i];
  return sum;
}

/// Returns the kinetic energy plus the potential energy of all pairs, with G = 1 and the scene's
/// softening of 0.1.
double Energy(const Frame& bodies) {
  double energy = 0;
  for (size_t i = 0; i < bodies.size(); ++i) {
    energy += 0.5 * bodies.mass[i] * Dot(bodies.velocity[i], bodies.velocity[i]);
    for (size_t j = 0; j < i; ++j) {
      const Vector d = bodies.position[i] - bodies.position[j];
      energy -= bodies.mass[i] * bodies.mass[j] / std::sqrt(Dot(d, d) + 0.01);
    }
  }
  return energy;
}

/// Returns the distance between the densest regions, which are at the medians of the coordinates of
/// each galaxy.
double Separation(const Frame& bodies) {
  const auto median = [&](size_t begin, double Vector::* coordinate) {
    std::vector<double> values;
    for (size_t i = begin; i < begin + kBodies / 2; ++i) {
      values.push_back(bodies.position[i].*coordinate);
    }
    std::ranges::nth_element(values, values.begin() + kBodies / 4);
    return values[kBodies / 4];
  };
  const auto centre = [&](size_t begin) {
    return Vector{median(begin, &Vector::x), median(begin, &Vector::y), median(begin, &Vector::z)};
  };
  return Length(centre(0) - centre(kBodies / 2));
}

double Largest(const Frame& bodies) {
  double largest = 0;
  for (const Vector& x : bodies.position) largest = std::max(largest, Length(x));
  return largest;
}

class GalaxyCollisionTest : public ::testing::Test {
 protected:
  void ExpectWithin(const char* name, double value) const {
    EXPECT_GE(value, expected_.at(name).at("from").get<double>()) << name;
    EXPECT_LE(value, expected_.at(name).at("to").get<double>()) << name;
  }

  const Json expected_ = Json::parse(ReadText(kGalaxies + "expected.json"));
};

TEST_F(GalaxyCollisionTest, IsBoundByTheFirstPassageAndKeepsEnergyMomentumAndBodies) {
  const Folder folder;
  const std::string frames = std::to_string(expected_.at("frames").get<int>());
  const std::string half = std::to_string(expected_.at("frames").get<int>() / 2);
  const Outcome outcome = RunProgram(
      VESPER_COMMAND, {"run", folder.Write("small.vesper", SmallScene()), "--laws", VESPER_LAW_PATH,
                       "--frames", frames, "--every", half, "--csv", folder / "frames.csv"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const std::vector<Frame> run = ReadFrames(ReadText(folder / "frames.csv"));
  ASSERT_EQ(run.size(), 3u);
  for (const Frame& bodies : run) ASSERT_EQ(bodies.size(), kBodies);
  const double energy = Energy(run.front());
  ExpectWithin("energyDrift", std::abs(Energy(run.back()) / energy - 1));
  ExpectWithin("momentum", Length(Momentum(run.back())));
  ExpectWithin("separationAtStart", Separation(run.front()));
  ExpectWithin("separationHalfWay", Separation(run[1]));
  ExpectWithin("separationAtEnd", Separation(run.back()));
  ExpectWithin("farthestBody", Largest(run.back()));
}

}  // namespace
}  // namespace vesper
