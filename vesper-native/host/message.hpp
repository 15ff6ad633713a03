// SPDX-License-Identifier: Apache-2.0
// Encoding of the requests and replies in the mailbox. Numbers have the machine's byte order and
// are not aligned. A string consists of its length (uint32_t) and its bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

#include "vesper/types.h"

namespace vesper::host {

class Reader {
 public:
  Reader(const std::byte* bytes, size_t size) : at_(bytes), left_(size) {}

  template <class T>
  T Value() {
    T value;
    std::memcpy(&value, Take(sizeof value), sizeof value);
    return value;
  }
  std::string Text() {
    const auto size = Value<uint32_t>();
    return {reinterpret_cast<const char*>(Take(size)), size};
  }
  vesper_unit Unit() {
    vesper_unit unit{};
    std::memcpy(unit.exponent, Take(sizeof unit.exponent), sizeof unit.exponent);
    unit.scale = Value<double>();
    const std::string symbol = Text();
    symbol.copy(unit.symbol, sizeof unit.symbol - 1);
    return unit;
  }

 private:
  const std::byte* Take(size_t size) {
    if (size > left_) throw std::runtime_error("a request to the host is cut");
    const std::byte* taken = at_;
    at_ += size;
    left_ -= size;
    return taken;
  }

  const std::byte* at_;
  size_t left_;
};

class Writer {
 public:
  Writer(std::byte* bytes, size_t size) : begin_(bytes), at_(bytes), left_(size) {}

  /// Sets the position for writing or reading to the beginning of the mailbox.
  void Restart() {
    left_ += static_cast<size_t>(at_ - begin_);
    at_ = begin_;
  }
  template <class T>
  void Value(const T& value) {
    Bytes(&value, sizeof value);
  }
  void Text(const char* text) {
    const std::string_view view = text == nullptr ? "" : text;
    Value(static_cast<uint32_t>(view.size()));
    Bytes(view.data(), view.size());
  }
  void Unit(const vesper_unit& unit) {
    Bytes(unit.exponent, sizeof unit.exponent);
    Value(unit.scale);
    Text(unit.symbol);
  }

 private:
  void Bytes(const void* bytes, size_t size) {
    if (size > left_) throw std::runtime_error("a reply of the host is too long for its mailbox");
    std::memcpy(at_, bytes, size);
    at_ += size;
    left_ -= size;
  }

  std::byte* begin_;
  std::byte* at_;
  size_t left_;
};

}  // namespace vesper::host
