// SPDX-License-Identifier: Apache-2.0
#include "spring_tiles.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace vesper::hooke_spring {
namespace {

constexpr uint32_t kNowhere = UINT32_MAX;
constexpr uint64_t kUnknown = UINT64_MAX;
// Limits of the number of bodies in a tile. A tile must have enough springs to justify a task, and
// few enough bodies to stay in the second-level cache. Tiles are larger (kFewestIfFar) if many
// springs would connect two tiles.
constexpr uint64_t kFewestBodies = 1024, kFewestIfFar = 2048, kMostBodies = 8192;
// Average distance between the two ends of a spring [bodies] up to which few springs connect tiles.
constexpr uint64_t kNear = 128;
// Intended number of tiles. It is enough for all processors of a desktop computer.
constexpr uint64_t kTiles = 8;
// Average distance between the bodies of consecutive springs [bodies] above which the law sorts the
// springs. Sorting takes more time than it saves below this distance.
constexpr uint64_t kFar = 64;

bool VisitsInOrder(std::span<const Ends> endpoints) {
  uint64_t jumps = 0;
  for (uint64_t row = 1; row < endpoints.size(); ++row) {
    const auto [low, high] = std::minmax(endpoints[row - 1][0], endpoints[row][0]);
    jumps += high - low;
  }
  return jumps <= kFar * endpoints.size();
}

bool HoldsNear(std::span<const Ends> endpoints) {
  uint64_t reach = 0;
  for (const auto& [a, b] : endpoints) reach += std::max(a, b) - std::min(a, b);
  return reach <= kNear * endpoints.size();
}

/// Returns the springs' rows, sorted by the lower body of each spring; rows with equal lower bodies
/// stay in order.
std::vector<uint32_t> SortByLowerEnd(std::span<const Ends> endpoints, uint64_t bodies) {
  std::vector<uint32_t> next(bodies + 1, 0);
  for (const auto& [a, b] : endpoints) ++next[std::min(a, b) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<uint32_t> order(endpoints.size());
  for (uint32_t row = 0; row < endpoints.size(); ++row) {
    const auto& [a, b] = endpoints[row];
    order[next[std::min(a, b)]++] = row;
  }
  return order;
}

}  // namespace

bool SpringTiles::Build(std::span<const Ends> endpoints, uint64_t bodies) {
  if (endpoints.size() > uint64_t{1} << 29) throw std::length_error("more than 2^29 springs");
  if (bodies == bodies_ && std::ranges::equal(endpoints, endpoints_)) return false;
  bodies_ = kUnknown;  // set at the end, because an allocation may fail before
  in_row_order_ = VisitsInOrder(endpoints);
  std::vector<uint32_t> order;
  if (in_row_order_) {
    order.resize(endpoints.size());
    std::iota(order.begin(), order.end(), 0);
  } else {
    order = SortByLowerEnd(endpoints, bodies);
  }
  Cut(endpoints, bodies);
  Deal(endpoints, order);
  parts_.clear();
  others_.clear();
  pulls_.clear();
  pull_counts_.clear();
  place_.assign(bodies, kNowhere);
  most_bodies_ = most_slots_ = 0;
  pulls_.reserve(2 * endpoints.size());
  for (Tile& tile : tiles_) Split(endpoints, tile);
  endpoints_.assign(endpoints.begin(), endpoints.end());
  bodies_ = bodies;
  return true;
}

/// Creates the tiles, with space for their springs.
void SpringTiles::Cut(std::span<const Ends> endpoints, uint64_t bodies) {
  const uint64_t fewest_bodies = HoldsNear(endpoints) ? kFewestBodies : kFewestIfFar;
  const uint64_t fewest = std::bit_ceil((bodies + kMostBodies - 1) / kMostBodies);
  const uint64_t most = std::max(fewest, std::min(kTiles, std::bit_floor(bodies / fewest_bodies)));
  tile_size_ = std::max<uint64_t>(1, (bodies + most - 1) / most);
  tiles_.clear();
  for (uint64_t first = 0; first < bodies; first += tile_size_) {
    tiles_.push_back({static_cast<uint32_t>(first),
                      static_cast<uint32_t>(std::min(tile_size_, bodies - first)), 0, 0, 0, 0});
  }
  for (const auto& [a, b] : endpoints) {
    ++tiles_[a / tile_size_].slot_count;
    if (a / tile_size_ != b / tile_size_) ++tiles_[b / tile_size_].slot_count;
  }
  uint64_t slots = 0;
  for (Tile& tile : tiles_) {
    tile.first_slot = slots;
    tile.slot_count = (tile.slot_count + kBatch - 1) / kBatch * kBatch;
    slots += tile.slot_count;
  }
  rows_.resize(slots);
  first_ends_.resize(slots);
  second_ends_.resize(slots);
  first_rows_.resize(slots / kBatch);
}

/// Assigns the springs to tiles, and fills up the last batch of each tile with slots that have no
/// effect.
void SpringTiles::Deal(std::span<const Ends> endpoints, std::span<const uint32_t> order) {
  std::vector<uint64_t> used(tiles_.size(), 0);
  const auto put = [&](uint64_t tile, uint32_t row) {
    rows_[tiles_[tile].first_slot + used[tile]++] = row;
  };
  for (const uint32_t row : order) {
    const uint64_t a = endpoints[row][0] / tile_size_, b = endpoints[row][1] / tile_size_;
    put(a, row);
    if (b != a) put(b, row);
  }
  for (uint64_t t = 0; t < tiles_.size(); ++t) {
    const Tile& tile = tiles_[t];
    const uint64_t end = tile.first_slot + tile.slot_count;
    for (uint64_t slot = tile.first_slot + used[t]; slot < end; ++slot) {
      rows_[slot] = rows_[slot - 1];
    }
    for (uint64_t slot = tile.first_slot; slot < end; slot += kBatch) {
      bool follow = true;
      for (uint64_t i = 1; i < kBatch; ++i) follow &= rows_[slot + i] == rows_[slot] + i;
      first_rows_[slot / kBatch] = follow ? rows_[slot] : kScattered;
    }
  }
}

/// Splits a tile's springs into parts.
void SpringTiles::Split(std::span<const Ends> endpoints, Tile& tile) {
  tile.first_part = parts_.size();
  const uint64_t end = tile.first_slot + tile.slot_count;
  for (uint64_t slot = tile.first_slot; slot < end;) {
    parts_.push_back({slot, 0, others_.size(), 0, pulls_.size(), pull_counts_.size()});
    Part& part = parts_.back();
    for (; slot < end && !IsFull(tile, part); slot += kBatch) Localize(endpoints, tile, part);
    for (uint64_t i = part.first_other; i < others_.size(); ++i) place_[others_[i]] = kNowhere;
    ListPulls(endpoints, tile, part);
    most_bodies_ = std::max(most_bodies_, tile.body_count + part.other_count);
    most_slots_ = std::max(most_slots_, part.slot_count);
  }
  tile.part_count = parts_.size() - tile.first_part;
}

/// Returns true if another batch might exceed the limits of the part.
bool SpringTiles::IsFull(const Tile& tile, const Part& part) const {
  return part.slot_count + kBatch > kMost ||
         tile.body_count + part.other_count + 2 * kBatch > kMost;
}

/// Adds a batch to a part, and converts the rows of its bodies to indices within the part.
void SpringTiles::Localize(std::span<const Ends> endpoints, const Tile& tile, Part& part) {
  const auto place = [&](uint32_t body) {
    if (body - tile.first_body < tile.body_count) return body - tile.first_body;
    if (place_[body] == kNowhere) {
      place_[body] = static_cast<uint32_t>(tile.body_count + part.other_count++);
      others_.push_back(body);
    }
    return place_[body];
  };
  for (uint32_t i = 0; i < kBatch; ++i) {
    const uint64_t slot = part.first_slot + part.slot_count++;
    const auto [a, b] = endpoints[rows_[slot]];
    first_ends_[slot] = static_cast<uint16_t>(place(a));
    second_ends_[slot] = FillsUp(tile, slot) ? first_ends_[slot] : static_cast<uint16_t>(place(b));
  }
}

void SpringTiles::ListPulls(std::span<const Ends> endpoints, const Tile& tile, const Part& part) {
  const auto for_each = [&](auto&& visit) {
    for (uint64_t i = 0; i < part.slot_count; ++i) {
      if (FillsUp(tile, part.first_slot + i)) continue;
      for (uint32_t end = 0; end < 2; ++end) {
        const uint32_t body = endpoints[rows_[part.first_slot + i]][end] - tile.first_body;
        if (body < tile.body_count) visit(2 * body + end, static_cast<uint16_t>(i));
      }
    }
  };
  pull_counts_.resize(part.first_count + 2 * uint64_t{tile.body_count}, 0);
  uint16_t* counts = pull_counts_.data() + part.first_count;
  for_each([&](uint32_t list, uint16_t) { ++counts[list]; });
  std::vector<uint64_t> next(2 * uint64_t{tile.body_count});
  uint64_t end = part.first_pull;
  for (uint64_t list = 0; list < next.size(); ++list) {
    next[list] = std::exchange(end, end + counts[list]);
  }
  pulls_.resize(end);
  for_each([&](uint32_t list, uint16_t slot) { pulls_[next[list]++] = slot; });
}

}  // namespace vesper::hooke_spring
