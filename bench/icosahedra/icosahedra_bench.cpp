// SPDX-License-Identifier: Apache-2.0
// Simulates a thousand icosahedra of springs and surfaces that fall on a ground and rest there.
// Measures frames of 1/60 s per second. Prints a line of JSON; see docs/benchmarks.md.
//   icosahedra_bench FOLDER_OF_LAWS si-f32|si-f64 THREADS [SPACING]
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "icosahedron.hpp"
#include "vesper/vesper.hpp"

namespace {

namespace icosahedron = vesper::icosahedron;

constexpr int kIcosahedra = 1000;
constexpr uint32_t kStepsPerFrame = 2;
constexpr double kDt = 1.0 / 60 / kStepsPerFrame;  // [s]
constexpr uint32_t kSettle = 60;                   // frames before the timed ones
constexpr uint32_t kFrames = 300;                  // timed frames

template <class Real>
struct Icosahedra {
  std::vector<Real> mass, position, velocity, force;
  std::vector<Real> length, hooke, spring_damping;
  std::vector<Real> hardness, surface_damping, friction;
  std::vector<uint32_t> endpoints, vertices;
  std::vector<Real> gravity = {0, Real(-9.81), 0};

  explicit Icosahedra(double spacing) {
    AddBody(0, -3000, 0, -3000);
    AddBody(0, 0, 0, 6000);
    AddBody(0, 3000, 0, -3000);
    AddSurface(0, {0, 1, 2});
    const int side = static_cast<int>(std::lround(std::sqrt(kIcosahedra)));
    for (int i = 0; i < kIcosahedra; ++i) {
      AddIcosahedron(spacing * (i % side - side / 2), 1.2, spacing * (i / side - side / 2));
    }
  }

  vesper::PhysicsEngine MakeEngine(const std::string& laws, uint32_t threads) {
    vesper::PhysicsEngine engine(sizeof(Real) == 4 ? "si-f32" : "si-f64",
                                 {.threads = threads, .law_path = laws});
    auto provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass);
    provider.AddPhysicalProperty("position", position);
    provider.AddPhysicalProperty("velocity", velocity);
    provider.AddPhysicalProperty("externalForce", force);
    provider.AddPhysicalProperty("endpoints", endpoints);
    provider.AddPhysicalProperty("length", length);
    provider.AddPhysicalProperty("hookeConstant", hooke);
    provider.AddPhysicalProperty("dampingConstant", spring_damping);
    provider.AddPhysicalProperty("vertices", vertices);
    provider.AddPhysicalProperty("hardness", hardness);
    provider.AddPhysicalProperty("surfaceDamping", surface_damping);
    provider.AddPhysicalProperty("frictionCoefficient", friction);
    provider.AddPhysicalProperty("gravity", gravity);
    for (const char* law : {"gravity_field", "hooke_spring", "surface_contact", "newton_motion"}) {
      engine.LoadPhysicsLaw(law);
    }
    return engine;
  }

  /// Returns the mean height of all corners [m]. It is near the radius of 1 m if the bodies are
  /// intact and on the ground.
  double MeanHeight() const {
    double sum = 0;
    for (size_t i = 3; i < mass.size(); ++i) sum += double{position[3 * i + 1]};
    return sum / static_cast<double>(mass.size() - 3);
  }

 private:
  void AddBody(double m, double x, double y, double z) {
    mass.push_back(Real(m));
    position.insert(position.end(), {Real(x), Real(y), Real(z)});
    velocity.insert(velocity.end(), {0, 0, 0});
    force.insert(force.end(), {0, 0, 0});
  }

  void AddSurface(uint32_t first, const std::array<uint32_t, 3>& face) {
    for (const uint32_t corner : face) vertices.push_back(first + corner);
    hardness.push_back(10000);
    surface_damping.push_back(50);
    friction.push_back(Real(0.5));
  }

  void AddIcosahedron(double x, double y, double z) {
    const auto first = static_cast<uint32_t>(mass.size());
    for (const auto& p : icosahedron::Corners()) AddBody(1, x + p[0], y + p[1], z + p[2]);
    for (const auto& face : icosahedron::kFaces) AddSurface(first, face);
    for (const auto& [a, b] : icosahedron::Edges()) {
      endpoints.insert(endpoints.end(), {first + a, first + b});
      length.push_back(Real(2 * icosahedron::HalfEdge()));
      hooke.push_back(5000);
      spring_damping.push_back(5);
    }
  }
};

template <class Real>
void Measure(const std::string& laws, uint32_t threads, double spacing) {
  Icosahedra<Real> world(spacing);
  vesper::PhysicsEngine engine = world.MakeEngine(laws, threads);
  for (uint32_t frame = 0; frame < kSettle; ++frame) engine.Advance(kDt, kStepsPerFrame);
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  for (uint32_t frame = 0; frame < kFrames; ++frame) engine.Advance(kDt, kStepsPerFrame);
  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double busy = static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;
  std::printf(
      "{\"framesPerSecond\": %.2f, \"framesPerProcessorSecond\": %.2f, "
      "\"meanHeight\": %.4f}\n",
      kFrames / wall, kFrames / busy, world.MeanHeight());
  for (vesper_library_id id = 1; id <= 4; ++id) {
    for (const auto& law : engine.Laws(id)) {
      std::fprintf(stderr, "%-16s %8.1f us per step\n", law.name,
                   1e-3 * static_cast<double>(law.nanoseconds) / static_cast<double>(law.calls));
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr,
                 "usage: icosahedra_bench FOLDER_OF_LAWS si-f32|si-f64 THREADS [SPACING]\n");
    return 2;
  }
  const auto threads = static_cast<uint32_t>(std::atoi(argv[3]));
  const double spacing = argc > 4 ? std::atof(argv[4]) : 10;
  if (std::string(argv[2]) == "si-f32") {
    Measure<float>(argv[1], threads, spacing);
  } else {
    Measure<double>(argv[1], threads, spacing);
  }
}
