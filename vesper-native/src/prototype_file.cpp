// SPDX-License-Identifier: Apache-2.0
#include "prototype_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

#include "failure.hpp"
#include "nearest_name.hpp"
#include "prototype.hpp"
#include "unit.hpp"
#include "unit_parser.hpp"
#include "vesper/engine.h"

namespace vesper {
namespace {

constexpr uintmax_t kMaxFileSize = 1 << 20;

struct Word {
  const char* text;
  uint32_t value;
};
constexpr Word kAccesses[] = {
    {"read", VESPER_READ},
    {"write", VESPER_WRITE},
    {"read_write", VESPER_READ_WRITE},
    {"accumulate", VESPER_READ | VESPER_ACCUMULATE},
};

/// Reader of one line, from left to right. Columns count bytes, from 1.
class Line {
 public:
  Line(std::string_view text, const std::string& source, size_t number)
      : text_(text), source_(source), number_(number) {}

  [[noreturn]] void Fail(size_t offset, const std::string& what) const {
    throw Failure(VESPER_INVALID_ARGUMENT, "%s:%zu:%zu: %s", source_.c_str(), number_, offset + 1,
                  what.c_str());
  }

  size_t at() const { return at_; }
  void SkipSpaces() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  /// Returns true if only a comment is left.
  bool AtEnd() {
    SkipSpaces();
    return at_ == text_.size() || text_[at_] == '#';
  }
  void ExpectEnd() {
    if (!AtEnd()) Fail(at_, "found " + Found() + ", expected the end of the line");
  }
  std::string Found() {
    if (AtEnd()) return "the end of the line";
    size_t end = at_;
    while (end < text_.size() && text_[end] != ' ' && text_[end] != '\t') ++end;
    return "'" + std::string(text_.substr(at_, end - at_)) + "'";
  }

  bool Take(std::string_view token) {
    SkipSpaces();
    if (text_.substr(at_, token.size()) != token) return false;
    at_ += token.size();
    return true;
  }
  void Expect(std::string_view token, const char* before) {
    if (Take(token)) return;
    Fail(at_, "found " + Found() + ", expected '" + std::string(token) + "'" + before);
  }

  /// Reads a name: letters, digits, '_' and '-'. The result is not null-terminated.
  std::string_view Name(const char* what) {
    SkipSpaces();
    const size_t begin = at_;
    while (at_ < text_.size() && IsNameCharacter(begin)) ++at_;
    const std::string name(text_.substr(begin, at_ - begin));
    if (!IsValidName(name.c_str())) {
      at_ = begin;
      Fail(begin, "found " + Found() + ", expected " + what);
    }
    return text_.substr(begin, name.size());
  }
  /// Returns true if the next character continues a name that starts at `begin`. The sign "->" ends
  /// a name; a '-' within a name does not.
  bool IsNameCharacter(size_t begin) const {
    const char c = text_[at_];
    if (c == '-') return at_ > begin && text_.substr(at_, 2) != "->";
    return c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  }

  template <size_t n>
  uint32_t OneOf(const Word (&words)[n], const char* what) {
    SkipSpaces();
    const size_t begin = at_;
    const std::string_view found = Name(what);
    std::vector<std::string> texts;
    for (const Word& word : words) {
      if (found == word.text) return word.value;
      texts.emplace_back(word.text);
    }
    std::string message = "found '" + std::string(found) + "', expected " + what;
    if (const std::string* nearest = NearestName(found, texts)) {
      message += "; did you mean '" + *nearest + "'?";
    }
    Fail(begin, message);
  }

  uint32_t Number(const char* what) {
    uint32_t value = 0;
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc()) Fail(at_, "found " + Found() + ", expected " + what);
    at_ += static_cast<size_t>(end - begin);
    return value;
  }

  double Real(const char* what) {
    SkipSpaces();
    double value = 0;
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc()) Fail(at_, "found " + Found() + ", expected " + what);
    at_ += static_cast<size_t>(end - begin);
    return value;
  }

