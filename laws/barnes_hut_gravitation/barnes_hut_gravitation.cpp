// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "all_pairs/all_pairs.hpp"
#include "distant_cells.hpp"
#include "interactions.hpp"
#include "octree.hpp"

namespace {

using namespace vesper;
using namespace vesper::barnes_hut;

/** Newton's gravitation of many bodies by the method of Barnes and Hut. A distant cell of a tree
 *  replaces all its bodies. */
template <class Real>
class BarnesHutGravitation {
 public:
  static constexpr auto kName = "barnes_hut_gravitation", kVersion = "1.0.0";
  static constexpr auto kDoc = "Newton's gravitation among 1e5 to 1e6 bodies by a tree of cells.";
  static constexpr auto kPhase = Phase::kForce;

  auto Parameters() { return std::tie(theta_); }
  auto Properties() {
    return std::tie(gravitational_constant_, softening_, mass_, position_, force_);
  }

  void Bind() {
    if (FewBodies()) pairs_.Resize(position_.size());
  }

  void Advance(const Step& step) {
    if (gravitational_constant_.size() == 0) return;  // the kind `world` has no row
    const auto parallel = [&](uint64_t count, uint64_t grain, auto&& body) {
      step.ParallelFor(count, grain, body);
    };
    RequireUsable(parallel);
    if (FewBodies()) {
      pairs_.Attract(step, ReciprocalRoot::kPortable, double{gravitational_constant_[0]},
                     Softening(), mass_, position_, force_);
      return;
    }
    tree_.Build(parallel, position_, mass_, kLeaf);
    parallel(position_.size(), 4 * kGroup, [&](uint64_t begin, uint64_t end) {
      for (uint64_t first = begin; first < end; first += kGroup) {
        Pull(first, std::min<uint64_t>(first + kGroup, end));
      }
    });
  }

  /** Returns the sum of -G m m' / sqrt(r^2 + softening^2) over the pairs. A cell counts as a point
   *  with its mass. */
  double PotentialEnergy() {
    if (gravitational_constant_.size() == 0) return 0;
    const double g = double{gravitational_constant_[0]};
    if (FewBodies()) return -g * pairs_.SumOfPotentials(Softening(), mass_, position_);
    const auto one_by_one = [](uint64_t count, uint64_t grain, auto&& body) {
      for (uint64_t begin = 0; begin < count; begin += grain) {
        body(begin, std::min(begin + grain, count));
      }
    };
    RequireUsable(one_by_one);
    tree_.Build(one_by_one, position_, mass_, kLeaf);
    double sum = 0;
    for (uint64_t k = 0; k < tree_.sources().size(); ++k) {
      sum += double{tree_.sources()[k].mass} * Potential(k);
    }
    const auto [length, mass] = tree_.scales();
    return -0.5 * g * (length / mass / mass) * sum;
  }

 private:
  // Maximum number of bodies in a leaf cell.
  static constexpr uint32_t kLeaf = 16;
  // Capacity of the interaction lists; a list is evaluated when it is full.
  static constexpr uint32_t kList = 512;

  /** Returns true if there are so few bodies that the sum over all pairs is faster than the tree.
   *  The limits were measured. */
  bool FewBodies() const {
    constexpr double kFew = std::is_same_v<Real, float> ? 2900 : 1600;
    return static_cast<double>(position_.size()) * theta_.value() <= kFew;
  }

  template <class Parallel>
  void RequireUsable(const Parallel& parallel) const {
    if (position_.size() > UINT32_MAX) throw std::length_error("more than 4294967295 bodies");
    parallel(position_.size(), 16384, [&](uint64_t begin, uint64_t end) {
      for (uint64_t row = begin; row < end; ++row) RequireUsable(row);
    });
  }

  void RequireUsable(uint64_t row) const {
    const Vec3<Real>& p = position_[row];
    if (!(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))) {
      throw std::invalid_argument("'position' of body " + std::to_string(row) + " is not finite");
    }
    if (!(mass_[row] >= 0 && std::isfinite(mass_[row]))) {
      throw std::invalid_argument("'mass' of body " + std::to_string(row) + " is " +
                                  std::to_string(mass_[row]) +
                                  " kg; expected a finite number, 0 or above");
    }
  }

  double Softening() const { return softening_.size() == 0 ? 0 : double{softening_[0]}; }
  /** Returns the softening squared, in the units of the tree. */
  double Softening2() const {
    const double softening = Softening() * tree_.scales().length;
    return softening * softening;
  }
  Real Theta2() const { return Real(theta_) * Real(theta_); }

