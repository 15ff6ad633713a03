// newton_gravitation and newton_motion through the engine, next to a bare kernel that was tuned
// for one processor. Prints a table.
//   all_pairs_bench FOLDER_OF_LAWS [BODIES...]
#include <cmath>
#include <cstdlib>
#include <random>
#include <type_traits>

#include "peers/pairs_avx512.hpp"
#include "side_by_side.hpp"
#include "vesper/vesper.hpp"

namespace {

constexpr int kThreads = 2;
constexpr double kSoftening = 0.01;  // [m]

/// Bodies of 1/n kg in a cube of 2 m, for the engine and for the kernel.
template <class Real>
class World {
 public:
  World(uint64_t n, const char* laws)
      : bodies(n), mass_(n, static_cast<Real>(1.0 / static_cast<double>(n))), position_(3 * n),
        velocity_(3 * n), force_(3 * n),
        engine_(std::is_same_v<Real, double> ? "si-f64" : "si-f32",
                {.threads = kThreads, .validate = false, .law_path = laws}) {
    std::mt19937 random(1);
    for (uint64_t i = 0; i < 3 * n; ++i) {
      position_[i] = static_cast<Real>(random() / 2147483648.0 - 1);
      bodies[static_cast<int>(i % 3)][i / 3] = position_[i];
    }
    for (uint64_t i = 0; i < n; ++i) bodies[3][i] = mass_[i];
    auto provider = engine_.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass_);
    provider.AddPhysicalProperty("position", position_);
    provider.AddPhysicalProperty("velocity", velocity_);
    provider.AddPhysicalProperty("externalForce", force_);
    provider.AddPhysicalProperty("gravitationalConstant", constant_);
    provider.AddPhysicalProperty("softening", softening_);
    engine_.LoadPhysicsLaw("newton_gravitation");
    engine_.LoadPhysicsLaw("newton_motion");
  }

  /// A step so short that nothing moves: the kernel sees the same places.
  void Advance() { engine_.Advance(1e-12); }

  /// Root mean square of what law and kernel differ by, relative to the force.
  double Difference() {
    double square = 0;
    for (uint64_t i = 0; i < bodies.count; ++i) {
      double difference = 0, size = 0;
      for (uint64_t c = 0; c < 3; ++c) {
        const double kernel = static_cast<double>(bodies[static_cast<int>(4 + c)][i]);
        const double law = static_cast<double>(force_[3 * i + c]) / static_cast<double>(mass_[i]);
        difference += (law - kernel) * (law - kernel);
        size += law * law;
      }
      square += difference / size;
    }
    return std::sqrt(square / static_cast<double>(bodies.count));
  }

  bench::Bodies<Real> bodies;

 private:
  std::vector<Real> mass_, position_, velocity_, force_;
  std::vector<Real> constant_ = {1}, softening_ = {static_cast<Real>(kSoftening)};
  vesper::PhysicsEngine engine_;
};

template <class Real, class Kernel>
void Measure(World<Real>& world, const char* precision, Kernel&& kernel) {
  const double n = static_cast<double>(world.bodies.count);
  const auto result = bench::SideBySide([&] { world.Advance(); }, kernel);
  std::printf("| %.0f | %s | %.0f | %.2f | %.2f | %.2f | %.2f | %.1e | %.1f |\n", n, precision,
              1 / result.a.wall, 1e-9 * n * n / result.a.wall, 1e-9 * n * n / result.b.wall,
              result.b.wall / result.a.wall, result.b.processor / result.a.processor,
              world.Difference(), result.foreign);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: all_pairs_bench FOLDER_OF_LAWS [BODIES...]\n");
    return 2;
  }
  if (!__builtin_cpu_supports("avx512f")) {
    std::fprintf(stderr, "the kernel to compare with needs AVX-512\n");
    return 1;
  }
  std::vector<uint64_t> sizes;
  for (int i = 2; i < argc; ++i) sizes.push_back(std::strtoull(argv[i], nullptr, 10) / 64 * 64);
  if (sizes.empty()) sizes = {1536, 16384, 65536};
  std::printf("| bodies | | law, steps/s | law [10^9 interactions/s] | kernel [10^9 interactions/s] "
              "| ratio | ratio of processor time | difference | others' processors |\n"
              "|---:|---|---:|---:|---:|---:|---:|---:|---:|\n");
  const double softening2 = kSoftening * kSoftening;
  for (const uint64_t n : sizes) {
    World<float> world(n, argv[1]);
    bench::ThirdLawKernel kernel(world.bodies, kThreads);
    Measure(world, "f32", [&] { kernel.Run(static_cast<float>(softening2)); });
    World<double> wide(n, argv[1]);
    Measure(wide, "f64", [&] { bench::RunBothSides(wide.bodies, softening2, kThreads); });
  }
}
