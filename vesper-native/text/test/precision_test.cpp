// SPDX-License-Identifier: Apache-2.0
// Properties with another precision than the reals of the world, in laws as text.
#include <cmath>
#include <string>
#include <vector>

#include "text_engine.hpp"
#include "vesper/vesper.hpp"

namespace vesper::test {
namespace {

PreparedLibrary PreparedText(const std::string& text) {
  vesper_prepared_library* prepared = nullptr;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_library_prepare_text("x.law", text.data(), text.size(), &prepared, error);
  }));
  return PreparedLibrary(prepared);
}

/// Two bodies with an additional property `width`, whose precision is not that of the world.
template <class Real, class Wide>
class Widths {
 public:
  explicit Widths(const std::string& base, const std::string& type)
      : prototype_(("prototype w extends " + base + "\nbody width: " + type +
                    " x3 [m] read_write min 0\nbody strain: real x1 [1] read_write\n"
                    "body share: " +
                    type + " x1 [N] accumulate\n")
                       .c_str(),
                   "w.prototype"),
        engine(prototype_.get(), {.law_path = VESPER_TEST_LAWS}) {
    auto provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass);
    provider.AddPhysicalProperty("position", position);
    provider.AddPhysicalProperty("width", width);
    provider.AddPhysicalProperty("strain", strain);
    provider.AddPhysicalProperty("share", share);
  }

  void Run(const std::string& text, double dt) {
    engine.LoadPhysicsLaw(PreparedText(text));
    engine.Advance(dt);
  }

  std::vector<Real> mass{1, 2}, position = std::vector<Real>(6), strain = std::vector<Real>(2);
  std::vector<Wide> width = std::vector<Wide>(6, static_cast<Wide>(0.1));
  std::vector<Wide> share = std::vector<Wide>(2);

 private:
  LoadedPrototype prototype_;

 public:
  PhysicsEngine engine;
};

TEST(PrecisionTest, TextOfSinglePrecisionChangesDoubles) {
  Widths<float, double> bodies("si-f32", "f64");
  bodies.Run(
      "law grow\n  each body:\n    if mass > 1 kg: width += (0.5, 0, 0) m/s dt\n"
      "    strain = width.x / 1 m\n",
      0.25);
  EXPECT_EQ(bodies.width[0], 0.1) << "keeps all bits of a double";
  EXPECT_EQ(bodies.width[3], static_cast<double>(0.1f + 0.125f));
  EXPECT_EQ(bodies.width[4], 0.1);
  EXPECT_EQ(bodies.strain, (std::vector<float>{0.1f, 0.1f + 0.125f}));
  bodies.engine.Advance(0.25);
  EXPECT_EQ(bodies.width[3], static_cast<double>(0.1f + 0.125f + 0.125f));
}

TEST(PrecisionTest, TextOfDoublePrecisionChangesFloats) {
  Widths<double, float> bodies("si-f64", "f32");
  bodies.Run("law grow\n  each body: width.y = 2 width.x\n", 1);
  EXPECT_EQ(bodies.width, (std::vector<float>{0.1f, 0.2f, 0.1f, 0.1f, 0.2f, 0.1f}));
}

TEST(PrecisionTest, PairsReadAndSumThem) {
  Widths<float, double> bodies("si-f32", "f64");
  bodies.position[3] = 3;
  bodies.Run(
      "law press\n  each pair a and b of bodies, r apart:\n"
      "    let p = 1 N/m (r - 10 a.width.x - 10 b.width.x)\n"
      "    a.share += p; b.share -= p\n",
      1);
  EXPECT_NEAR(bodies.share[0], 1, 1e-6);
  EXPECT_EQ(bodies.share[1], -bodies.share[0]);
}

TEST(PrecisionTest, EnergiesDependOnThem) {
  Widths<float, double> bodies("si-f32", "f64");
  std::vector<float> force(6);
  bodies.engine.PropertyProvider().AddPhysicalProperty("externalForce", force);
  bodies.position = {1, 0, 0, 0, 0, 0};
  bodies.width[0] = 0.25;
  const vesper_library_id id = bodies.engine.LoadPhysicsLaw(
      PreparedText("law well\n  each body: energy = 2 N/m^2 width.x position^2\n"));
  bodies.engine.Advance(1);
  EXPECT_EQ(force[0], -1);
  bodies.width[0] = 0.5;
  EXPECT_EQ(bodies.engine.PotentialEnergy(id, 0), 1);
}

TEST(PrecisionTest, ValuesBelowTheMinimumAreRefused) {
  Widths<float, double> bodies("si-f32", "f64");
  try {
    bodies.Run("law shrink\n  each body: width -= (1, 1, 1) m\n", 1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("width"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vesper::test
