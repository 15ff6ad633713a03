// SPDX-License-Identifier: Apache-2.0
#include "token.hpp"

#include <charconv>
#include <cmath>

namespace vesper::cli {
namespace {

constexpr std::string_view kSigns = "():=";

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

bool IsComment(std::string_view line, size_t at) {
  return line[at] == '#' && (at + 1 == line.size() || IsBlank(line[at + 1]));
}

bool ParsePlainNumber(std::string_view text, double& out) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(out);
}

}  // namespace

std::vector<Token> Tokenize(std::string_view line, Place place) {
  std::vector<Token> tokens;
  for (size_t at = 0; at < line.size();) {
    place.column = static_cast<int>(at) + 1;
    if (IsBlank(line[at])) {
      ++at;
    } else if (IsComment(line, at)) {
      break;
    } else if (static_cast<unsigned char>(line[at]) < ' ') {
      throw SceneError(place, "a control character; expected plain text");
    } else if (kSigns.find(line[at]) != std::string_view::npos) {
      tokens.push_back({std::string(1, line[at++]), place.column});
    } else if (line[at] == '"') {
      const size_t end = line.find('"', at + 1);
      if (end == std::string_view::npos) throw SceneError(place, "a quote without its end");
      tokens.push_back({std::string(line.substr(at + 1, end - at - 1)), place.column, true});
      at = end + 1;
    } else if (line[at] == '[') {
      const size_t end = line.find(']', at);
      if (end == std::string_view::npos) throw SceneError(place, "'[' without its ']'");
      tokens.push_back({std::string(line.substr(at, end + 1 - at)), place.column});
      at = end + 1;
    } else {
      size_t end = at;
      while (end < line.size() && static_cast<unsigned char>(line[end]) > ' ' &&
             kSigns.find(line[end]) == std::string_view::npos && line[end] != '"' &&
             line[end] != '[') {
        ++end;
      }
      tokens.push_back({std::string(line.substr(at, end - at)), place.column});
      at = end;
    }
  }
  return tokens;
}

bool ParseNumber(std::string_view text, double& out) {
  const size_t slash = text.find('/');
  if (slash == std::string_view::npos) return ParsePlainNumber(text, out);
  double numerator, denominator;
  if (!ParsePlainNumber(text.substr(0, slash), numerator) ||
      !ParsePlainNumber(text.substr(slash + 1), denominator) || denominator == 0) {
    return false;
  }
  out = numerator / denominator;
  return std::isfinite(out);
}

}  // namespace vesper::cli
