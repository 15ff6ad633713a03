#include <algorithm>
#include <atomic>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Rows that a thread takes at once.
constexpr uint64_t kGrain = 4096;
// Rows of bodies from one spring to the next, on average, beyond which memory is worth a new order.
constexpr uint64_t kFar = 64;

/** Springs with viscous damping along their axis. Forces are computed per spring and then gathered
 *  per body, in row order, so that both passes run in parallel and always sum in the same order.
 *  Springs given in an order that jumps about among the bodies are worked on by their first ends,
 *  from copies of their columns; sums keep the order of the rows. */
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

  /** Orders the springs, and lists for each body the spring ends that hold it. */
  void Bind() {
    if (endpoints.size() > UINT32_MAX / 2) throw std::length_error("more than 2^31 springs");
    const auto springs = static_cast<uint32_t>(endpoints.size());
    tension_.resize(springs);
    Order();
    first_.assign(position.size() + 1, 0);
    for (const auto& ends : endpoints) {
      for (const uint32_t body : ends) ++first_[body + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    ends_.resize(2 * endpoints.size());
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    for (uint32_t row = 0; row < springs; ++row) {
      for (uint32_t end = 0; end < 2; ++end) {
        ends_[next[endpoints[row][end]]++] = 2 * (ordered_.empty() ? row : place_[row]) + end;
      }
    }
  }

  void Advance(const Step& step) {
    const Springs springs = ordered_.empty() ? Columns() : Copies(step);
    step.ParallelFor(endpoints.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) tension_[i] = Tension(springs, i);
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
  /** The springs' columns, in the order in which they are worked on; no damping: null. */
  struct Springs {
    const std::array<uint32_t, 2>* endpoints;
    const Real *length, *hooke, *damping;
  };

  /** Sorts the springs by their first ends, in row order where these are the same, unless the rows
   *  are near enough to that. */
  void Order() {
    ordered_.clear();
    copies_.clear();
    uint64_t jumps = 0;
    for (uint64_t row = 1; row < endpoints.size(); ++row) {
      const uint32_t a = endpoints[row - 1][0], b = endpoints[row][0];
      jumps += std::max(a, b) - std::min(a, b);
    }
    if (jumps <= kFar * endpoints.size()) return;
    std::vector<uint32_t> next(position.size() + 1, 0);
    for (const auto& ends : endpoints) ++next[ends[0] + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    place_.resize(endpoints.size());
    ordered_.resize(endpoints.size());
    for (uint64_t row = 0; row < endpoints.size(); ++row) {
      place_[row] = next[endpoints[row][0]]++;
      ordered_[place_[row]] = endpoints[row];
    }
    for (const Real* column : Values()) {
      Copy& copy = copies_.emplace_back();
      copy.rows.assign(column, column + endpoints.size());
      copy.ordered.resize(endpoints.size());
      Scatter(copy);
    }
  }

  /** The columns of numbers that are there. */
  std::vector<const Real*> Values() const {
    std::vector<const Real*> columns{length.data(), hooke_constant.data()};
    if (damping_constant.present()) columns.push_back(damping_constant.data());
    return columns;
  }

  Springs Columns() const {
    return {endpoints.data(), length.data(), hooke_constant.data(), damping_constant.data()};
  }

  /** The copies, brought up to date if values were edited in place: reading the rows one after the
   *  other to see that costs little next to reading them in another order. */
  Springs Copies(const Step& step) {
    const Real* columns[] = {length.data(), hooke_constant.data(), damping_constant.data()};
    for (uint64_t c = 0; c < copies_.size(); ++c) {
      Copy& copy = copies_[c];
      std::atomic<bool> same = true;
      step.ParallelFor(endpoints.size(), 16 * kGrain, [&](uint64_t begin, uint64_t end) {
        if (std::memcmp(columns[c] + begin, copy.rows.data() + begin,
                        (end - begin) * sizeof(Real)) != 0) {
          same = false;
        }
      });
      if (same) continue;
      std::copy_n(columns[c], endpoints.size(), copy.rows.data());
      Scatter(copy);
    }
    return {ordered_.data(), copies_[0].ordered.data(), copies_[1].ordered.data(),
            copies_.size() > 2 ? copies_[2].ordered.data() : nullptr};
  }

  /** A column as it was when it was copied, by rows and in the order of ordered_. */
  struct Copy {
    std::vector<Real> rows, ordered;
  };

  void Scatter(Copy& copy) const {
    for (uint64_t row = 0; row < copy.rows.size(); ++row) {
      copy.ordered[place_[row]] = copy.rows[row];
    }
  }

  /** Force on the first end; the second feels its opposite. Zero if the ends coincide: then the
   *  spring has no direction. */
  Vec3<Real> Tension(const Springs& springs, uint64_t i) const {
    const auto [a, b] = springs.endpoints[i];
    const Vec3<Real> axis = position[b] - position[a];
    const Real distance = Length(axis);
    if (distance == 0) return {};
    const Vec3<Real> direction = axis * (1 / distance);
    Real pull = springs.hooke[i] * (distance - springs.length[i]);
    if (springs.damping != nullptr) {
      pull += springs.damping[i] * Dot(velocity[b] - velocity[a], direction);
    }
    return direction * pull;
  }

  /** Sum over the springs that hold the body, in the order of their rows. */
  Vec3<Real> Pull(uint64_t body) const {
    Vec3<Real> sum;
    for (uint64_t i = first_[body]; i < first_[body + 1]; ++i) {
      const Real sign[] = {1, -1};  // no branch: which end it is cannot be foretold
      sum += tension_[ends_[i] / 2] * sign[ends_[i] % 2];
    }
    return sum;
  }

  // All of it is rebuilt by Bind or by each Advance.
  std::vector<uint32_t> place_;                   // (springs), of a row in ordered_
  std::vector<std::array<uint32_t, 2>> ordered_;  // (springs), endpoints; empty: rows are in order
  std::vector<Copy> copies_;                      // of the columns, if ordered_ is not empty
  std::vector<Vec3<Real>> tension_;  // (springs), [N], on the first end, in the order worked on
  std::vector<uint32_t> first_;      // (bodies + 1), where the body's part of ends_ begins
  std::vector<uint32_t> ends_;       // (springs x 2), 2 * index in tension_ + end, body by body
};

}  // namespace

VESPER_LAW_LIBRARY("hooke_spring", HookeSpring)
