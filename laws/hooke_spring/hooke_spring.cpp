#include <numeric>
#include <vector>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Rows that a thread takes at once.
constexpr uint64_t kGrain = 4096;

/** Springs with viscous damping along their axis. Forces are computed per spring and then gathered
 *  per body, in row order, so that both passes run in parallel and always sum in the same order. */
template <class Real>
struct HookeSpring {
  static constexpr auto kName = "hooke_spring", kVersion = "1.0.0";
  static constexpr auto kDoc = "Hooke's law with rest length and viscous damping along the spring.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kMomentum | kAngularMomentum | kTranslation | kRotation;

  Read<std::array<uint32_t, 2>> endpoints{"endpoints", "spring", units::one};
  Read<Real> length{"length", "spring", units::metre};
  Read<Real> hooke_constant{"hookeConstant", "spring", units::newton_per_metre};
  OptionalRead<Real> damping_constant{"dampingConstant", "spring", units::newton_second_per_metre};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Read<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() {
    return std::tie(endpoints, length, hooke_constant, damping_constant, position, velocity, force);
  }

  /** Lists for each body the spring ends that hold it. */
  void Bind() {
    tension_.resize(endpoints.size());
    first_.assign(position.size() + 1, 0);
    for (const auto& ends : endpoints) {
      for (const uint32_t body : ends) ++first_[body + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    ends_.resize(2 * endpoints.size());
    std::vector<uint64_t> next(first_.begin(), first_.end() - 1);
    for (uint64_t spring = 0; spring < endpoints.size(); ++spring) {
      for (uint64_t end = 0; end < 2; ++end) {
        ends_[next[endpoints[spring][end]]++] = 2 * spring + end;
      }
    }
  }

  void Advance(const Step& step) {
    step.ParallelFor(endpoints.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t spring = begin; spring < end; ++spring) tension_[spring] = Tension(spring);
    });
    step.ParallelFor(position.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t body = begin; body < end; ++body) force[body] += Pull(body);
    });
  }

  /** Half the square of each strain, times its Hooke constant. */
  double PotentialEnergy() const {
    double energy = 0;
    for (uint64_t spring = 0; spring < endpoints.size(); ++spring) {
      const auto [a, b] = endpoints[spring];
      const double strain = double{Length(position[b] - position[a])} - double{length[spring]};
      energy += 0.5 * double{hooke_constant[spring]} * strain * strain;
    }
    return energy;
  }

 private:
  /** Force on the first end; the second feels its opposite. Zero if the ends coincide: then the
   *  spring has no direction. */
  Vec3<Real> Tension(uint64_t spring) const {
    const auto [a, b] = endpoints[spring];
    const Vec3<Real> axis = position[b] - position[a];
    const Real distance = Length(axis);
    if (distance == 0) return {};
    const Vec3<Real> direction = axis * (1 / distance);
    Real pull = hooke_constant[spring] * (distance - length[spring]);
    if (damping_constant.present()) {
      pull += damping_constant[spring] * Dot(velocity[b] - velocity[a], direction);
    }
    return direction * pull;
  }

  /** Sum over the springs that hold the body, in the order of their rows. */
  Vec3<Real> Pull(uint64_t body) const {
    Vec3<Real> sum;
    for (uint64_t i = first_[body]; i < first_[body + 1]; ++i) {
      const Vec3<Real>& tension = tension_[ends_[i] / 2];
      if (ends_[i] % 2 == 0) {
        sum += tension;
      } else {
        sum -= tension;
      }
    }
    return sum;
  }

  // All of it is rebuilt by Bind or by each Advance.
  std::vector<Vec3<Real>> tension_;  // (springs), [N], force on the first end
  std::vector<uint64_t> first_;      // (bodies + 1), where the body's part of ends_ begins
  std::vector<uint64_t> ends_;       // (springs x 2), 2 * spring + end, body by body
};

}  // namespace

VESPER_LAW_LIBRARY("hooke_spring", HookeSpring)
