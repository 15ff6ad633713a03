// SPDX-License-Identifier: Apache-2.0
// Simulates boxes under gravity with the law rigid_contact, and measures frames of 1/60 s per
// second. Prints a line of JSON; see docs/benchmarks.md.
//   bodies_bench FOLDER_OF_LAWS SCENE BOXES STEPS SLEEP POSES   simulates, and writes POSES
//   bodies_bench POSES                                          prints the deepest overlap
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "vesper/vesper.hpp"

namespace {

constexpr double kFrame = 1.0 / 60;  // [s]
constexpr int kTimed = 60;           // timed frames
constexpr int kLayers = 10;

using Point = std::array<double, 3>;

/// A sequence of numbers in [-0.5, 0.5) that is the same in JoltBodies.java.
class Sequence {
 public:
  double Next() {
    state_ = state_ * 1664525u + 1013904223u;
    return state_ / 4294967296.0 - 0.5;
  }

 private:
  uint32_t state_ = 1;
};

/// Boxes of 1 m and 1 kg, at most one ball, and a floor whose top is at y = 0.
struct Bodies {
  std::vector<float> mass, position, velocity, force, spin, orientation, inertia;
  std::vector<int32_t> shape;
  std::vector<double> size;
  std::vector<float> gravity = {0, -9.81f, 0};
  std::vector<float> floor_place = {0, -1, 0}, floor_turn = {0, 0, 0, 1};
  std::vector<int32_t> floor_shape = {2};
  std::vector<double> floor_size = {1000, 2, 1000};
  int settle = 120;  // frames before the timed ones

  void Add(int32_t code, double extent, double weight, Point at, Point moving = {}) {
    shape.push_back(code);
    mass.push_back(float(weight));
    for (int k = 0; k < 3; ++k) {
      size.push_back(extent);
      position.push_back(float(at[k]));
      velocity.push_back(float(moving[k]));
    }
    orientation.insert(orientation.end(), {0, 0, 0, 1});
    for (auto* zeros : {&force, &spin, &inertia}) zeros->insert(zeros->end(), {0, 0, 0});
  }

  Bodies(const std::string& scene, int count) {
    const int32_t box = 2, ball = 1;
    if (scene == "pile") {
      Sequence sequence;
      const int side = std::max(1, int(std::lround(std::sqrt(count / double{kLayers}))));
      const auto place = [&](int i) { return 1.1 * i + 0.1 * sequence.Next(); };
      for (int i = 0; i < count; ++i) {
        const double x = place(i % side), z = place(i / side % side);
        Add(box, 1, 1, {x, 0.6 + place(i / side / side), z});
      }
    } else if (scene == "stacks") {
      const int side = std::max(1, int(std::lround(std::sqrt(count / double{kLayers}))));
      for (int i = 0; i < count; ++i) {
        const int stack = i / kLayers;
        Add(box, 1, 1, {3.0 * (stack % side), 0.5 + i % kLayers, 3.0 * (stack / side)});
      }
    } else {  // wall
      settle = 0;
      const int side = int(std::lround(std::sqrt(double(count))));
      for (int i = 0; i < count; ++i) {
        const int row = i / side;
        Add(box, 1, 1, {i % side + 0.5 * (row % 2) - 0.5 * side, 0.5 + row, 0});
      }
      Add(ball, 2, 40, {0, 5, -6}, {0, 0, 20});
    }
  }

  vesper::PhysicsEngine MakeEngine(const std::string& laws, double sleep) {
    vesper::PhysicsEngine engine("si-f32", {.threads = 1, .law_path = laws});
    auto provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass);
    provider.AddPhysicalProperty("position", position);
    provider.AddPhysicalProperty("velocity", velocity);
    provider.AddPhysicalProperty("externalForce", force);
    provider.AddPhysicalProperty("angularVelocity", spin);
    provider.AddPhysicalProperty("orientation", orientation);
    provider.AddPhysicalProperty("inertia", inertia);
    provider.AddPhysicalProperty("shape", shape);
    provider.AddPhysicalProperty("size", size);
    provider.AddPhysicalProperty("gravity", gravity);
    provider.AddPhysicalProperty("sceneryShape", floor_shape);
    provider.AddPhysicalProperty("scenerySize", floor_size);
    provider.AddPhysicalProperty("sceneryPosition", floor_place);
    provider.AddPhysicalProperty("sceneryOrientation", floor_turn);
    engine.LoadPhysicsLaw("gravity_field");
    engine.LoadPhysicsLaw("rigid_contact", {{"sleepTime", sleep}});
    return engine;
  }