  vesper_unit Unit() {
    Expect("[", " and a unit, such as [m/s]");
    const size_t begin = at_;
    const size_t end = text_.find(']', begin);
    if (end == std::string_view::npos) Fail(begin - 1, "'[' is never closed, expected ']'");
    at_ = end + 1;
    try {
      return ParseUnitOrThrowWhere(text_.substr(begin, end - begin));
    } catch (const UnitError& error) {
      Fail(begin + error.offset, error.message);
    }
  }

  std::string_view Quoted() {
    Expect("\"", "");
    const size_t begin = at_;
    const size_t end = text_.find('"', begin);
    if (end == std::string_view::npos) Fail(begin - 1, "the text is never closed, expected '\"'");
    at_ = end + 1;
    return text_.substr(begin, end - begin);
  }

 private:
  std::string_view text_;
  const std::string& source_;
  size_t number_;
  size_t at_ = 0;
};

class Reader {
 public:
  explicit Reader(const std::string& source)
      : source_(source), prototype_(std::make_unique<OwnedPrototype>()) {
    static_cast<vesper_prototype&>(*prototype_) = {};
    prototype_->struct_size = sizeof(vesper_prototype);
  }

  std::unique_ptr<OwnedPrototype> Read(std::string_view text) {
    while (!text.empty()) {
      const size_t end = std::min(text.find('\n'), text.size());
      std::string_view content = text.substr(0, end);
      if (content.ends_with('\r')) content.remove_suffix(1);
      text.remove_prefix(std::min(end + 1, text.size()));
      ReadLine(Line(content, source_, ++line_));
    }
    if (prototype_->name == nullptr || prototype_->real_type == 0 || !has_time_) {
      Line({}, source_, line_ + 1).Fail(0, "found the end of the file, expected " + Missing());
    }
    prototype_->properties = prototype_->descriptors.data();
    prototype_->property_count = static_cast<uint32_t>(prototype_->descriptors.size());
    Check();
    return std::move(prototype_);
  }

 private:
  void ReadLine(Line line) {
    if (line.AtEnd()) return;
    if (prototype_->name == nullptr) {
      ReadHeader(line);
    } else if (prototype_->real_type == 0) {
      ReadReal(line);
    } else if (!has_time_) {
      ReadTime(line);
    } else {
      ReadProperty(line);
    }
    line.ExpectEnd();
  }

  std::string Missing() const {
    if (prototype_->name == nullptr) return "'prototype NAME', or 'prototype NAME extends BASE'";
    return prototype_->real_type == 0 ? "'real f64' or 'real f32'" : "'time [s]'";
  }

  void ReadHeader(Line& line) {
    if (!line.Take("prototype "))
      line.Fail(line.at(), "found " + line.Found() + ", expected " + Missing());
    prototype_->name = Keep(line.Name("the name of the prototype"));
    if (line.AtEnd()) return;
    line.Expect("extends ", " or the end of the line");
    line.SkipSpaces();
    const size_t begin = line.at();
    const std::string base(line.Name("the name of a standard prototype"));
    const vesper_prototype* standard = vesper_prototype_standard(base.c_str());
    if (standard == nullptr) {
      line.Fail(begin, "found '" + base + "', expected the standard prototype si-f64 or si-f32");
    }
    prototype_->real_type = standard->real_type;
    prototype_->time_unit = standard->time_unit;
    prototype_->descriptors.assign(standard->properties,
                                   standard->properties + standard->property_count);
    has_time_ = true;
  }

  void ReadReal(Line& line) {
    if (!line.Take("real "))
      line.Fail(line.at(), "found " + line.Found() + ", expected " + Missing());
    static constexpr Word kReals[] = {{"f64", VESPER_F64}, {"f32", VESPER_F32}};
    prototype_->real_type = line.OneOf(kReals, "f64 or f32");
  }

  void ReadTime(Line& line) {
    if (!line.Take("time "))
      line.Fail(line.at(), "found " + line.Found() + ", expected " + Missing());
    line.SkipSpaces();
    const size_t begin = line.at();
    prototype_->time_unit = line.Unit();
    if (!SameDimension(prototype_->time_unit, VESPER_UNIT_SECOND)) {
      line.Fail(begin, "found [" + Describe(prototype_->time_unit) + "], expected a unit of time");
    }
    has_time_ = true;
  }

