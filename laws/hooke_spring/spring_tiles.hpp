// SPDX-License-Identifier: Apache-2.0
// Division of springs into tiles for parallel computation.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "large_pages.hpp"

namespace vesper::hooke_spring {

/// Rows of the two bodies that a spring connects.
using Ends = std::array<uint32_t, 2>;

/// Number of springs that are computed together. The number of slots of a tile is a multiple of
/// this number.
inline constexpr uint32_t kBatch = 16;
/// Value in `first_rows` for a batch whose springs are not adjacent in the columns.
inline constexpr uint32_t kScattered = UINT32_MAX;
/// Maximum number of slots of a part, and of the bodies that it refers to, because indices and
/// counts have 16 bits.
inline constexpr uint32_t kMost = 65536 - kBatch;

/** Consecutive bodies, and all springs that are attached to one of these bodies. A slot is the
 *  place of a spring in a tile. A spring between two tiles has a slot in each of them. */
struct Tile {
  uint32_t first_body, body_count;
  uint64_t first_slot, slot_count;
  uint64_t first_part, part_count;
};

/// Springs of a tile that are processed together. A tile has one part, unless it has more springs
/// than a part may have.
struct Part {
  uint64_t first_slot, slot_count;
  uint64_t first_other, other_count;  // range in others(): bodies of other tiles at the other ends
                                      // of its springs
  uint64_t first_pull, first_count;   // indices into pulls and pull_counts
};

/** The tiles of a network of springs. Each tile can compute the forces on its bodies without
 *  results of other tiles. */
class SpringTiles {
 public:
  /** Builds the tiles. If the springs in row order visit the bodies approximately in order, the
   *  slots have the order of the rows. Otherwise the slots are sorted by the lower body of each
   *  spring. In both cases the order of the springs of each body depends on `endpoints` only. Does
   *  nothing and returns false if the input equals that of the last build. Allocates memory. Throws
   *  std::length_error for more than 2^29 springs. */
  bool Build(std::span<const Ends> endpoints, uint64_t bodies);

  const std::vector<Tile>& tiles() const { return tiles_; }
  const std::vector<Part>& parts() const { return parts_; }
  /// Returns the maximum number of bodies that a part refers to, in its tile and in others, and the
  /// maximum number of slots of a part.
  uint64_t most_bodies() const { return most_bodies_; }
  uint64_t most_slots() const { return most_slots_; }
  /// Returns false if the slots are sorted by bodies; the rows of consecutive slots are then far
  /// apart.
  bool in_row_order() const { return in_row_order_; }

  /// (others), rows of the bodies in other tiles
  const std::vector<uint32_t>& others() const { return others_; }
  /** (slots), the place of the spring's first and second end among the bodies that the part refers
   *  to. These are the bodies of the tile, then the bodies of other tiles. Slots that only fill a
   *  batch have the same end twice. */
  const LargeArray<uint16_t>& first_ends() const { return first_ends_; }
  const LargeArray<uint16_t>& second_ends() const { return second_ends_; }
  /// (slots), rows of springs; an arbitrary row in slots that only fill a batch
  const LargeArray<uint32_t>& rows() const { return rows_; }
  /// (slots / kBatch), the row of a batch's first spring if the others follow it, else kScattered
  const LargeArray<uint32_t>& first_rows() const { return first_rows_; }
  /** For each part and each body of the tile: the indices of the slots whose first end is this
   *  body, then the indices of the slots whose second end is this body. */
  const LargeArray<uint16_t>& pulls() const { return pulls_; }
  /// For each part (bodies of the tile x 2): the numbers of slots whose first end is the body, and
  /// whose second end is the body.
  const LargeArray<uint16_t>& pull_counts() const { return pull_counts_; }

 private:
  void Cut(std::span<const Ends> endpoints, uint64_t bodies);
  void Deal(std::span<const Ends> endpoints, std::span<const uint32_t> order);
  void Split(std::span<const Ends> endpoints, Tile& tile);
  bool IsFull(const Tile& tile, const Part& part) const;
  void Localize(std::span<const Ends> endpoints, const Tile& tile, Part& part);
  void ListPulls(std::span<const Ends> endpoints, const Tile& tile, const Part& part);
  bool FillsUp(const Tile& tile, uint64_t slot) const {
    return slot > tile.first_slot && rows_[slot] == rows_[slot - 1];
  }

  std::vector<Ends> endpoints_;  // input from which the tiles were built
  uint64_t bodies_ = 0;
  bool in_row_order_ = true;
  uint64_t tile_size_ = 1;  // bodies
  uint64_t most_bodies_ = 0, most_slots_ = 0;
  std::vector<Tile> tiles_;
  std::vector<Part> parts_;
  std::vector<uint32_t> others_;
  LargeArray<uint16_t> first_ends_, second_ends_;
  LargeArray<uint32_t> rows_, first_rows_;
  LargeArray<uint16_t> pulls_, pull_counts_;
  std::vector<uint32_t> place_;  // (bodies), index of another tile's body in the part that is being
                                 // built; kNowhere between parts
};

}  // namespace vesper::hooke_spring
