// SPDX-License-Identifier: Apache-2.0
// Simulates a block of balls, ten high, that falls on a floor and becomes a pile. Measures frames
// of 1/60 s per second. Prints a line of JSON; see docs/benchmarks.md.
//   spheres_bench FOLDER_OF_LAWS BODIES THREADS
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "vesper/vesper.hpp"

namespace {

constexpr uint32_t kStepsPerFrame = 10;
constexpr double kDt = 1.0 / 60 / kStepsPerFrame;  // [s]
constexpr uint32_t kSettle = 60;                   // frames before the timed ones
constexpr uint32_t kFrames = 20;                   // timed frames
constexpr double kStiffness = 6e4;                 // [N/m]
constexpr int kLayers = 10;

/// Balls of 1 kg and 1 m diameter.
struct Balls {
  std::vector<float> mass, radius, position, velocity, force;
  std::vector<float> inertia, spin, orientation, torque;
  std::vector<float> gravity = {0, -9.81f, 0};

  explicit Balls(int count) {
    std::mt19937 random(1);
    const auto place = [&](int i) {
      return static_cast<float>(1.1 * i + 0.1 * random() / 4294967296.0 - 0.05);
    };
    const int side = std::max(1, static_cast<int>(std::lround(std::sqrt(count / double{kLayers}))));
    for (int i = 0; i < count; ++i) {
      mass.push_back(1);
      radius.push_back(0.5f);
      const float x = place(i % side), z = place(i / side % side);
      const float y = 0.6f + place(i / side / side);
      position.insert(position.end(), {x, y, z});
      inertia.insert(inertia.end(), {0.1f, 0.1f, 0.1f});
      orientation.insert(orientation.end(), {0, 0, 0, 1});
    }
    for (auto* zeros : {&velocity, &force, &spin, &torque}) zeros->resize(position.size());
  }

  vesper::PhysicsEngine MakeEngine(const std::string& laws, uint32_t threads) {
    vesper::PhysicsEngine engine("si-f32", {.threads = threads, .law_path = laws});
    auto provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass);
    provider.AddPhysicalProperty("radius", radius);
    provider.AddPhysicalProperty("position", position);
    provider.AddPhysicalProperty("velocity", velocity);
    provider.AddPhysicalProperty("externalForce", force);
    provider.AddPhysicalProperty("inertia", inertia);
    provider.AddPhysicalProperty("angularVelocity", spin);
    provider.AddPhysicalProperty("orientation", orientation);
    provider.AddPhysicalProperty("torque", torque);
    provider.AddPhysicalProperty("gravity", gravity);
    engine.LoadPhysicsLaw("gravity_field");
    engine.LoadPhysicsLaw("sphere_contact", {{"stiffness", kStiffness}, {"floorHeight", 0}});
    engine.LoadPhysicsLaw("newton_motion");
    engine.LoadPhysicsLaw("angular_motion");
    return engine;
  }

  /// Returns the largest overlap of two balls, or of a ball and the floor [m]. Checks all pairs of
  /// balls whose x coordinates are near each other.
  double DeepestOverlap() const {
    std::vector<size_t> rows(mass.size());
    for (size_t i = 0; i < rows.size(); ++i) rows[i] = i;
    std::sort(rows.begin(), rows.end(),
              [&](size_t a, size_t b) { return position[3 * a] < position[3 * b]; });
    double deepest = 0;
    for (size_t a = 0; a < rows.size(); ++a) {
      const float* p = &position[3 * rows[a]];
      deepest = std::max(deepest, 0.5 - double{p[1]});
      for (size_t b = a + 1; b < rows.size() && position[3 * rows[b]] < p[0] + 1; ++b) {
        const float* q = &position[3 * rows[b]];
        deepest = std::max(
            deepest, 1 - std::hypot(double{p[0]} - q[0], double{p[1]} - q[1], double{p[2]} - q[2]));
      }
    }
    return deepest;
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: spheres_bench FOLDER_OF_LAWS BODIES THREADS\n");
    return 2;
  }
  Balls balls(std::atoi(argv[2]));
  vesper::PhysicsEngine engine =
      balls.MakeEngine(argv[1], static_cast<uint32_t>(std::atoi(argv[3])));
  double deepest = 0;
  for (uint32_t frame = 0; frame < kSettle; ++frame) {
    engine.Advance(kDt, kStepsPerFrame);
    if (frame % 5 == 0) deepest = std::max(deepest, balls.DeepestOverlap());
  }
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  for (uint32_t frame = 0; frame < kFrames; ++frame) engine.Advance(kDt, kStepsPerFrame);
  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double busy = static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;
  std::printf(
      "{\"framesPerSecond\": %.3f, \"framesPerProcessorSecond\": %.3f, "
      "\"deepestOverlap\": %.4f}\n",
      kFrames / wall, kFrames / busy, std::max(deepest, balls.DeepestOverlap()));
}
