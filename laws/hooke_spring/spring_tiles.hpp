// SPDX-License-Identifier: Apache-2.0
// How springs are dealt out to those that work on them at the same time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "large_pages.hpp"

namespace vesper::hooke_spring {

/// Rows of the two bodies that a spring holds.
using Ends = std::array<uint32_t, 2>;

/// Springs that are computed together; a tile has a multiple of it.
inline constexpr uint32_t kBatch = 16;
/// `first_rows` of a batch whose springs do not follow each other in the columns.
inline constexpr uint32_t kScattered = UINT32_MAX;
/// Most slots of a part, and most bodies that it knows: 16 bits say which, or how many.
inline constexpr uint32_t kMost = 65536 - kBatch;

/** Bodies that follow each other, and all springs that hold one of them. Springs are known by
 *  slots: a spring between two tiles has a slot in each. */
struct Tile {
  uint32_t first_body, body_count;
  uint64_t first_slot, slot_count;
  uint64_t first_part, part_count;
};

/// Springs of a tile that are worked on together: all that it has, unless they are very many.
struct Part {
  uint64_t first_slot, slot_count;
  uint64_t first_other, other_count;  // bodies of other tiles at the far ends of its springs
  uint64_t first_pull, first_count;   // in pulls and pull_counts
};

/** The tiles of a network. Each tile can do with its bodies whatever its springs say without a look
 *  at the other tiles. */
class SpringTiles {
 public:
  /** Springs come in the order of their rows where these visit the bodies more or less in order,
   *  else by the lower of their ends; in both cases each body meets its springs in an order that
   *  depends on `endpoints` alone. Does nothing, and returns false, if all is as it was. Allocates.
   *  Throws std::length_error beyond 2^29 springs. */
  bool Build(std::span<const Ends> endpoints, uint64_t bodies);

  const std::vector<Tile>& tiles() const { return tiles_; }
  const std::vector<Part>& parts() const { return parts_; }
  /// Bodies that a part knows at most, the tile's own and others; slots of the one that has most.
  uint64_t most_bodies() const { return most_bodies_; }
  uint64_t most_slots() const { return most_slots_; }
  /// False if the springs are sorted: then one row is far from the next.
  bool in_row_order() const { return in_row_order_; }

  /// (others), rows of bodies.
  const std::vector<uint32_t>& others() const { return others_; }
  /** (slots), the place of the spring's first and second end among the bodies that the part knows,
   *  first the tile's own, then the others. Slots that fill up a batch have the same end twice. */
  const LargeArray<uint16_t>& first_ends() const { return first_ends_; }
  const LargeArray<uint16_t>& second_ends() const { return second_ends_; }
  /// (slots), rows of springs; some row in those that fill up.
  const LargeArray<uint32_t>& rows() const { return rows_; }
  /// (slots / kBatch), the row of a batch's first spring if the others follow it, else kScattered.
  const LargeArray<uint32_t>& first_rows() const { return first_rows_; }
  /** Of each part, for each body of the tile, the places of the slots that have it as first end,
   *  then of those that have it as second end. */
  const LargeArray<uint16_t>& pulls() const { return pulls_; }
  /// Of each part (bodies of the tile x 2), how many these are.
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

  std::vector<Ends> endpoints_;  // those that the tiles are of
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
  std::vector<uint32_t> place_;  // (bodies), of the others of a part; kNowhere between parts
};

}  // namespace vesper::hooke_spring
