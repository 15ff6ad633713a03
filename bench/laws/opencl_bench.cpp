// SPDX-License-Identifier: Apache-2.0
// Compares the OpenCL laws in the engine with the usual kernel without an engine. Also measures
// these laws together with a law of the CPU, and with all arrays copied back. Prints a table.
//   opencl_bench FOLDER_OF_LAWS [--quick] [BODIES...]
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <random>

#include "peers/soa_kernel.hpp"
#include "side_by_side.hpp"
#include "vesper/vesper.hpp"

namespace {

constexpr float kSoftening = 0.01f;  // [m]

/// Bodies of mass 1/n kg in a cube of 2 m.
class World {
 public:
  World(uint64_t n, const char* folder, std::initializer_list<const char*> laws)
      : columns{std::vector<float>(n), std::vector<float>(n), std::vector<float>(n),
                std::vector<float>(n, 1 / static_cast<float>(n))},
        position_(3 * n),
        velocity_(3 * n),
        force_(3 * n),
        engine_("si-f32", {.threads = 2, .law_path = folder, .deferred = true}) {
    std::mt19937 random(1);
    for (uint64_t i = 0; i < 3 * n; ++i) {
      position_[i] = static_cast<float>(random() / 2147483648.0 - 1);
      columns[i % 3][i / 3] = position_[i];
    }
    auto provider = engine_.PropertyProvider();
    provider.AddPhysicalProperty("mass", columns[3]);
    provider.AddPhysicalProperty("position", position_);
    provider.AddPhysicalProperty("velocity", velocity_);
    provider.AddPhysicalProperty("externalForce", force_);
    provider.AddPhysicalProperty("gravitationalConstant", constant_);
    provider.AddPhysicalProperty("softening", softening_);
    for (const char* law : laws) engine_.LoadPhysicsLaw(law);
  }

  /// Runs one frame: a step, and a copy of the positions to the host.
  void Advance() {
    engine_.Advance(1e-12);
    engine_.Synchronize({"position"});
  }

  /// Runs one frame, and copies velocities and forces too.
  void AdvanceAll() {
    engine_.Advance(1e-12);
    engine_.Synchronize();
  }

  std::array<std::vector<float>, 4> columns;  // x, y, z, mass

 private:
  std::vector<float> position_, velocity_, force_;
  std::vector<float> constant_ = {1}, softening_ = {kSoftening};
  vesper::PhysicsEngine engine_;
};

void PrintRow(uint64_t n, const char* what, const bench::Comparison& result) {
  std::printf("| %lu | %s | %.4g | %.4g | %.2f | %.2f | %.1f |\n", n, what, 1 / result.a.wall,
              1 / result.b.wall, result.b.wall / result.a.wall,
              result.b.processor / result.a.processor, result.foreign);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: opencl_bench FOLDER_OF_LAWS [--quick] [BODIES...]\n");
    return 2;
  }
  std::vector<uint64_t> sizes;
  const bool quick = argc > 2 && std::strcmp(argv[2], "--quick") == 0;
  for (int i = quick ? 3 : 2; i < argc; ++i) {
    sizes.push_back(std::strtoull(argv[i], nullptr, 10));
  }
  const auto compare = [quick](auto&& a, auto&& b) {
    return quick ? bench::SideBySide(a, b, 1, 0.02) : bench::SideBySide(a, b);
  };
  if (sizes.empty()) sizes = {1536, 16384, 65536};
  std::printf(
      "| bodies | A, next to B | A, frames/s | B, frames/s | ratio | ratio of processor "
      "time | others' processors |\n|---:|---|---:|---:|---:|---:|---:|\n");
  for (const uint64_t n : sizes) {
    World whole(n, argv[1], {"opencl_nbody"});
    World mixed(n, argv[1], {"opencl_gravitation", "newton_motion"});
    bench::SoaKernel kernel(whole.columns);
    PrintRow(n, "`opencl_nbody`, next to the bare kernel",
             compare([&] { whole.Advance(); }, [&] { kernel.Run(kSoftening * kSoftening); }));
    PrintRow(n, "`opencl_gravitation` and `newton_motion`, next to `opencl_nbody`",
             compare([&] { mixed.Advance(); }, [&] { whole.Advance(); }));
    PrintRow(n, "`opencl_nbody` with all arrays back, next to positions only",
             compare([&] { whole.AdvanceAll(); }, [&] { whole.Advance(); }));
  }
}
