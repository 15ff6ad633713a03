// SPDX-License-Identifier: Apache-2.0
// Tests the statement `galaxy` of scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "scene.hpp"
#include "vesper/law.hpp"

namespace vesper::cli {
namespace {

using Vector = Vec3<double>;

constexpr uint64_t kBodies = 4000, kDisc = kBodies / 2;
constexpr auto kLine =
    "galaxy 0..3999: mass 3 radius 2 at (7 8 9) moving (1 -2 3) axis (1 1 0) seed ";

Scene Galaxy(const std::string& line) {
  return ParseScene(
      "scene 1\ndt 1\nrows world 1\ngravitationalConstant 5\nrows body 4001\n"
      "mass all 1\nposition all (0 0 0)\nvelocity all (0 0 0)\n" +
          line,
      "s");
}

/// Bodies of one galaxy.
struct Bodies {
  explicit Bodies(const Scene& scene)
      : mass(*scene.Find("mass")),
        position(*scene.Find("position")),
        velocity(*scene.Find("velocity")) {}

  template <class Each>
  auto MeanOf(Each each) const {
    decltype(each(0)) sum{};
    double all = 0;
    for (uint64_t i = 0; i < kBodies; ++i) {
      sum += each(i) * mass.Get(i);
      all += mass.Get(i);
    }
    return sum * (1 / all);
  }

  const AnyColumn &mass, &position, &velocity;
};

TEST(GalaxyTest, HasTheMassThePlaceAndTheVelocityThatItIsGiven) {
  const Scene scene = Galaxy(kLine + std::string("1"));
  const Bodies bodies(scene);
  double mass = 0;
  for (uint64_t i = 0; i < kBodies; ++i) mass += bodies.mass.Get(i);
  EXPECT_NEAR(mass, 3, 1e-12);
  const Vector at = bodies.MeanOf([&](uint64_t i) { return bodies.position.GetVector(i); });
  const Vector moving = bodies.MeanOf([&](uint64_t i) { return bodies.velocity.GetVector(i); });
  EXPECT_LT(Length(at - Vector{7, 8, 9}), 1e-12);
  EXPECT_LT(Length(moving - Vector{1, -2, 3}), 1e-12);
}

TEST(GalaxyTest, LeavesOtherRowsAlone) {
  const Scene scene = Galaxy(kLine + std::string("1"));
  EXPECT_EQ(scene.Find("mass")->Get(kBodies), 1);
  EXPECT_EQ(scene.Find("position")->GetVector(kBodies), Vector{});
}

TEST(GalaxyTest, TheFirstHalfIsAFlatDiscThatTurnsAboutTheAxis) {
  const Scene scene = Galaxy(kLine + std::string("1"));
  const Bodies bodies(scene);
  const Vector axis = Vector{1, 1, 0} * std::sqrt(0.5);
  Vector turning;
  double height = 0, width = 0;
  for (uint64_t i = 0; i < kDisc; ++i) {
    const Vector x = bodies.position.GetVector(i) - Vector{7, 8, 9};
    turning += Cross(x, bodies.velocity.GetVector(i) - Vector{1, -2, 3});
    height += Dot(x, axis) * Dot(x, axis);
    width += Dot(x, x);
  }
  EXPECT_GT(Dot(turning, axis), 0.99 * Length(turning));
  EXPECT_LT(height, 0.01 * width);
}

TEST(GalaxyTest, IsNearlyInEquilibrium) {
  const Scene scene = Galaxy(kLine + std::string("1"));
  const Bodies bodies(scene);
  double kinetic = 0, potential = 0;
  for (uint64_t i = 0; i < kBodies; ++i) {
    const Vector v = bodies.velocity.GetVector(i) - Vector{1, -2, 3};
    kinetic += 0.5 * bodies.mass.Get(i) * Dot(v, v);
    for (uint64_t j = 0; j < i; ++j) {
      const double r = Length(bodies.position.GetVector(i) - bodies.position.GetVector(j));
      potential -= 5 * bodies.mass.Get(i) * bodies.mass.Get(j) / r;
    }
  }
  EXPECT_NEAR(-2 * kinetic / potential, 1, 0.1);  // the virial theorem
}

TEST(GalaxyTest, IsGivenByItsSeed) {
  const auto first = [](const std::string& seed) {
    return Galaxy(kLine + seed).Find("position")->GetVector(0);
  };
  EXPECT_EQ(first("1"), first("1"));
  EXPECT_NE(first("1"), first("2"));
}

TEST(GalaxyTest, SaysWhatIsWrong) {
  const auto error_of = [](const std::string& line) -> std::string {
    try {
      Galaxy(line);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_of("galaxy 0: mass 1"), "s:9:8: expected the numbers of at least 2 rows");
  EXPECT_EQ(error_of("galaxy 0..9: mass 0 radius 1"), "s:9:19: expected a mass above 0");
  EXPECT_EQ(error_of("galaxy 0..9: mass 1 radius 1 at (0 0)"), "s:9:37: expected 'at (x y z)'");
  EXPECT_EQ(error_of("galaxy 0..9: mass 1 radius 1 at (0 0 0) moving (0 0 0) axis (0 0 0) seed 1"),
            "s:9:67: expected an axis longer than 0");
  EXPECT_EQ(error_of("galaxy 0..9: mass 1 [kg]"),
            "s:9:21: a galaxy is made of several quantities, each in its property's unit");
  try {
    ParseScene("scene 1\ndt 1\nrows body 2\ngalaxy 0..1: mass 1", "s");
    FAIL() << "took it";
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(), "s:4:1: needs 'mass', given before");
  }
}

}  // namespace
}  // namespace vesper::cli
