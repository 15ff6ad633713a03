// SPDX-License-Identifier: Apache-2.0
// The ledger of a run, one line per law, as a table or as JSON. See docs/ledger.md.
#pragma once

#include <nlohmann/json.hpp>
#include <ostream>
#include <vector>

#include "vesper/vesper.hpp"

namespace vesper::cli {

/// One law, the client, the ground, or the total.
struct LedgerLine {
  std::string name;
  bool is_law;
  vesper_ledger_entry entry;

  double PotentialChange() const { return entry.potential_energy - entry.initial_potential_energy; }
  /// Zero for forces that keep energy.
  double EnergyBalance() const { return entry.energy + PotentialChange(); }
};

/// Lines of `laws`, whose ids and order are the engine's; the client's and the ground's where they
/// hold something; the total.
std::vector<LedgerLine> ReadLedger(PhysicsEngine& engine, const std::vector<vesper_law_info>& laws);

/// Marks the law with the largest momentum, angular momentum and balance of energy.
void PrintLedger(std::ostream& out, const std::vector<LedgerLine>& lines);

nlohmann::ordered_json LedgerJson(const std::vector<LedgerLine>& lines);

}  // namespace vesper::cli
