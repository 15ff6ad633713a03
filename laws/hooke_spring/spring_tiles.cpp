#include "spring_tiles.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <stdexcept>

namespace vesper::hooke_spring {
namespace {

constexpr uint32_t kNowhere = UINT32_MAX;
constexpr uint64_t kUnknown = UINT64_MAX;
// Bodies of a tile: enough for its springs to be worth a task, and so few that they stay in the
// second-level cache.
constexpr uint64_t kFewest = 2048, kMost = 8192;
// Tiles to aim at: enough for the processors of a desktop.
constexpr uint64_t kTiles = 8;
// Bodies from one spring to the next, on average, beyond which memory is worth a new order.
constexpr uint64_t kFar = 64;

bool VisitsInOrder(std::span<const Ends> endpoints) {
  uint64_t jumps = 0;
  for (uint64_t row = 1; row < endpoints.size(); ++row) {
    const auto [low, high] = std::minmax(endpoints[row - 1][0], endpoints[row][0]);
    jumps += high - low;
  }
  return jumps <= kFar * endpoints.size();
}

/// Rows by the lower of their ends; those where it is the same stay in order.
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
  bodies_ = kUnknown;  // until all is done: memory may run out meanwhile
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
  others_.clear();
  place_.assign(bodies, kNowhere);
  most_bodies_ = most_slots_ = 0;
  pulls_.resize(2 * endpoints.size());
  pull_ends_.resize(2 * bodies);
  uint64_t pulls = 0;
  for (Tile& tile : tiles_) {
    Localize(endpoints, tile);
    tile.first_pull = pulls;
    pulls += ListPulls(endpoints, tile);
    most_bodies_ = std::max(most_bodies_, tile.body_count + tile.other_count);
    most_slots_ = std::max(most_slots_, tile.slot_count);
  }
  endpoints_.assign(endpoints.begin(), endpoints.end());
  bodies_ = bodies;
  return true;
}

/// Lays out the tiles, with room for their springs.
void SpringTiles::Cut(std::span<const Ends> endpoints, uint64_t bodies) {
  const uint64_t fewest = std::bit_ceil((bodies + kMost - 1) / kMost);
  const uint64_t most = std::max(fewest, std::min(kTiles, std::bit_floor(bodies / kFewest)));
  tile_size_ = std::max<uint64_t>(1, (bodies + most - 1) / most);
  tiles_.clear();
  for (uint64_t first = 0; first < bodies; first += tile_size_) {
    tiles_.push_back({static_cast<uint32_t>(first),
                      static_cast<uint32_t>(std::min(tile_size_, bodies - first)), 0, 0, 0, 0, 0});
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

/// Gives each tile its springs, and fills up its last batch.
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

/// Turns ends into places among the tile's bodies.
void SpringTiles::Localize(std::span<const Ends> endpoints, Tile& tile) {
  tile.first_other = others_.size();
  const auto local = [&](uint32_t body) {
    if (body - tile.first_body < tile.body_count) return 4 * (body - tile.first_body);
    if (place_[body] == kNowhere) {
      place_[body] = static_cast<uint32_t>(tile.body_count + others_.size() - tile.first_other);
      others_.push_back(body);
    }
    return 4 * place_[body];
  };
  const uint64_t end = tile.first_slot + tile.slot_count;
  for (uint64_t slot = tile.first_slot; slot < end; ++slot) {
    const auto [a, b] = endpoints[rows_[slot]];
    first_ends_[slot] = local(a);
    second_ends_[slot] = FillsUp(tile, slot) ? first_ends_[slot] : local(b);
  }
  tile.other_count = others_.size() - tile.first_other;
  for (uint64_t i = tile.first_other; i < others_.size(); ++i) place_[others_[i]] = kNowhere;
}

/// Returns how many there are.
uint64_t SpringTiles::ListPulls(std::span<const Ends> endpoints, const Tile& tile) {
  const std::span<uint32_t> ends(pull_ends_.data() + 2 * uint64_t{tile.first_body},
                                 2 * uint64_t{tile.body_count});
  std::ranges::fill(ends, 0);
  const auto for_each = [&](auto&& visit) {
    for (uint64_t i = 0; i < tile.slot_count; ++i) {
      if (FillsUp(tile, tile.first_slot + i)) continue;
      for (uint32_t end = 0; end < 2; ++end) {
        const uint32_t body = endpoints[rows_[tile.first_slot + i]][end] - tile.first_body;
        if (body < tile.body_count) visit(2 * body + end, static_cast<uint32_t>(i));
      }
    }
  };
  uint64_t count = 0;
  for_each([&](uint32_t list, uint32_t) { ++ends[list], ++count; });
  std::exclusive_scan(ends.begin(), ends.end(), ends.begin(), 0u);
  // Filling moves each beginning to the end.
  for_each([&](uint32_t list, uint32_t slot) { pulls_[tile.first_pull + ends[list]++] = 4 * slot; });
  return count;
}

}  // namespace vesper::hooke_spring
