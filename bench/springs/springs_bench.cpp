// hooke_spring through the engine on a square cloth, its springs given row by row and in random
// order. Prints a table.
//   springs_bench FOLDER_OF_LAWS
#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "side_by_side.hpp"
#include "vesper/vesper.hpp"

namespace {

constexpr float kSpacing = 0.01f;  // [m]

/// side x side bodies of 1 g, each with springs to its neighbours along the sides and across.
class Cloth {
 public:
  Cloth(uint32_t side, bool shuffled, const char* laws)
      : mass_(side * side, 0.001f), position_(3 * side * side), velocity_(3 * side * side),
        force_(3 * side * side),
        engine_("si-f32", {.threads = 2, .validate = false, .law_path = laws}) {
    for (uint32_t i = 0; i < side * side; ++i) {
      position_[3 * i] = static_cast<float>(i % side) * kSpacing;
      position_[3 * i + 2] = static_cast<float>(i / side) * kSpacing;
      const bool right = i % side + 1 < side, below = i / side + 1 < side;
      if (right) ends_.push_back({i, i + 1});
      if (below) ends_.push_back({i, i + side});
      if (right && below) {
        ends_.push_back({i, i + side + 1});
        ends_.push_back({i + 1, i + side});
      }
    }
    std::mt19937 random(1);
    for (uint64_t i = ends_.size() - 1; shuffled && i > 0; --i) {
      std::swap(ends_[i], ends_[random() % (i + 1)]);
    }
    for (const auto& [a, b] : ends_) {
      const float dx = position_[3 * a] - position_[3 * b];
      const float dz = position_[3 * a + 2] - position_[3 * b + 2];
      length_.push_back(0.99f * std::sqrt(dx * dx + dz * dz));
    }
    hooke_.assign(ends_.size(), 20);
    damping_.assign(ends_.size(), 0.005f);
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

  void Advance() { engine_.Advance(1e-4); }
  double springs() const { return static_cast<double>(ends_.size()); }

 private:
  std::vector<float> mass_, position_, velocity_, force_, length_, hooke_, damping_;
  std::vector<std::array<uint32_t, 2>> ends_;
  vesper::PhysicsEngine engine_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: springs_bench FOLDER_OF_LAWS\n");
    return 2;
  }
  std::printf("| springs | in order [10^6 springs/s] | in random order [10^6 springs/s] | ratio "
              "| ratio of processor time | others' processors |\n|---:|---:|---:|---:|---:|---:|\n");
  for (const uint32_t side : {50, 158, 500}) {
    Cloth grid(side, false, argv[1]), random(side, true, argv[1]);
    const auto result = bench::SideBySide([&] { random.Advance(); }, [&] { grid.Advance(); });
    std::printf("| %.0f | %.0f | %.0f | %.2f | %.2f | %.1f |\n", grid.springs(),
                1e-6 * grid.springs() / result.b.wall, 1e-6 * grid.springs() / result.a.wall,
                result.b.wall / result.a.wall, result.b.processor / result.a.processor,
                result.foreign);
  }
}