  /// Appends the poses of all boxes: place and quaternion.
  void Write(std::FILE* file) const {
    for (size_t i = 0; i < mass.size(); ++i) {
      if (shape[i] != 2) continue;
      const float *p = &position[3 * i], *q = &orientation[4 * i];
      std::fprintf(file, "%.7g %.7g %.7g %.7g %.7g %.7g %.7g\n", p[0], p[1], p[2], q[0], q[1], q[2],
                   q[3]);
    }
    std::fprintf(file, "\n");
  }
};

double Dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point Cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The pose of a box of 1 m.
struct Pose {
  Point at;
  std::array<Point, 3> axes;

  double Reach(const Point& along) const {
    return 0.5 * (std::abs(Dot(axes[0], along)) + std::abs(Dot(axes[1], along)) +
                  std::abs(Dot(axes[2], along)));
  }
};

/// Returns the overlap of two boxes along the best of their 15 separating axes [m]; 0 for none.
double Overlap(const Pose& a, const Pose& b) {
  const Point way{b.at[0] - a.at[0], b.at[1] - a.at[1], b.at[2] - a.at[2]};
  double least = 1;
  const auto try_axis = [&](Point axis) {
    const double length = std::sqrt(Dot(axis, axis));
    if (length < 1e-3) return;
    for (double& x : axis) x /= length;
    least = std::min(least, a.Reach(axis) + b.Reach(axis) - std::abs(Dot(way, axis)));
  };
  for (const Point& axis : a.axes) try_axis(axis);
  for (const Point& axis : b.axes) try_axis(axis);
  for (const Point& p : a.axes) {
    for (const Point& q : b.axes) try_axis(Cross(p, q));
  }
  return std::max(0.0, least);
}

double DeepestOverlap(std::vector<Pose>& boxes) {
  std::sort(boxes.begin(), boxes.end(),
            [](const Pose& x, const Pose& y) { return x.at[0] < y.at[0]; });
  double deepest = 0;
  for (size_t i = 0; i < boxes.size(); ++i) {
    deepest = std::max(deepest, boxes[i].Reach({0, 1, 0}) - boxes[i].at[1]);
    for (size_t k = i + 1; k < boxes.size() && boxes[k].at[0] < boxes[i].at[0] + 1.75; ++k) {
      deepest = std::max(deepest, Overlap(boxes[i], boxes[k]));
    }
  }
  return deepest;
}

/// Prints the deepest overlap of all states in a file.
int Measure(const char* path) {
  std::FILE* file = std::fopen(path, "r");
  if (file == nullptr) {
    std::fprintf(stderr, "cannot read %s\n", path);
    return 2;
  }
  std::vector<Pose> boxes;
  double deepest = 0;
  char line[256];
  while (std::fgets(line, sizeof line, file) != nullptr) {
    double p[3], q[4];
    if (std::sscanf(line, "%lf %lf %lf %lf %lf %lf %lf", p, p + 1, p + 2, q, q + 1, q + 2, q + 3) !=
        7) {
      deepest = std::max(deepest, DeepestOverlap(boxes));
      boxes.clear();
      continue;
    }
    const auto [x, y, z, w] = std::array{q[0], q[1], q[2], q[3]};
    boxes.push_back({{p[0], p[1], p[2]},
                     {Point{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                      Point{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                      Point{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}}});
  }
  std::fclose(file);
  std::printf("{\"deepestOverlap\": %.5f}\n", deepest);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2) return Measure(argv[1]);
  if (argc != 7) {
    std::fprintf(stderr,
                 "usage: bodies_bench FOLDER_OF_LAWS SCENE BOXES STEPS SLEEP POSES\n"
                 "       bodies_bench POSES\n");
    return 2;
  }
  Bodies bodies(argv[2], std::atoi(argv[3]));
  const auto steps = static_cast<uint32_t>(std::atoi(argv[4]));
  const double sleep = std::atof(argv[5]);
  std::FILE* poses = std::fopen(argv[6], "w");
  if (poses == nullptr) {
    std::fprintf(stderr, "cannot write %s\n", argv[6]);
    return 2;
  }
  vesper::PhysicsEngine engine = bodies.MakeEngine(argv[1], sleep);
  const int settle = sleep > 0 ? 600 : bodies.settle, timed = sleep > 0 ? 10 * kTimed : kTimed;
  for (int frame = 0; frame < settle; ++frame) engine.Advance(kFrame / steps, steps);
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  for (int frame = 0; frame < timed; ++frame) engine.Advance(kFrame / steps, steps);
  const double busy = static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;
  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  bodies.Write(poses);
  std::fclose(poses);
  std::printf("{\"framesPerSecond\": %.3f, \"framesPerProcessorSecond\": %.3f}\n", timed / wall,
              timed / busy);
}
