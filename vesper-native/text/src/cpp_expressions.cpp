// SPDX-License-Identifier: Apache-2.0
// The expressions of generated C++.
#include <algorithm>
#include <cmath>

#include "cpp_pass.hpp"

namespace vesper::text {
namespace {

// Precedence of the operators of C++; a larger number binds more strongly.
constexpr int kChoosing = 1, kOr = 2, kAnd = 3, kEqual = 4, kLess = 5, kSum = 6, kProduct = 7,
              kUnary = 8, kPrimary = 9;

constexpr const char* kComponents[] = {".x", ".y", ".z"};

std::string Bracketed(std::string text, int binds, int least) {
  return binds < least ? "(" + std::move(text) + ")" : text;
}

bool IsSmallWhole(double value) {
  return value == std::floor(value) && std::abs(value) < 1e6 &&
         !(value == 0 && std::signbit(value));
}

std::string DoubleLiteral(double value) {
  std::string text = CppDouble(value);
  if (std::isfinite(value) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

const char* FunctionOf(Operation operation) {
  switch (operation) {
    case Operation::kSqrt:
      return "std::sqrt";
    case Operation::kAbs:
      return "std::abs";
    case Operation::kFloor:
      return "std::floor";
    case Operation::kMin:
      return "std::min";
    case Operation::kMax:
      return "std::max";
    case Operation::kExp:
      return "std::exp";
    case Operation::kLn:
      return "std::log";
    case Operation::kSin:
      return "std::sin";
    case Operation::kCos:
      return "std::cos";
    case Operation::kTan:
      return "std::tan";
    case Operation::kAsin:
      return "std::asin";
    case Operation::kAcos:
      return "std::acos";
    case Operation::kAtan:
      return "std::atan";
    case Operation::kAtan2:
      return "std::atan2";
    case Operation::kTanh:
      return "std::tanh";
    default:
      return "std::pow";
  }
}

struct Sign {
  const char* text;
  int binds;
};

Sign SignOf(Operation operation) {
  switch (operation) {
    case Operation::kAdd:
      return {" + ", kSum};
    case Operation::kSubtract:
      return {" - ", kSum};
    case Operation::kMultiply:
      return {" * ", kProduct};
    case Operation::kDivide:
      return {" / ", kProduct};
    case Operation::kLess:
      return {" < ", kLess};
    case Operation::kLessOrEqual:
      return {" <= ", kLess};
    case Operation::kEqual:
      return {" == ", kEqual};
    case Operation::kAnd:
      return {" && ", kAnd};
    case Operation::kOr:
      return {" || ", kOr};
    default:
      return {nullptr, 0};
  }
}

}  // namespace

std::string PassWriter::TypeOf(const Term& term) const {
  return term.condition ? "bool" : term.vector ? "Vec3<Real>" : "Real";
}

std::string PassWriter::OfStep(TermKind kind) {
  (energy_ ? needs_.last_step : needs_.step) = true;
  if (kind == TermKind::kTime) return energy_ ? members_.last_time : "step.time";
  if (kind == TermKind::kStep) return energy_ ? members_.last_dt : "step.dt";
  return energy_ ? members_.last_stage : "step.stage";
}

/// Returns a parameter, or a component of the place of a field.
std::string PassWriter::OfParameter(uint32_t index) const {
  if (index < kPlaceParameter) return members_.parameters[index];
  const uint32_t component = index - kPlaceParameter;
  return component == 0 ? "at[3 * i]" : "at[3 * i + " + std::to_string(component) + "]";
}

const std::string& PassWriter::RowOf(uint16_t participant) const {
  return participant == kOwnRow ? row_ : participants_[participant - kFirst];
}

std::string PassWriter::Converted(const PropertyCode& property, std::string value, bool vector) {
  if (property.fixed_type == 0) return value;
  if (!vector) return "Real(" + std::move(value) + ")";
  needs_.precisions = true;
  return "To<Real>(" + std::move(value) + ")";
}

std::string PassWriter::LoadOf(const Load& load, bool whole) {
  const PropertyCode& property = law_.properties[load.property];
  return Converted(property, ElementOf(load, whole), whole && property.components == 3);
}

std::string PassWriter::ElementOf(const Load& load, bool whole) {
  const PropertyCode& property = law_.properties[load.property];
  const std::string& column = members_.properties[load.property];
  const std::string& row = RowOf(load.participant);
  std::string text = column + "[" + row + "]";
  if (property.is_field) text = fields_.at({load.participant, load.property});
  if (property.optional) {
    needs_.optional_columns = true;
    text = "ValueOrZero(" + column + ", " + row + ")";
  }
  if (property.components == 4) return text + "[" + std::to_string(load.component) + "]";
  if (property.components == 3 && !whole) text += kComponents[load.component];
  return text;
}

bool PassWriter::IsZeroVector(const Term& term) const {
  return term.kind == TermKind::kVector &&
         std::all_of(term.parts.begin(), term.parts.end(), [&](TermId part) {
           return terms_[part].kind == TermKind::kConstant && terms_[part].value == 0;
         });
}

std::string PassWriter::Row(TermId id, int least) {
  const Term& term = terms_[id];
  const std::string& local = locals_[id];
  if (term.kind == TermKind::kConstant) {
    if (!IsSmallWhole(term.value)) return "Real(" + Literal(term.value) + ")";
    return Bracketed(CppDouble(term.value), term.value < 0 ? kUnary : kPrimary, least);
  }
  if (IsZeroVector(term)) return "Vec3<Real>{}";
  if (term.uniform && term.kind == TermKind::kLoad) {
    const uint32_t components = law_.properties[term.load.property].components;
    if (components == 4) return local + "[" + std::to_string(term.load.component) + "]";
    return local + (components == 3 && !term.vector ? kComponents[term.load.component] : "");
  }
  if (!local.empty()) {
    return term.uniform && !term.vector && !term.condition ? "Real(" + local + ")" : local;
  }
  if (term.kind == TermKind::kParameter) return "Real(" + OfParameter(term.index) + ")";
  if (term.kind == TermKind::kLoad) return LoadOf(term.load, term.vector);
  if (term.vector) return RowVector(term, least);
  if (term.kind == TermKind::kComponent) {
    return Row(term.parts[0], kPrimary) + kComponents[term.load.component];
  }
  if (term.kind == TermKind::kDot) {
    return "Dot(" + Row(term.parts[0], 0) + ", " + Row(term.parts[1], 0) + ")";
  }
  if (term.kind == TermKind::kLength) return "Length(" + Row(term.parts[0], 0) + ")";
  return OperationText(term, least, false);
}

std::string PassWriter::Typed(TermId id, int least) {
  const Term& term = terms_[id];
  if (term.kind == TermKind::kConstant) {
    return "Real(" + (IsSmallWhole(term.value) ? CppDouble(term.value) : Literal(term.value)) + ")";
  }
  return Row(id, least);
}

std::string PassWriter::Literal(double value) {
  if (!std::isfinite(value)) needs_.limits = true;
  return DoubleLiteral(value);
}

std::string PassWriter::RowVector(const Term& term, int least) {
  const auto part = [&](size_t k, int binds) { return Row(term.parts[k], binds); };
  switch (term.kind) {
    case TermKind::kSum:
      return Bracketed(part(0, kSum) + " + " + part(1, kSum + 1), kSum, least);
    case TermKind::kDifference:
      return Bracketed(part(0, kSum) + " - " + part(1, kSum + 1), kSum, least);
    case TermKind::kNegative:
      return Bracketed("-" + part(0, kPrimary), kUnary, least);
    case TermKind::kScaled:
      return Bracketed(part(0, kProduct) + " * " + part(1, kProduct + 1), kProduct, least);
    case TermKind::kChoice:
      return Bracketed(part(0, kOr) + " ? " + part(1, 0) + " : " + part(2, kChoosing), kChoosing,
                       least);
    case TermKind::kCross:
      return "Cross(" + part(0, 0) + ", " + part(1, 0) + ")";
    default:
      return "Vec3<Real>{" + part(0, 0) + ", " + part(1, 0) + ", " + part(2, 0) + "}";
  }
}

std::string PassWriter::Uniform(TermId id, int least) {
  const Term& term = terms_[id];
  if (term.kind == TermKind::kConstant) {
    return Bracketed(Literal(term.value), term.value < 0 ? kUnary : kPrimary, least);
  }
  if (term.kind == TermKind::kLoad) return "double(" + Row(id, 0) + ")";
  if (!locals_[id].empty()) return locals_[id];
  switch (term.kind) {
    case TermKind::kParameter:
      return term.index < kPlaceParameter ? OfParameter(term.index) + members_.parameter_value
                                          : OfParameter(term.index);
    case TermKind::kTime:
    case TermKind::kStep:
    case TermKind::kStage:
      return OfStep(term.kind);
    default:
      return OperationText(term, least, true);
  }
}

/// Returns an operation on numbers. Its type is the type of the rows, or double for uniform terms.
std::string PassWriter::OperationText(const Term& term, int least, bool uniform) {
  const auto part = [&](size_t k, int binds) {
    return uniform ? Uniform(term.parts[k], binds) : Row(term.parts[k], binds);
  };
  const auto typed = [&](size_t k, int binds = 0) {
    return uniform ? Uniform(term.parts[k], binds) : Typed(term.parts[k], binds);
  };
  if (const Sign sign = SignOf(term.operation); sign.text != nullptr) {
    // Brackets are added, because compilers warn of && inside of || without brackets.
    const int left = term.operation == Operation::kOr ? kEqual : sign.binds;
    const int right = term.operation == Operation::kOr ? kEqual : sign.binds + 1;
    const bool constant_first =
        term.operation == Operation::kEqual && terms_[term.parts[0]].kind == TermKind::kConstant;
    if (constant_first) {
      return Bracketed(part(1, left) + sign.text + part(0, right), sign.binds, least);
    }
    return Bracketed(part(0, left) + sign.text + part(1, right), sign.binds, least);
  }
  if (term.operation == Operation::kNegate) {
    return Bracketed("-" + part(0, kPrimary), kUnary, least);
  }
  if (term.operation == Operation::kNot) {
    const Term& inner = terms_[term.parts[0]];
    if (inner.operation != Operation::kEqual || !locals_[term.parts[0]].empty()) {
      return Bracketed("!" + part(0, kPrimary), kUnary, least);
    }
    const auto side = [&](size_t k) {
      return uniform ? Uniform(inner.parts[k], kEqual + 1) : Row(inner.parts[k], kEqual + 1);
    };
    const bool constant_first = terms_[inner.parts[0]].kind == TermKind::kConstant;
    return Bracketed(side(constant_first ? 1 : 0) + " != " + side(constant_first ? 0 : 1), kEqual,
                     least);
  }
  if (term.operation == Operation::kSelect) {
    return Bracketed(part(0, kOr) + " ? " + typed(1) + " : " + typed(2, kChoosing), kChoosing,
                     least);
  }
  if (term.operation == Operation::kMin || term.operation == Operation::kMax) {
    needs_.algorithms = true;
  }
  std::string call = std::string(FunctionOf(term.operation)) + "(" + typed(0);
  if (term.parts.size() > 1) call += ", " + typed(1);
  return call + ")";
}

}  // namespace vesper::text
