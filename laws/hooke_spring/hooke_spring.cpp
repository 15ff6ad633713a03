// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
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

// Rows per chunk of a thread while copies are compared with columns.
constexpr uint64_t kGrain = 16384;
// Maximum number of concurrent threads; each thread needs a workspace for the largest tile.
constexpr uint64_t kMostPlaces = 64;
// Number of successive calls without an edit of the springs after which the law copies columns
// whose springs are already in tile order. The copy would take more time than it saves after fewer
// calls.
constexpr uint64_t kSettled = 16;
constexpr uint64_t kUnknown = UINT64_MAX;

/** Springs with viscous damping along their axis. The law divides the bodies into tiles. The law
 *  computes, for each tile, all springs that are attached to a body of the tile. It sums their
 *  forces on the tile's own bodies in a fixed order. The law reads copies of the springs'
 *  columns in tile order if consecutive springs belong to distant bodies. After kSettled calls
 *  without edits, it also copies columns whose springs are already in that order. */
template <class Real>
struct HookeSpring {
  static constexpr auto kName = "hooke_spring", kVersion = "1.0.0";
  static constexpr auto kDoc = "Hooke's law with rest length and viscous damping along the spring.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kMomentum | kAngularMomentum | kTranslation | kRotation;

  Read<Ends> endpoints{"endpoints", "spring", units::one};
  DeferredRead<Real> length{"length", "spring", units::metre};
  DeferredRead<Real> hooke_constant{"hookeConstant", "spring", units::newton_per_metre};
  OptionalDeferredRead<Real> damping_constant{"dampingConstant", "spring",
                                              units::newton_second_per_metre};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Read<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() {
    return std::tie(endpoints, length, hooke_constant, damping_constant, position, velocity, force);
  }

  void Bind() {
    if (endpoints.version() != endpoints_version_ || position.size() != bodies_) BuildTiles();
    Follow(length, 0);
    Follow(hooke_constant, 1);
    Follow(damping_constant, 2);
  }

  void Advance(const Step& step) {
    from_copies_ = !tiles_.in_row_order() || calls_since_edit_++ >= kSettled;
    for (Copied& copy : copies_) {
      if (from_copies_ && copy.stale) Update(copy, step);
    }
    step.ParallelFor(tiles_.tiles().size(), tiles_at_once_, [&](uint64_t begin, uint64_t end) {
      uint64_t place = 0;
      while (taken_[place].test_and_set(std::memory_order_acquire)) ++place;
      for (uint64_t i = begin; i < end; ++i) PullAt(tiles_.tiles()[i], place);
      taken_[place].clear(std::memory_order_release);
    });
  }

  /** Returns the sum over the springs of half the Hooke constant times the squared strain. */
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
  /** Two copies of a column: in the order of its rows, and in the order of the tiles' slots. Both
   *  are empty if the column is not copied. */
  struct Copied {
    const Real* column = nullptr;
    uint64_t version = 0;
    bool stale = false;  // the column may have changed since it was copied
    std::vector<Real> rows;
    LargeArray<Real> slots;
  };

  void BuildTiles() {
    endpoints_version_ = kUnknown;  // set at the end, because an allocation may fail before
    if (tiles_.Build({endpoints.data(), endpoints.size()}, position.size()) || !taken_) Reserve();
    bodies_ = position.size();
    endpoints_version_ = endpoints.version();
  }

  void Reserve() {
    copies_ = {};
    for (Copied& copy : copies_) {  // reserves memory now, because Advance must not allocate
      copy.rows.reserve(endpoints.size());
      copy.slots.reserve(tiles_.rows().size());
    }
    taken_.reset();
    const uint64_t count = tiles_.tiles().size();
    tiles_at_once_ = std::max<uint64_t>(1, (count + kMostPlaces - 1) / kMostPlaces);
    // Only as many workspaces are used as threads run at once, so that unused workspaces take no
    // memory.
    const uint64_t places = (count + tiles_at_once_ - 1) / tiles_at_once_;
    motions_ = std::make_unique_for_overwrite<Motion<Real>[]>(places * tiles_.most_bodies());
    forces_ = std::make_unique_for_overwrite<Forces<Real>[]>(places * tiles_.most_slots() / kBatch);
    taken_ = std::make_unique<std::atomic_flag[]>(places);
  }