  void ReadProperty(Line& line) {
    vesper_property_descriptor property{};
    property.struct_size = sizeof property;
    property.kind = Keep(line.Name("the kind of a property, such as body"));
    line.SkipSpaces();
    const size_t begin = line.at();
    property.name = Keep(line.Name("the name of a property"));
    line.Expect(":", " after the name of the property");
    property.scalar_type = ReadType(line);
    line.Expect("x", " and the number of components, such as x3");
    property.components = line.Number("the number of components, such as x3");
    property.unit = line.Unit();
    property.law_access = line.OneOf(kAccesses, "read, write, read_write or accumulate");
    if (line.Take("->")) property.refers_to = Keep(line.Name("the kind that it refers to"));
    if (line.Take("from ")) property.initial_from = Keep(line.Name("the name of a property"));
    if (line.Take("min ")) {
      property.has_minimum = 1;
      property.minimum = line.Real("the least value, such as min 0");
    }
    if (!line.AtEnd()) property.doc = Keep(line.Quoted());
    const auto [found, added] = places_.emplace(property.name, std::pair(line_, begin));
    if (!added) {
      line.Fail(begin, std::string("property ") + property.name + " is declared in line " +
                           std::to_string(found->second.first) + " already");
    }
    prototype_->descriptors.push_back(property);
  }

  vesper_scalar_type ReadType(Line& line) const {
    const Word types[] = {{"real", prototype_->real_type},
                          {"f32", VESPER_F32},
                          {"f64", VESPER_F64},
                          {"i32", VESPER_I32},
                          {"u32", VESPER_U32},
                          {"field", VESPER_FIELD}};
    return line.OneOf(types, "a type: real, f32, f64, i32, u32 or field");
  }

  /// Checks the rules of all prototypes. On failure, the message contains the line and column of
  /// the property.
  void Check() const {
    try {
      const Prototype checked(*prototype_);
    } catch (const Failure& failure) {
      const auto place = places_.find(failure.error().property);
      const auto [line, offset] =
          place == places_.end() ? std::pair<size_t, size_t>(1, 0) : place->second;
      throw Failure(failure).Within(source_ + ":" + std::to_string(line) + ":" +
                                    std::to_string(offset + 1));
    }
  }

  const char* Keep(std::string_view text) {
    prototype_->strings.push_back(std::make_unique<std::string>(text));
    return prototype_->strings.back()->c_str();
  }

  const std::string& source_;
  std::unique_ptr<OwnedPrototype> prototype_;
  std::map<std::string, std::pair<size_t, size_t>> places_;  // line and offset of each property
  bool has_time_ = false;
  size_t line_ = 0;
};

}  // namespace

std::unique_ptr<OwnedPrototype> ParsePrototype(std::string_view text, const std::string& source) {
  if (text.size() > kMaxFileSize) {
    throw Failure(VESPER_INVALID_ARGUMENT, "%s: %zu bytes, a prototype has at most 1 MiB",
                  source.c_str(), text.size());
  }
  return Reader(source).Read(text);
}

std::unique_ptr<OwnedPrototype> LoadPrototype(const std::string& path) {
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(path, error);
  if (error) {
    throw Failure(VESPER_NOT_FOUND, "cannot read prototype %s: %s", path.c_str(),
                  error.message().c_str());
  }
  const std::string name = std::filesystem::path(path).filename();
  if (size > kMaxFileSize) {
    throw Failure(VESPER_INVALID_ARGUMENT, "%s: %ju bytes, a prototype has at most 1 MiB",
                  name.c_str(), size);
  }
  std::string text(size, '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(text.data(), static_cast<std::streamsize>(size))) {
    throw Failure(VESPER_NOT_FOUND, "cannot read prototype %s", path.c_str());
  }
  return ParsePrototype(text, name);
}

}  // namespace vesper
