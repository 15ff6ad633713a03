// SPDX-License-Identifier: Apache-2.0
#include "vector_assembler.hpp"

#include <bit>
#include <cstring>

#include "code_memory.hpp"

namespace vesper::text {
namespace {

using namespace asmjit;
namespace Inst = x86::Inst;

}  // namespace

// --- registers and memory ---------------------------------------------------------------------

void VectorAssembler::Begin(FuncNode* function, std::initializer_list<Gp> arguments) {
  if (function == nullptr) throw NoMachineCode{"asmjit has no memory"};
  function->frame().setAvxEnabled();
  function->frame().setAvxCleanup();
  if (is_avx512_) function->frame().setAvx512Enabled();
  size_t index = 0;
  for (const Gp& argument : arguments) function->setArg(index++, argument);
}

VectorAssembler::Vec VectorAssembler::NewVector() {
  if (is_avx512_) return is_f64_ ? Vec(code_.newZmmPd()) : Vec(code_.newZmmPs());
  return is_f64_ ? Vec(code_.newYmmPd()) : Vec(code_.newYmmPs());
}

VectorAssembler::Vec VectorAssembler::Emit(Names names, const Operand_& a, const Operand_& b) {
  const Vec to = NewVector();
  const InstId name = is_f64_ ? names.f64 : names.f32;
  if (b.isNone()) {
    code_.emit(name, to, a);
  } else {
    code_.emit(name, to, a, b);
  }
  return to;
}

VectorAssembler::Vec VectorAssembler::Load(const Mem& from) {
  return Emit({Inst::kIdVmovupd, Inst::kIdVmovups}, from, Operand());
}

void VectorAssembler::Store(const Mem& to, const Vec& value) {
  code_.emit(is_f64_ ? Inst::kIdVmovupd : Inst::kIdVmovups, to, value);
}

VectorAssembler::Vec VectorAssembler::Broadcast(const Mem& from) {
  return Emit({Inst::kIdVbroadcastsd, Inst::kIdVbroadcastss}, from, Operand());
}

VectorAssembler::Vec VectorAssembler::Zero() {
  const Vec to = NewVector();
  code_.vxorps(to, to, to);
  return to;
}

VectorAssembler::Mem VectorAssembler::Bits(uint64_t f64, uint32_t f32) {
  std::array<uint8_t, 64> bytes;
  for (size_t i = 0; i < bytes.size(); i += number_bytes()) {
    std::memcpy(bytes.data() + i, is_f64_ ? static_cast<void*>(&f64) : &f32, number_bytes());
  }
  return code_.newConst(ConstPoolScope::kLocal, bytes.data(), vector_bytes());
}

VectorAssembler::Mem VectorAssembler::Same(double number) {
  return Bits(std::bit_cast<uint64_t>(number), std::bit_cast<uint32_t>(static_cast<float>(number)));
}

// --- arithmetic -------------------------------------------------------------------------------

VectorAssembler::Vec VectorAssembler::Binary(Names names, const Vec& a, const Operand_& b) {
  return Emit(names, a, b);
}

VectorAssembler::Vec VectorAssembler::Add(const Vec& a, const Operand_& b) {
  return Emit({Inst::kIdVaddpd, Inst::kIdVaddps}, a, b);
}

VectorAssembler::Vec VectorAssembler::Subtract(const Vec& a, const Operand_& b) {
  return Emit({Inst::kIdVsubpd, Inst::kIdVsubps}, a, b);
}

void VectorAssembler::AddTo(const Vec& sum, const Vec& value) {
  code_.emit(is_f64_ ? Inst::kIdVaddpd : Inst::kIdVaddps, sum, sum, value);
}

void VectorAssembler::SubtractFrom(const Vec& sum, const Vec& value) {
  code_.emit(is_f64_ ? Inst::kIdVsubpd : Inst::kIdVsubps, sum, sum, value);
}

void VectorAssembler::AddOneTo(const Mem& sum, const Vec& value) {
  const x86::Xmm result = code_.newXmm();
  code_.emit(is_f64_ ? Inst::kIdVaddsd : Inst::kIdVaddss, result, value.xmm(), sum);
  code_.emit(is_f64_ ? Inst::kIdVmovsd : Inst::kIdVmovss, sum, result);
}

void VectorAssembler::SetIfZero(const Gp& to, const Vec& value) {
  Vec sum = value;
  for (uint32_t bytes = vector_bytes(); bytes > number_bytes(); bytes /= 2) {
    sum = AddHalves(sum, bytes);
  }
  code_.xor_(to, to);
  code_.emit(is_f64_ ? Inst::kIdVucomisd : Inst::kIdVucomiss, sum.xmm(), sum.xmm());
  code_.setnp(to.r8());
}

void VectorAssembler::JumpIfNan(const Vec& value, const Label& to) {
  const Mask nan = *Compare(x86::VCmpImm::kUNORD_Q, value, value).mask;
  if (is_avx512_) {
    code_.kortestw(nan.as<x86::KReg>(), nan.as<x86::KReg>());
  } else {
    const Gp bits = code_.newUInt32();
    code_.emit(is_f64_ ? Inst::kIdVmovmskpd : Inst::kIdVmovmskps, bits, nan);
    code_.test(bits, bits);
  }
  code_.jnz(to);
}

VectorAssembler::Vec VectorAssembler::KeepWhere(const Vec& value, const Mem& mask) {
  return Emit({Inst::kIdVandpd, Inst::kIdVandps}, value, mask);
}

VectorAssembler::Vec VectorAssembler::AddHalves(const Vec& value, uint32_t bytes) {
  const x86::Xmm upper128 = code_.newXmm();
  const Vec to = NewVector();
  const auto add = [&](const Operand_& a, const Operand_& b, const Operand_& out) {
    code_.emit(is_f64_ ? Inst::kIdVaddpd : Inst::kIdVaddps, out, a, b);
  };
  if (bytes == 64) {
    const x86::Ymm upper = code_.newYmm();
    code_.vextractf64x4(upper, value, 1);
    add(value.ymm(), upper, to.ymm());
  } else if (bytes == 32) {
    if (is_avx512_) {
      code_.vextractf32x4(upper128, value.ymm(), 1);
    } else {
      code_.vextractf128(upper128, value.ymm(), 1);
    }
    add(value.xmm(), upper128, to.xmm());
  } else if (bytes == 16) {
    code_.vmovhlps(upper128, value.xmm(), value.xmm());
    add(value.xmm(), upper128, to.xmm());
  } else {
    code_.vpshufd(upper128, value.xmm(), 1);
    add(value.xmm(), upper128, to.xmm());
  }
  return to;
}

VectorAssembler::Vec VectorAssembler::Sign(Operation operation, const Vec& a) {
  if (operation == Operation::kNegate) {
    return Emit({Inst::kIdVxorpd, Inst::kIdVxorps}, a, Same(-0.0));
  }
  return Emit({Inst::kIdVandpd, Inst::kIdVandps}, a, Bits(~(uint64_t{1} << 63), ~(1u << 31)));
}

VectorAssembler::Vec VectorAssembler::Floor(const Vec& a) {
  constexpr int kDown = 9;  // towards minus infinity, without an exception
  const Names names = is_avx512_ ? Names{Inst::kIdVrndscalepd, Inst::kIdVrndscaleps}
                                 : Names{Inst::kIdVroundpd, Inst::kIdVroundps};
  return Add(Emit(names, a, imm(kDown)), Zero());
}

// --- conditions -------------------------------------------------------------------------------

VectorAssembler::Vec VectorAssembler::Number(VectorValue& value) {
  if (!value.number) {
    const Vec to = NewVector();
    if (is_avx512_) {
      code_.k(value.mask->as<x86::KReg>()).z();
      code_.emit(is_f64_ ? Inst::kIdVmovupd : Inst::kIdVmovups, to, Same(1));
    } else {
      code_.vandps(to, value.mask->as<Vec>(), Same(1));
    }
    value.number = to;
  }
  return *value.number;
}

VectorValue VectorAssembler::Compare(x86::VCmpImm predicate, const Vec& a, const Vec& b) {
  const Mask to = is_avx512_ ? Mask(code_.newKq()) : Mask(NewVector());
  code_.emit(is_f64_ ? Inst::kIdVcmppd : Inst::kIdVcmpps, to, a, b, imm(predicate));
  return {std::nullopt, to};
}

VectorAssembler::Mask VectorAssembler::MaskOf(VectorValue& value) {
  // NaN counts as true, as in the evaluator.
  if (!value.mask) value.mask = Compare(x86::VCmpImm::kNEQ_UQ, *value.number, Zero()).mask;
  return *value.mask;
}

VectorValue VectorAssembler::Join(Operation operation, VectorValue& a, VectorValue& b) {
  const Mask left = MaskOf(a), right = MaskOf(b);
  const bool both = operation == Operation::kAnd;
  const Mask to = is_avx512_ ? Mask(code_.newKq()) : Mask(NewVector());
  if (is_avx512_) {
    code_.emit(both ? Inst::kIdKandw : Inst::kIdKorw, to, left, right);
  } else {
    code_.emit(both ? Inst::kIdVandps : Inst::kIdVorps, to, left, right);
  }
  return {std::nullopt, to};
}

VectorAssembler::Vec VectorAssembler::Select(VectorValue& condition, VectorValue& a,
                                             VectorValue& b) {
  const Vec to = NewVector(), yes = Number(a), no = Number(b);
  const Mask mask = MaskOf(condition);
  if (is_avx512_) {
    code_.k(mask.as<x86::KReg>());
    code_.emit(is_f64_ ? Inst::kIdVblendmpd : Inst::kIdVblendmps, to, no, yes);
  } else {
    code_.emit(is_f64_ ? Inst::kIdVblendvpd : Inst::kIdVblendvps, to, no, yes, mask);
  }
  return to;
}

// --- operations -------------------------------------------------------------------------------

VectorAssembler::Vec VectorAssembler::Call(Operation operation, const Vec& a, const Vec* b) {
  if (!arguments_) {
    arguments_.emplace();
    for (Mem& each : *arguments_) each = code_.newStack(64, 64);
  }
  const auto& [first, second, result] = *arguments_;
  const Gp places[] = {code_.newUIntPtr(), code_.newUIntPtr(), code_.newUIntPtr()};
  Store(first, a);
  if (b != nullptr) Store(second, *b);
  for (size_t i = 0; i < 3; ++i) code_.lea(places[i], (*arguments_)[i]);
  const Gp function = code_.newUIntPtr();
  code_.mov(function, imm(reinterpret_cast<uint64_t>(function_)));
  InvokeNode* call = nullptr;
  code_.invoke(&call, function, FuncSignatureT<void, uint32_t, void*, void*, void*>());
  if (call == nullptr) return a;  // the error handler has thrown or noted the error
  call->setArg(0, imm(static_cast<uint32_t>(operation)));
  for (size_t i = 0; i < 3; ++i) call->setArg(i + 1, places[i == 1 && b == nullptr ? 0 : i]);
  return Load(result);
}

VectorValue VectorAssembler::Compute(Operation operation, VectorValue* a, VectorValue* b,
                                     VectorValue* c) {
  const auto binary = [&](Names names) -> VectorValue {
    return {Emit(names, Number(*a), Number(*b)), std::nullopt};
  };
  // Computes the smaller or the larger number. The instruction returns its second operand unless
  // the first operand is smaller (or larger). The operation returns its first operand in this case,
  // so the operands are exchanged.
  const auto extreme = [&](Names names) -> VectorValue {
    if (a == b) return {Number(*a), std::nullopt};
    return {Emit(names, Number(*b), Number(*a)), std::nullopt};
  };
  const auto compare = [&](x86::VCmpImm predicate) {
    return Compare(predicate, Number(*a), Number(*b));
  };
  switch (operation) {
    case Operation::kAdd:
      return binary({Inst::kIdVaddpd, Inst::kIdVaddps});
    case Operation::kSubtract:
      return binary({Inst::kIdVsubpd, Inst::kIdVsubps});
    case Operation::kMultiply:
      return binary({Inst::kIdVmulpd, Inst::kIdVmulps});
    case Operation::kDivide:
      return binary({Inst::kIdVdivpd, Inst::kIdVdivps});
    case Operation::kMin:
      return extreme({Inst::kIdVminpd, Inst::kIdVminps});
    case Operation::kMax:
      return extreme({Inst::kIdVmaxpd, Inst::kIdVmaxps});
    case Operation::kNegate:
    case Operation::kAbs:
      return {Sign(operation, Number(*a)), std::nullopt};
    case Operation::kSqrt:
      return {Emit({Inst::kIdVsqrtpd, Inst::kIdVsqrtps}, Number(*a), Operand()), std::nullopt};
    case Operation::kFloor:
      return {Floor(Number(*a)), std::nullopt};
    case Operation::kLess:
      return compare(x86::VCmpImm::kLT_OQ);
    case Operation::kLessOrEqual:
      return compare(x86::VCmpImm::kLE_OQ);
    case Operation::kEqual:
      return compare(x86::VCmpImm::kEQ_OQ);
    case Operation::kAnd:
    case Operation::kOr:
      return Join(operation, *a, *b);
    case Operation::kNot:
      return Compare(x86::VCmpImm::kEQ_OQ, Number(*a), Zero());
    case Operation::kSelect:
      return {Select(*a, *b, *c), std::nullopt};
    default: {
      const Vec first = Number(*a);
      if (b == nullptr) return {Call(operation, first, nullptr), std::nullopt};
      const Vec second = Number(*b);
      return {Call(operation, first, &second), std::nullopt};
    }
  }
}

}  // namespace vesper::text
