// SPDX-License-Identifier: Apache-2.0
#include "generators.hpp"

#include <array>
#include <cmath>
#include <random>

#include "vesper/law.hpp"

namespace vesper::cli {
namespace {

std::string NameOf(const AnyColumn& column) {
  return "'" + std::string(column.descriptor().name) + "'";
}

std::string Rows(uint64_t rows, const AnyColumn& column) {
  return std::to_string(rows) + " row" + (rows == 1 ? "" : "s") + " of " + column.descriptor().kind;
}

void RequireRows(SceneReader& reader, const AnyColumn& column, uint64_t made) {
  if (made == column.rows()) return;
  reader.FailLast("this makes " + std::to_string(made) + " values; expected one for each of the " +
                  Rows(column.rows(), column));
}

void RequireVector(SceneReader& reader, const AnyColumn& column) {
  if (column.is_real() && column.descriptor().components == 3) return;
  reader.FailLast("makes points, but " + NameOf(column) + " has no three real components");
}

void RequirePairs(SceneReader& reader, const AnyColumn& column) {
  if (column.descriptor().refers_to != nullptr && column.descriptor().components == 2) return;
  reader.FailLast("makes pairs of rows, but " + NameOf(column) + " has none");
}

/// Expands a value to one number for each component of the column. A single number is used for all
/// components.
Value Spread(SceneReader& reader, Value value, const AnyColumn& column) {
  const uint32_t components = column.descriptor().components;
  if (value.size() == 1) value.resize(components, value[0]);
  if (value.size() != components) {
    reader.FailLast("expected 1 or " + std::to_string(components) + " numbers for " +
                    NameOf(column));
  }
  return value;
}

std::array<uint64_t, 3> ReadExtent(SceneReader& reader) {
  std::array<uint64_t, 3> extent;
  for (uint64_t& n : extent) n = reader.Count("the number of points along each axis", 1);
  return extent;
}

/// Fills a column by the generator: all VALUE
void FillAll(SceneReader& reader, const Scene&, AnyColumn& column) {
  const Value value = ReadRow(reader, column);
  for (uint64_t row = 0; row < column.rows(); ++row) SetRow(reader, column, row, value);
}

/// Fills a column by the generator: line FROM TO
void FillLine(SceneReader& reader, const Scene&, AnyColumn& column) {
  const Value from = ReadRow(reader, column), to = ReadRow(reader, column);
  for (uint64_t row = 0; row < column.rows(); ++row) {
    const double t =
        column.rows() == 1 ? 0 : static_cast<double>(row) / static_cast<double>(column.rows() - 1);
    Value value = from;
    for (size_t c = 0; c < value.size(); ++c) value[c] += (to[c] - from[c]) * t;
    SetRow(reader, column, row, value);
  }
}

/// Fills a column by the generator: grid NX NY NZ spacing S [origin P]. The index along x changes
/// fastest.
void FillGrid(SceneReader& reader, const Scene&, AnyColumn& column) {
  RequireVector(reader, column);
  const auto [nx, ny, nz] = ReadExtent(reader);
  RequireRows(reader, column, nx * ny * nz);
  reader.Expect("spacing");
  const Value spacing = Spread(reader, reader.ReadValue("the spacing"), column);
  const Value origin = reader.Accept("origin") ? ReadRow(reader, column) : Value{0, 0, 0};
  for (uint64_t row = 0; row < column.rows(); ++row) {
    const uint64_t at[] = {row % nx, row / nx % ny, row / (nx * ny)};
    Value value = origin;
    for (size_t c = 0; c < 3; ++c) value[c] += spacing[c] * static_cast<double>(at[c]);
    SetRow(reader, column, row, value);
  }
}

/// Fills a column by the generator: web RINGS SPOKES radius R. The first row is the centre; the
/// others follow ring by ring outwards, in the plane z = 0.
void FillWeb(SceneReader& reader, const Scene&, AnyColumn& column) {
  RequireVector(reader, column);
  const uint64_t rings = reader.Count("the number of rings", 1);
  const uint64_t spokes = reader.Count("the number of spokes", 3);
  RequireRows(reader, column, 1 + rings * spokes);
  reader.Expect("radius");
  const double radius = reader.Quantity("the radius of the outer ring");
  SetRow(reader, column, 0, {0, 0, 0});
  for (uint64_t row = 1; row < column.rows(); ++row) {
    const auto ring = static_cast<double>((row - 1) / spokes + 1);
    const auto spoke = static_cast<double>((row - 1) % spokes);
    const double r = radius * ring / static_cast<double>(rings);
    const double angle = 2 * M_PI * spoke / static_cast<double>(spokes);
    SetRow(reader, column, row, {r * std::cos(angle), r * std::sin(angle), 0});
  }
}

/// Fills a column by the generator: random LOW HIGH seed N. The numbers are evenly distributed in
/// [LOW, HIGH).
void FillRandom(SceneReader& reader, const Scene&, AnyColumn& column) {
  if (!column.is_real()) reader.FailLast("makes reals, but " + NameOf(column) + " has integers");
  const Value low = Spread(reader, reader.ReadValue("the lower limit"), column);
  const Value high = Spread(reader, reader.ReadValue("the upper limit"), column);
  reader.Expect("seed");
  std::mt19937_64 random(reader.Count("the seed", 0));
  for (uint64_t row = 0; row < column.rows(); ++row) {
    Value value = low;
    for (size_t c = 0; c < value.size(); ++c) {
      value[c] += (high[c] - low[c]) * std::ldexp(static_cast<double>(random() >> 11), -53);
    }
    SetRow(reader, column, row, value);
  }
}

void SetPairs(SceneReader& reader, AnyColumn& column,
              const std::vector<std::array<uint64_t, 2>>& pairs) {
  RequireRows(reader, column, pairs.size());
  for (uint64_t row = 0; row < column.rows(); ++row) {
    SetRow(reader, column, row,
           {static_cast<double>(pairs[row][0]), static_cast<double>(pairs[row][1])});
  }
}

/// Fills a column of pairs by the generator: chain. It connects each row to the next row.
void FillChain(SceneReader& reader, const Scene&, AnyColumn& column) {
  RequirePairs(reader, column);
  for (uint64_t row = 0; row < column.rows(); ++row) {
    SetRow(reader, column, row, {static_cast<double>(row), static_cast<double>(row + 1)});
  }
}

/// Fills a column of pairs by the generator: grid-edges NX NY NZ. It connects neighbours along x,
/// then along y, then along z.
void FillGridEdges(SceneReader& reader, const Scene&, AnyColumn& column) {
  RequirePairs(reader, column);
  const auto [nx, ny, nz] = ReadExtent(reader);
  const uint64_t points = nx * ny * nz;
  RequireRows(reader, column, 3 * points - ny * nz - nx * nz - nx * ny);
  std::vector<std::array<uint64_t, 2>> pairs;
  for (uint64_t i = 0; i < points; ++i) {
    if (i % nx + 1 < nx) pairs.push_back({i, i + 1});
  }
  for (uint64_t i = 0; i < points; ++i) {
    if (i / nx % ny + 1 < ny) pairs.push_back({i, i + nx});
  }
  for (uint64_t i = 0; i < points; ++i) {
    if (i / (nx * ny) + 1 < nz) pairs.push_back({i, i + nx * ny});
  }
  SetPairs(reader, column, pairs);
}

/// Fills a column of pairs by the generator: web-edges RINGS SPOKES. It connects the rows of the
/// spokes from the centre outwards, then those of the rings.
void FillWebEdges(SceneReader& reader, const Scene&, AnyColumn& column) {
  RequirePairs(reader, column);
  const uint64_t rings = reader.Count("the number of rings", 1);
  const uint64_t spokes = reader.Count("the number of spokes", 3);
  RequireRows(reader, column, 2 * rings * spokes);
  std::vector<std::array<uint64_t, 2>> pairs;
  for (uint64_t i = 1; i <= rings * spokes; ++i) pairs.push_back({i <= spokes ? 0 : i - spokes, i});
  for (uint64_t i = 1; i <= rings * spokes; ++i) {
    pairs.push_back({i, i % spokes == 0 ? i + 1 - spokes : i + 1});
  }
  SetPairs(reader, column, pairs);
}

/// Fills a column by the generator: distance [FACTOR]. A value is FACTOR times the distance between
/// the two rows to which its row refers, such as the bodies of a spring.
void FillDistance(SceneReader& reader, const Scene& scene, AnyColumn& column) {
  const AnyColumn *endpoints = scene.Find("endpoints"), *position = scene.Find("position");
  if (!column.is_real() || column.descriptor().components != 1 || endpoints == nullptr ||
      endpoints->descriptor().kind != std::string(column.descriptor().kind)) {
    reader.FailLast("needs 'endpoints' of the same kind, given before, and a real x 1");
  }
  if (position == nullptr) reader.FailLast("needs 'position', given before");
  reader.RefuseUnit("a distance has the unit of 'position'");
  const double factor = reader.AtEnd() ? 1 : reader.Number("the factor");
  for (uint64_t row = 0; row < column.rows(); ++row) {
    const double a = endpoints->Get(2 * row), b = endpoints->Get(2 * row + 1);
    if (std::max(a, b) >= static_cast<double>(position->rows())) {
      reader.FailLast("'endpoints' of row " + std::to_string(row) +
                      " name a body that does not exist");
    }
    const Vec3<double> axis = position->GetVector(static_cast<uint64_t>(b)) -
                              position->GetVector(static_cast<uint64_t>(a));
    SetRow(reader, column, row, {factor * Length(axis)});
  }
}

struct Generator {
  const char* name;
  void (*fill)(SceneReader&, const Scene&, AnyColumn&);
};
constexpr Generator kGenerators[] = {
    {"all", FillAll},
    {"line", FillLine},
    {"grid", FillGrid},
    {"web", FillWeb},
    {"random", FillRandom},
    {"chain", FillChain},
    {"grid-edges", FillGridEdges},
    {"web-edges", FillWebEdges},
    {"distance", FillDistance},
};

bool LooksLikeAName(const std::string& word) {
  return !word.empty() && std::isalpha(static_cast<unsigned char>(word[0])) != 0;
}

}  // namespace

Value ReadRow(SceneReader& reader, const AnyColumn& column) {
  const Value value = reader.ReadValue("a value of " + NameOf(column));
  const uint32_t components = column.descriptor().components;
  if (value.size() == components) return value;
  reader.FailLast(NameOf(column) + " has " + std::to_string(components) + " component" +
                  (components == 1 ? "" : "s") + " per row, found " + std::to_string(value.size()) +
                  (components == 1 ? "" : "; write them in parentheses: (x y …)"));
}

bool CanHold(const vesper_property_descriptor& property, double number) {
  if (property.scalar_type == VESPER_F64) return std::isfinite(number);
  if (property.scalar_type == VESPER_F32) return std::isfinite(static_cast<float>(number));
  const bool is_signed = property.scalar_type == VESPER_I32;
  const double low = is_signed ? INT32_MIN : 0, high = is_signed ? INT32_MAX : UINT32_MAX;
  return number == std::floor(number) && number >= low && number <= high;
}

void SetRow(SceneReader& reader, AnyColumn& column, uint64_t row, const Value& value) {
  for (size_t c = 0; c < value.size(); ++c) {
    if (!CanHold(column.descriptor(), value[c])) {
      reader.FailLast("row " + std::to_string(row) + " of " + NameOf(column) +
                      ": the property's type cannot hold this number");
    }
    column.Set(row * value.size() + c, value[c]);
  }
}

void ReadColumn(SceneReader& reader, const Scene& scene, AnyColumn& column) {
  std::vector<std::string> names;
  for (const Generator& generator : kGenerators) {
    if (reader.Accept(generator.name)) {
      generator.fill(reader, scene, column);
      return reader.ExpectEnd();
    }
    names.push_back(generator.name);
  }
  if (LooksLikeAName(reader.Peek())) {
    reader.Word("a generator");
    reader.FailUnknown("generator", names);
  }
  uint64_t row = 0;
  for (; !reader.AtEnd(); ++row) {
    const Value value = ReadRow(reader, column);
    if (row < column.rows()) SetRow(reader, column, row, value);
  }
  if (row == column.rows()) return;
  reader.FailLast(std::to_string(row) + " values for " + NameOf(column) +
                  "; expected one for each of the " + Rows(column.rows(), column) +
                  ", or 'all VALUE'");
}

}  // namespace vesper::cli
