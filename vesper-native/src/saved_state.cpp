// SPDX-License-Identifier: Apache-2.0
#include "saved_state.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cinttypes>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

#include "failure.hpp"
#include "unit.hpp"

namespace vesper {
namespace {

constexpr char kMagic[8] = {'V', 'E', 'S', 'P', 'E', 'R', 'S', 'T'};
constexpr uint32_t kVersion = 2;

struct Header {
  char magic[8];
  uint32_t version;
  uint32_t scratch_count;
  uint64_t size;  // size of the whole state [bytes], including the checksum at the end
  StepClock clock;
};

uint64_t Checksum(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

class Writer {
 public:
  void Bytes(const void* bytes, size_t size) {
    if (size == 0) return;
    const auto* first = static_cast<const std::byte*>(bytes);
    bytes_.insert(bytes_.end(), first, first + size);
  }
  template <class T>
  void Value(const T& value) {
    Bytes(&value, sizeof value);
  }
  void Text(const std::string& text) {
    Value(static_cast<uint64_t>(text.size()));
    Bytes(text.data(), text.size());
  }
  std::vector<std::byte> Take() { return std::move(bytes_); }
  std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

Failure Damaged(const char* what) {
  return Failure(VESPER_INVALID_ARGUMENT, "saved state: %s; it was cut, damaged or is none", what);
}

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

  std::span<const std::byte> Bytes(uint64_t size) {
    if (size > rest_.size()) throw Damaged("it ends too early");
    const auto bytes = rest_.first(size);
    rest_ = rest_.subspan(size);
    return bytes;
  }
  template <class T>
  T Value() {
    T value;
    std::memcpy(&value, Bytes(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view Text() {
    const auto bytes = Bytes(Value<uint64_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  bool AtEnd() const { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

Header ReadHeader(std::span<const std::byte> saved) {
  const auto header = Reader(saved).Value<Header>();
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0) {
    throw Damaged("it begins with no mark");
  }
  if (header.version != kVersion) {
    throw Failure(VESPER_INVALID_ARGUMENT, "saved state: version is %u, expected %u",
                  header.version, kVersion);
  }
  if (header.size != saved.size()) {
    throw Failure(VESPER_INVALID_ARGUMENT, "saved state: size is %zu bytes, expected %" PRIu64,
                  saved.size(), header.size);
  }
  if (saved.size() < sizeof(Header) + sizeof(uint64_t)) throw Damaged("it ends too early");
  const auto body = saved.first(saved.size() - sizeof(uint64_t));
  if (Checksum(body) != Reader(saved.last(sizeof(uint64_t))).Value<uint64_t>()) {
    throw Damaged("its checksum is wrong");
  }
  return header;
}

struct SavedScratch {
  ScratchColumn* column;
  uint64_t row_count;
  std::span<const std::byte> values;
};

SavedScratch ReadScratch(Reader& reader, const EngineState& state) {
  const std::string name(reader.Text());
  const auto named = [&](const NamedScratch& scratch) { return scratch.name == name; };
  const auto found = std::find_if(state.scratch.begin(), state.scratch.end(), named);
  if (found == state.scratch.end()) {
    throw Failure(VESPER_ACCESS_CONFLICT,
                  "saved state: holds %s, which no loaded law keeps; "
                  "load the laws it was saved with",
                  name.c_str());
  }
  const auto row_count = reader.Value<uint64_t>();
  if (row_count > INT64_MAX / found->column->row_size()) throw Damaged("its row count is absurd");
  return {found->column, row_count, reader.Bytes(row_count * found->column->row_size())};
}

/// Returns the size of a row [bytes] from the description of a SCRATCH column, e.g. "…: f64 x 3 per
/// body".
uint64_t DescribedRowSize(const std::string& name) {
  const size_t colon = name.rfind(": ");
  if (colon == std::string::npos) throw Damaged("a name has no type");
  const std::string type = name.substr(colon + 2);
  for (const vesper_scalar_type scalar : {VESPER_F32, VESPER_F64, VESPER_I32, VESPER_U32}) {
    const std::string prefix = std::string(ScalarName(scalar)) + " x ";
    if (!type.starts_with(prefix)) continue;
    const uint64_t components = std::strtoul(type.c_str() + prefix.size(), nullptr, 10);
    if (components > 0) return components * ScalarSize(scalar);
  }
  throw Damaged("a name has an unknown type");
}

void CheckComplete(const std::vector<SavedScratch>& saved, const EngineState& state) {
  for (const NamedScratch& scratch : state.scratch) {
    const auto count = std::count_if(saved.begin(), saved.end(), [&](const SavedScratch& s) {
      return s.column == scratch.column;
    });
    if (count == 1) continue;
    throw Failure(VESPER_ACCESS_CONFLICT,
                  "saved state: lacks %s; unload the laws that it was not saved with",
                  scratch.name.c_str());
  }
}

Header BlankHeader(uint32_t scratch_count, const StepClock& clock) {
  Header header{{}, kVersion, scratch_count, 0, clock};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  return header;
}

/// Completes a state that already has a header. Writes its size into the header and appends the
/// checksum.
std::vector<std::byte> Finish(Writer& writer) {
  const uint64_t size = writer.bytes().size() + sizeof(uint64_t);
  std::memcpy(writer.bytes().data() + offsetof(Header, size), &size, sizeof size);
  writer.Value(Checksum(writer.bytes()));
  return writer.Take();
}

}  // namespace

std::vector<std::byte> SaveState(const EngineState& state) {
  Writer writer;
  writer.Value(BlankHeader(static_cast<uint32_t>(state.scratch.size()), state.clock));
  writer.Text(state.prototype);
  for (const NamedScratch& scratch : state.scratch) {
    writer.Text(scratch.name);
    writer.Value(scratch.column->row_count());
    writer.Bytes(scratch.column->data(), scratch.column->byte_size());
  }
  return Finish(writer);
}

std::vector<std::byte> WithoutLibrary(std::span<const std::byte> saved,
                                      const std::string& library) {
  Header header = ReadHeader(saved);
  Reader reader(saved.first(saved.size() - sizeof(uint64_t)));
  reader.Bytes(sizeof header);
  const uint32_t count = std::exchange(header.scratch_count, 0);
  Writer rest;
  rest.Text(std::string(reader.Text()));
  for (uint32_t i = 0; i < count; ++i) {
    const std::string name(reader.Text());
    const auto row_count = reader.Value<uint64_t>();
    const uint64_t row_size = DescribedRowSize(name);
    if (row_count > INT64_MAX / row_size) throw Damaged("its row count is absurd");
    const auto values = reader.Bytes(row_count * row_size);
    if (name.starts_with(library + "/")) continue;
    ++header.scratch_count;
    rest.Text(name);
    rest.Value(row_count);
    rest.Bytes(values.data(), values.size());
  }
  Writer writer;
  writer.Value(header);
  writer.Bytes(rest.bytes().data(), rest.bytes().size());
  return Finish(writer);
}

StepClock LoadState(std::span<const std::byte> saved, const EngineState& state) {
  const Header header = ReadHeader(saved);
  Reader reader(saved.first(saved.size() - sizeof(uint64_t)));
  reader.Bytes(sizeof header);
  const std::string prototype(reader.Text());
  if (prototype != state.prototype) {
    throw Failure(VESPER_ACCESS_CONFLICT, "saved state: prototype is %s, expected %s",
                  prototype.c_str(), state.prototype.c_str());
  }
  std::vector<SavedScratch> columns;
  for (uint32_t i = 0; i < header.scratch_count; ++i) {
    columns.push_back(ReadScratch(reader, state));
  }
  if (!reader.AtEnd()) throw Damaged("it has bytes after its end");
  CheckComplete(columns, state);
  for (const SavedScratch& column : columns) {
    column.column->Resize(column.row_count);
    if (column.row_count == 0) continue;
    std::memcpy(column.column->data(), column.values.data(), column.values.size());
  }
  return header.clock;
}

}  // namespace vesper