  /** Computes the forces on the bodies [first, last) of the order along the Hilbert curve. These
   *  are at most kGroup bodies. */
  void Pull(uint64_t first, uint64_t last) const {
    Targets<Real> targets;
    Box<Real> box;
    for (uint64_t lane = 0; lane < kGroup; ++lane) {
      const Vec3<Real> p = tree_.sources()[std::min(first + lane, last - 1)].position;
      targets.x[lane] = p.x;
      targets.y[lane] = p.y;
      targets.z[lane] = p.z;
      targets.ax[lane] = targets.ay[lane] = targets.az[lane] = 0;
      box.Include(p);
    }
    Sum(targets, box);
    const auto [length, mass] = tree_.scales();
    const double unit = double{gravitational_constant_[0]} * (length / mass) * (length / mass);
    for (uint64_t k = first; k < last; ++k) {
      const double weight = unit * double{tree_.sources()[k].mass};
      const uint64_t lane = k - first;
      force_[tree_.Row(k)] += {static_cast<Real>(weight * double{targets.ax[lane]}),
                               static_cast<Real>(weight * double{targets.ay[lane]}),
                               static_cast<Real>(weight * double{targets.az[lane]})};
    }
  }

  void Sum(Targets<Real>& targets, const Box<Real>& box) const {
    const Real softening2 = std::max(static_cast<Real>(Softening2()), kLeastSoftening2<Real>);
    uint32_t cells[kList], cell_count = 0, run_count = 0;
    Run runs[kList];
    const auto add_cells = [&] {
      simd_.add_cells(targets, tree_.multipoles().data(), cells, cell_count, softening2);
      cell_count = 0;
    };
    const auto add_bodies = [&] {
      simd_.add_bodies(targets, tree_.sources().data(), runs, run_count, softening2);
      run_count = 0;
    };
    const auto far = [&](uint32_t cell) {
      cells[cell_count++] = cell;
      if (cell_count == kList) add_cells();
    };
    const auto near = [&](const Run& run) {
      if (run_count > 0 && runs[run_count - 1].first + runs[run_count - 1].count == run.first) {
        runs[run_count - 1].count += run.count;
        return;
      }
      runs[run_count++] = run;
      if (run_count == kList) add_bodies();
    };
    if constexpr (std::is_same_v<Real, double>) {
      DistantCells distant(simd_single_, targets, box, Softening2());
      tree_.Walk(
          box, Theta2(),
          [&](uint32_t cell, Real distance2) {
            if (distant.Takes(distance2)) {
              distant.Add(tree_.multipoles()[cell]);
            } else {
              far(cell);
            }
          },
          near);
      distant.Flush();
    } else {
      tree_.Walk(box, Theta2(), [&](uint32_t cell, Real) { far(cell); }, near);
    }
    add_cells();
    add_bodies();
  }

  /** Returns the potential at the k-th body of the order along the Hilbert curve, in the units of
   *  the tree: the sum of m_j / sqrt(d^2 + softening^2) over all other bodies. */
  double Potential(uint64_t k) const {
    const Vec3<Real> at = tree_.sources()[k].position;
    const double softening2 = Softening2();
    double sum = 0;
    const auto add = [&](double mass, Vec3<Real> from) {
      const double dx = double{from.x} - double{at.x}, dy = double{from.y} - double{at.y},
                   dz = double{from.z} - double{at.z};
      const double square = dx * dx + dy * dy + dz * dz + softening2;
      if (square > 0) sum += mass / std::sqrt(square);
    };
    Box<Real> box;
    box.Include(at);
    tree_.Walk(
        box, Theta2(),
        [&](uint32_t c, Real) {
          const Cell<Real>& cell = tree_.cells()[c];
          const bool within = cell.first <= k && k < cell.first + cell.count;
          const double own = within ? double{tree_.sources()[k].mass} : 0.0;
          add(double{tree_.multipoles()[c].mass} - own, cell.centre);
        },
        [&](const Run& run) {
          for (uint64_t j = run.first; j < run.first + run.count; ++j) {
            if (j != k) add(double{tree_.sources()[j].mass}, tree_.sources()[j].position);
          }
        });
    return sum;
  }

  Parameter theta_{
      "theta",    "Size of a cell over its distance up to which it is taken as a whole.",
      units::one, 0.5,
      0,          1};
  Read<Real> gravitational_constant_{"gravitationalConstant", "world",
                                     units::gravitational_constant};
  OptionalRead<Real> softening_{"softening", "world", units::metre};
  Read<Real> mass_{"mass", "body", units::kilogram};
  Read<Vec3<Real>> position_{"position", "body", units::metre};
  Accumulate<Vec3<Real>> force_{"externalForce", "body", units::newton};

  const Interactions<Real> simd_ = AvailableInteractions<Real>().front();
  const Interactions<float> simd_single_ = AvailableInteractions<float>().front();
  // Advance and PotentialEnergy rebuild these members in each call.
  AllPairs<Real> pairs_;
  Octree<Real> tree_;
};

}  // namespace

VESPER_LAW_LIBRARY("barnes_hut_gravitation", BarnesHutGravitation)
