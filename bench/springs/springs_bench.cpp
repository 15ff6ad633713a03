// SPDX-License-Identifier: Apache-2.0
// Compares hooke_spring and newton_motion in the engine with a bare loop tuned for one processor,
// on a square cloth whose springs are in row order or in random order. Prints a table.
//   springs_bench FOLDER_OF_LAWS [SIDE...]
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <utility>

#include "laws/side_by_side.hpp"
#include "peers/springs_avx512.hpp"
#include "vesper/vesper.hpp"

namespace {

constexpr double kDt = 1e-4;        // [s]
constexpr float kSpacing = 0.01f;   // [m]
constexpr float kHooke = 20;        // [N/m]
constexpr float kDamping = 0.005f;  // [N s/m]

/// side x side bodies of 1 g, each with springs to its direct and diagonal neighbours.
struct Cloth {
  std::vector<float> mass, position, length;
  std::vector<std::array<uint32_t, 2>> ends;

  Cloth(uint32_t side, bool shuffled) : mass(side * side, 0.001f), position(3 * side * side) {
    for (uint32_t i = 0; i < side * side; ++i) {
      position[3 * i] = static_cast<float>(i % side) * kSpacing;
      position[3 * i + 2] = static_cast<float>(i / side) * kSpacing;
      const bool right = i % side + 1 < side, below = i / side + 1 < side;
      if (right) ends.push_back({i, i + 1});
      if (below) ends.push_back({i, i + side});
      if (right && below) {
        ends.push_back({i, i + side + 1});
        ends.push_back({i + 1, i + side});
      }
    }
    std::mt19937 random(1);
    for (uint64_t i = ends.size() - 1; shuffled && i > 0; --i) {
      std::swap(ends[i], ends[random() % (i + 1)]);
    }
    for (const auto& [a, b] : ends) {
      const float dx = position[3 * a] - position[3 * b];
      const float dz = position[3 * a + 2] - position[3 * b + 2];
      length.push_back(0.99f * std::sqrt(dx * dx + dz * dz));
    }
  }
};

/// The cloth simulated by the engine.
template <class Real>
class Law {
 public:
  Law(Cloth cloth, uint32_t threads, const char* laws)
      : mass_(cloth.mass.begin(), cloth.mass.end()),
        position_(cloth.position.begin(), cloth.position.end()),
        velocity_(position_.size()),
        force_(position_.size()),
        length_(cloth.length.begin(), cloth.length.end()),
        hooke_(length_.size(), Real(kHooke)),
        damping_(length_.size(), Real(kDamping)),
        ends_(std::move(cloth.ends)),
        engine_(sizeof(Real) == 8 ? "si-f64" : "si-f32",
                {.threads = threads, .validate = false, .law_path = laws, .deferred = true}) {
    auto provider = engine_.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass_);
    provider.AddPhysicalProperty("position", position_);
    provider.AddPhysicalProperty("velocity", velocity_);
    provider.AddPhysicalProperty("externalForce", force_);
    provider.AddPhysicalProperty("endpoints", std::span(ends_[0].data(), 2 * ends_.size()));
    provider.AddPhysicalProperty("length", length_);
    provider.AddPhysicalProperty("hookeConstant", hooke_);
    provider.AddPhysicalProperty("dampingConstant", damping_);
    engine_.LoadPhysicsLaw("hooke_spring");
    engine_.LoadPhysicsLaw("newton_motion");
  }

  void Advance(uint32_t steps) { engine_.Advance(kDt, steps); }
  const std::vector<Real>& position() const { return position_; }

 private:
  std::vector<Real> mass_, position_, velocity_, force_, length_, hooke_, damping_;
  std::vector<std::array<uint32_t, 2>> ends_;
  vesper::PhysicsEngine engine_;
};

bench::SpringsKernel MakeKernel(const Cloth& cloth, int threads) {
  return {cloth.mass, cloth.position, cloth.ends, cloth.length, kHooke, kDamping, threads};
}

/// Checks that both sides agree within a hundredth of the spacing after a hundred steps.
void CheckAgreement(const Cloth& cloth, const char* laws) {
  Law<float> law(cloth, 1, laws);
  bench::SpringsKernel kernel = MakeKernel(cloth, 1);
  law.Advance(100);
  kernel.Advance(static_cast<float>(kDt), 100);
  float worst = 0;
  for (uint64_t i = 0; i < law.position().size(); ++i) {
    const float other = kernel.position()[i / 3].value[i % 3];
    worst = std::max(worst, std::abs(law.position()[i] - other));
  }
  if (!(worst <= 0.01f * kSpacing)) {
    std::fprintf(stderr, "law and loop differ by %g m\n", static_cast<double>(worst));
    std::exit(1);
  }
}

void Measure(uint32_t side, uint32_t threads, const char* laws) {
  const Cloth cloth(side, false);
  Law<float> grid(cloth, threads, laws), random(Cloth(side, true), threads, laws);
  Law<double> wide(cloth, threads, laws);
  bench::SpringsKernel kernel = MakeKernel(cloth, static_cast<int>(threads));
  constexpr int kSteps = 16;  // starting the loop's threads for each step would be too slow
  const auto advance = [](auto& law) { return [&law] { law.Advance(kSteps); }; };
  const auto beside =
      bench::SideBySide(advance(grid), [&] { kernel.Advance(static_cast<float>(kDt), kSteps); });
  const auto orders = bench::SideBySide(advance(random), advance(grid));
  const auto precisions = bench::SideBySide(advance(wide), advance(grid));
  const double springs = 1e-6 * static_cast<double>(cloth.ends.size());
  std::printf("| %.0f | %s | %.0f | %.0f | %.2f | %.2f | %.2f | %.0f | %.1f |\n", 1e6 * springs,
              threads == 1 ? "1 thread" : "2 threads", kSteps * springs / beside.a.wall,
              kSteps * springs / beside.b.wall, beside.b.wall / beside.a.wall,
              beside.b.processor / beside.a.processor, orders.b.wall / orders.a.wall,
              kSteps * springs / precisions.a.wall,
              std::max({beside.foreign, orders.foreign, precisions.foreign}));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: springs_bench FOLDER_OF_LAWS [SIDE...]\n");
    return 2;
  }
  if (!__builtin_cpu_supports("avx512vl")) {
    std::fprintf(stderr, "springs_bench: this processor has no AVX-512, which the loop needs\n");
    return 1;
  }
  CheckAgreement(Cloth(50, false), argv[1]);
  std::printf(
      "| springs | | law, f32 [10^6 springs/s] | loop, f32 [10^6 springs/s] | ratio "
      "| ratio of processor time | random order / in order | law, f64 [10^6 springs/s] "
      "| others' processors |\n|---:|---|---:|---:|---:|---:|---:|---:|---:|\n");
  std::vector<uint32_t> sides;  // bodies along a side of the cloth
  for (int i = 2; i < argc; ++i) {
    sides.push_back(static_cast<uint32_t>(std::strtoul(argv[i], nullptr, 10)));
  }
  if (sides.empty()) sides = {50, 158, 500};
  for (const uint32_t side : sides) {
    for (const uint32_t threads : {1, 2}) Measure(side, threads, argv[1]);
  }
}