  /** Marks the copy as stale if the version of the column has changed. */
  template <class Column>
  void Follow(const Column& column, int place) {
    Copied& copy = copies_[place];
    const bool known = copy.column == column.data() && copy.version == column.version();
    copy.stale = copy.stale || !known;
    if (!known) calls_since_edit_ = 0;
    copy.column = column.data();
    copy.version = column.version();
  }

  /** Copies the column again if one of its values has changed. The comparison reads the rows in
   *  order, which is much faster than reading them in another order. */
  void Update(Copied& copy, const Step& step) {
    const uint64_t count = copy.column != nullptr ? endpoints.size() : 0;
    if (copy.rows.size() != count || Differ(copy, step)) {
      copy.rows.assign(copy.column, copy.column + count);
      copy.slots.resize(count > 0 ? tiles_.rows().size() : 0);
      step.ParallelFor(copy.slots.size(), kGrain, [&](uint64_t begin, uint64_t end) {
        for (uint64_t slot = begin; slot < end; ++slot) {
          copy.slots[slot] = copy.rows[tiles_.rows()[slot]];
        }
      });
    }
    copy.stale = false;
  }

  bool Differ(const Copied& copy, const Step& step) const {
    std::atomic<bool> differ = false;
    step.ParallelFor(copy.rows.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      const size_t size = (end - begin) * sizeof(Real);
      if (std::memcmp(copy.column + begin, copy.rows.data() + begin, size) != 0) differ = true;
    });
    return differ;
  }

  /** Adds the forces of a tile's springs to the tile's own bodies. */
  void PullAt(const Tile& tile, uint64_t place) {
    if (tile.part_count == 0) return;  // no memory is reserved for a tile without springs
    Motion<Real>* motions = motions_.get() + place * tiles_.most_bodies();
    Forces<Real>* forces = forces_.get() + place * tiles_.most_slots() / kBatch;
    compiled_.take(position.data(), velocity.data(), position.size(), nullptr, tile.first_body,
                   tile.body_count, motions);
    for (uint64_t i = 0; i < tile.part_count; ++i) {
      const Part& part = tiles_.parts()[tile.first_part + i];
      compiled_.take(position.data(), velocity.data(), position.size(),
                     tiles_.others().data() + part.first_other, 0, part.other_count,
                     motions + tile.body_count);
      compiled_.pull(SpringsOf(part), motions, forces);
      compiled_.sum(forces, tiles_.pulls().data() + part.first_pull,
                    tiles_.pull_counts().data() + part.first_count, tile.body_count,
                    &force[tile.first_body]);
    }
  }

  TileSprings<Real> SpringsOf(const Part& part) const {
    TileSprings<Real> springs{};
    springs.count = part.slot_count;
    springs.first_ends = tiles_.first_ends().data() + part.first_slot;
    springs.second_ends = tiles_.second_ends().data() + part.first_slot;
    if (!from_copies_) {
      springs.rows = tiles_.rows().data() + part.first_slot;
      springs.first_rows = tiles_.first_rows().data() + part.first_slot / kBatch;
      springs.length = length.data();
      springs.hooke = hooke_constant.data();
      springs.damping = damping_constant.data();
    } else {
      springs.length = copies_[0].slots.data() + part.first_slot;
      springs.hooke = copies_[1].slots.data() + part.first_slot;
      if (damping_constant.present()) springs.damping = copies_[2].slots.data() + part.first_slot;
    }
    return springs;
  }

  const TileForces<Real> compiled_ = AvailableTileForces<Real>().front();
  // Bind or Advance can rebuild all following members.
  SpringTiles tiles_;
  uint64_t endpoints_version_ = kUnknown;  // version from which the tiles were built
  uint64_t bodies_ = 0;
  uint64_t tiles_at_once_ = 1;                 // tiles per chunk of a thread
  std::array<Copied, 3> copies_;               // length, hooke, damping
  bool from_copies_ = false;                   // springs read the copies
  uint64_t calls_since_edit_ = 0;              // calls since the last edit of one of these columns
  std::unique_ptr<Motion<Real>[]> motions_;    // (places x most_bodies of tiles_): a workspace for
                                               // each of the concurrent threads
  std::unique_ptr<Forces<Real>[]> forces_;     // (places x most_slots / kBatch)
  std::unique_ptr<std::atomic_flag[]> taken_;  // (places) whether a thread uses the workspace;
                                               // null: no memory is reserved
};

}  // namespace

VESPER_LAW_LIBRARY("hooke_spring", HookeSpring)
