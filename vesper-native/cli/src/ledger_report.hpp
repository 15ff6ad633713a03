// SPDX-License-Identifier: Apache-2.0
// Report of the ledger of a run, one line per law, as a table or as JSON. See docs/ledger.md.
#pragma once

#include <nlohmann/json.hpp>
#include <ostream>
#include <vector>

#include "vesper/vesper.hpp"

namespace vesper::cli {

/// The ledger line of one law, of the client, of the ground, or of the total.
struct LedgerLine {
  std::string name;
  bool is_law;
  vesper_ledger_entry entry;

  double PotentialChange() const { return entry.potential_energy - entry.initial_potential_energy; }
  /// Returns the energy balance, which is zero for conservative forces.
  double EnergyBalance() const { return entry.energy + PotentialChange(); }
};

/// Returns the lines of `laws` (with the engine's ids and order), the lines of client and ground if
/// they are not zero, and the total.
std::vector<LedgerLine> ReadLedger(PhysicsEngine& engine, const std::vector<vesper_law_info>& laws);

/// Prints the lines; marks the laws with the largest momentum, angular momentum and energy balance.
void PrintLedger(std::ostream& out, const std::vector<LedgerLine>& lines);

nlohmann::ordered_json LedgerJson(const std::vector<LedgerLine>& lines);

}  // namespace vesper::cli
