#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <vector>

#include "spring_tiles.hpp"
#include "tile_forces.hpp"
#include "vesper/law.hpp"

namespace {

using namespace vesper;
using namespace vesper::hooke_spring;

// Rows that a thread compares at once.
constexpr uint64_t kGrain = 16384;
// Threads that can work at the same time: memory is reserved for so many of the largest tile.
constexpr uint64_t kMostPlaces = 64;

/** Springs with viscous damping along their axis. The bodies are cut into tiles; for each, all
 *  springs that hold one of its bodies are computed and summed in a fixed order, and what they do
 *  to bodies of other tiles is left to those. Springs given in an order that jumps about among the
 *  bodies are worked on from copies of their columns. */
template <class Real>
struct HookeSpring {
  static constexpr auto kName = "hooke_spring", kVersion = "1.0.0";
  static constexpr auto kDoc = "Hooke's law with rest length and viscous damping along the spring.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kMomentum | kAngularMomentum | kTranslation | kRotation;

  Read<Ends> endpoints{"endpoints", "spring", units::one};
  Read<Real> length{"length", "spring", units::metre};
  Read<Real> hooke_constant{"hookeConstant", "spring", units::newton_per_metre};
  OptionalRead<Real> damping_constant{"dampingConstant", "spring", units::newton_second_per_metre};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Read<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() {
    return std::tie(endpoints, length, hooke_constant, damping_constant, position, velocity, force);
  }

  void Bind() {
    tiles_.Build({endpoints.data(), endpoints.size()}, position.size());
    const uint64_t count = tiles_.tiles().size();
    tiles_at_once_ = std::max<uint64_t>(1, (count + kMostPlaces - 1) / kMostPlaces);
    // Of the places to work at, only those are ever touched that threads need at the same time.
    const uint64_t places = (count + tiles_at_once_ - 1) / tiles_at_once_;
    motions_ = std::make_unique_for_overwrite<Motion<Real>[]>(places * tiles_.most_bodies());
    forces_ = std::make_unique_for_overwrite<Forces<Real>[]>(places * tiles_.most_slots() / kBatch);
    taken_ = std::make_unique<std::atomic_flag[]>(places);
    copies_.clear();
    if (tiles_.in_row_order()) return;
    Copy(length.data());
    Copy(hooke_constant.data());
    if (damping_constant.present()) Copy(damping_constant.data());
  }

  void Advance(const Step& step) {
    Update(step);
    step.ParallelFor(tiles_.tiles().size(), tiles_at_once_, [&](uint64_t begin, uint64_t end) {
      uint64_t place = 0;
      while (taken_[place].test_and_set(std::memory_order_acquire)) ++place;
      for (uint64_t i = begin; i < end; ++i) PullAt(tiles_.tiles()[i], place);
      taken_[place].clear(std::memory_order_release);
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
  /** A column as it was when it was copied, by rows and by slots. */
  struct Copied {
    const Real* column;
    std::vector<Real> rows, slots;
  };

  void Copy(const Real* column) {
    Copied& copy = copies_.emplace_back();
    copy.column = column;
    copy.rows.assign(column, column + endpoints.size());
    copy.slots.resize(tiles_.rows().size());
    Sort(copy);
  }

  void Sort(Copied& copy) const {
    const auto& rows = tiles_.rows();
    for (uint64_t slot = 0; slot < rows.size(); ++slot) copy.slots[slot] = copy.rows[rows[slot]];
  }

  /** Copies again what was edited in place: reading the rows one after the other to see that costs
   *  little next to reading them in another order. */
  void Update(const Step& step) {
    if (copies_.empty()) return;
    edited_.clear();
    step.ParallelFor(endpoints.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (const Copied& copy : copies_) {
        if (std::memcmp(copy.column + begin, copy.rows.data() + begin,
                        (end - begin) * sizeof(Real)) != 0) {
          edited_.test_and_set();
        }
      }
    });
    if (!edited_.test()) return;
    for (Copied& copy : copies_) {
      std::copy_n(copy.column, copy.rows.size(), copy.rows.data());
      Sort(copy);
    }
  }

  /** Adds the forces of a tile's springs to its own bodies. */
  void PullAt(const Tile& tile, uint64_t place) {
    Motion<Real>* motions = motions_.get() + place * tiles_.most_bodies();
    Forces<Real>* forces = forces_.get() + place * tiles_.most_slots() / kBatch;
    compiled_.take(position.data(), velocity.data(), position.size(), nullptr, tile.first_body,
                   tile.body_count, motions);
    compiled_.take(position.data(), velocity.data(), position.size(),
                   tiles_.others().data() + tile.first_other, 0, tile.other_count,
                   motions + tile.body_count);
    compiled_.pull(SpringsOf(tile), motions, forces);
    compiled_.sum(forces, tiles_.pulls().data() + tile.first_pull,
                  tiles_.pull_ends().data() + 2 * uint64_t{tile.first_body}, tile.body_count,
                  &force[tile.first_body]);
  }

  TileSprings<Real> SpringsOf(const Tile& tile) const {
    TileSprings<Real> springs{};
    springs.count = tile.slot_count;
    springs.first_ends = tiles_.first_ends().data() + tile.first_slot;
    springs.second_ends = tiles_.second_ends().data() + tile.first_slot;
    if (copies_.empty()) {
      springs.rows = tiles_.rows().data() + tile.first_slot;
      springs.first_rows = tiles_.first_rows().data() + tile.first_slot / kBatch;
      springs.length = length.data();
      springs.hooke = hooke_constant.data();
      springs.damping = damping_constant.data();
    } else {
      springs.length = copies_[0].slots.data() + tile.first_slot;
      springs.hooke = copies_[1].slots.data() + tile.first_slot;
      if (copies_.size() > 2) springs.damping = copies_[2].slots.data() + tile.first_slot;
    }
    return springs;
  }

  const TileForces<Real> compiled_ = AvailableTileForces<Real>().front();
  // All of it is rebuilt by Bind or by each Advance.
  SpringTiles tiles_;
  uint64_t tiles_at_once_ = 1;                 // that a thread takes
  std::vector<Copied> copies_;                 // length, hooke, damping; none if in order of rows
  std::atomic_flag edited_;
  std::unique_ptr<Motion<Real>[]> motions_;    // (places x most_bodies of tiles_)
  std::unique_ptr<Forces<Real>[]> forces_;     // (places x most_slots / kBatch)
  std::unique_ptr<std::atomic_flag[]> taken_;  // (places)
};

}  // namespace

VESPER_LAW_LIBRARY("hooke_spring", HookeSpring)
