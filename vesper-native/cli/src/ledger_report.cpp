// SPDX-License-Identifier: Apache-2.0
#include "ledger_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "text_table.hpp"

namespace vesper::cli {
namespace {

// Fraction of a column's largest number below which a number counts as a rounding error.
constexpr double kRounding = 1e-12;

double Length(const double* v) { return std::hypot(v[0], v[1], v[2]); }

bool IsEmpty(const vesper_ledger_entry& entry) {
  return Length(entry.momentum) == 0 && Length(entry.angular_momentum) == 0 && entry.energy == 0;
}

std::string Number(double value, double largest) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", std::abs(value) <= kRounding * largest ? 0.0 : value);
  return text;
}

std::string Numbers(const double* v, double largest) {
  return "(" + Number(v[0], largest) + " " + Number(v[1], largest) + " " + Number(v[2], largest) +
         ")";
}

/// Returns the cells of one column of the report. The function `size` returns the number of a line
/// by which the cells are compared. The function `print` returns the text of the cell.
template <class Size, class Print>
std::vector<std::string> Cells(const std::vector<LedgerLine>& lines, Size size, Print print) {
  double largest = 0, largest_of_laws = 0;
  for (const LedgerLine& line : lines) {
    largest = std::max(largest, size(line));
    if (line.is_law) largest_of_laws = std::max(largest_of_laws, size(line));
  }
  std::vector<std::string> cells;
  for (const LedgerLine& line : lines) {
    const bool is_largest = line.is_law && size(line) == largest_of_laws;
    const bool marked = is_largest && size(line) > kRounding * largest;
    cells.push_back(print(line, largest) + (marked ? " *" : ""));
  }
  return cells;
}

}  // namespace

std::vector<LedgerLine> ReadLedger(PhysicsEngine& engine,
                                   const std::vector<vesper_law_info>& laws) {
  std::vector<LedgerLine> lines;
  uint32_t index = 0;
  for (const vesper_law_info& law : laws) {
    const bool same = !lines.empty() && law.library_id == (&law - 1)->library_id;
    index = same ? index + 1 : 0;
    lines.push_back({law.name, true, engine.Ledger(law.library_id, index)});
  }
  for (const auto& [name, line] :
       {std::pair{"client", VESPER_LEDGER_CLIENT}, std::pair{"ground", VESPER_LEDGER_GROUND}}) {
    const vesper_ledger_entry entry = engine.Ledger(VESPER_NO_LIBRARY, line);
    if (!IsEmpty(entry)) lines.push_back({name, false, entry});
  }
  lines.push_back({"total", false, engine.Ledger(VESPER_NO_LIBRARY, VESPER_LEDGER_TOTAL)});
  return lines;
}

void PrintLedger(std::ostream& out, const std::vector<LedgerLine>& lines) {
  const auto momentum = [](const LedgerLine& l) { return Length(l.entry.momentum); };
  const auto angular = [](const LedgerLine& l) { return Length(l.entry.angular_momentum); };
  const auto energy = [](const LedgerLine& l) {
    return std::max(std::abs(l.entry.energy), std::abs(l.PotentialChange()));
  };
  double most_energy = 0;
  for (const LedgerLine& line : lines) most_energy = std::max(most_energy, energy(line));
  const auto balance = [most_energy](const LedgerLine& l) {
    const double size = std::abs(l.EnergyBalance());
    return size <= kRounding * most_energy ? 0 : size;
  };
  const auto momenta = Cells(lines, momentum, [](const LedgerLine& l, double largest) {
    return Numbers(l.entry.momentum, largest);
  });
  const auto angular_momenta = Cells(lines, angular, [](const LedgerLine& l, double largest) {
    return Numbers(l.entry.angular_momentum, largest);
  });
  const auto balances = Cells(lines, balance, [most_energy](const LedgerLine& l, double) {
    return Number(l.EnergyBalance(), most_energy);
  });
  TextTable table{{"ledger", "momentum [kg*m/s]", "angular momentum [kg*m^2/s]", "work [J]",
                   "potential [J]", "work + potential [J]"}};
  for (size_t i = 0; i < lines.size(); ++i) {
    const LedgerLine& line = lines[i];
    table.push_back(
        {line.name, momenta[i], angular_momenta[i], Number(line.entry.energy, most_energy),
         line.entry.has_potential_energy != 0 ? Number(line.PotentialChange(), most_energy) : "-",
         balances[i]});
  }
  Print(out, table, "  ");
}

nlohmann::ordered_json LedgerJson(const std::vector<LedgerLine>& lines) {
  auto json = nlohmann::ordered_json::array();
  for (const auto& [name, is_law, entry] : lines) {
    nlohmann::ordered_json line{{is_law ? "law" : "line", name},
                                {"momentum", entry.momentum},
                                {"angularMomentum", entry.angular_momentum},
                                {"energy", entry.energy}};
    if (entry.has_potential_energy != 0) {
      line["potentialEnergy"] = {{"initial", entry.initial_potential_energy},
                                 {"present", entry.potential_energy}};
    }
    json.push_back(std::move(line));
  }
  return json;
}

}  // namespace vesper::cli
