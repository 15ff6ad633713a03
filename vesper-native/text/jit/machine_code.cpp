// SPDX-License-Identifier: Apache-2.0
#include "machine_code.hpp"

#include <cstdlib>
#include <string_view>
#include <type_traits>

#ifdef __x86_64__
#include <optional>

#include "block_code.hpp"
#include "pairs_code.hpp"
#include "rows_code.hpp"

namespace vesper::text {
namespace {

using namespace asmjit;

/// Maximum number of operations of a program that becomes machine code, so that compiling takes
/// only a few milliseconds.
constexpr size_t kMostOperations = 2000;

class Refusal : public ErrorHandler {
 public:
  void handleError(Error error, const char*, BaseEmitter*) override {
    if (reason.empty()) reason = "asmjit reports error " + std::to_string(error);
  }
  std::string reason;
};

}  // namespace

template <class Real>
MachineCode<Real> Generate(const LawCode& law, const PassCode& pass, const Program& program,
                           const Kernels<Real>& kernels) {
  MachineCode<Real> result;
  try {
    if (kernels.set == InstructionSet::kBaseline) {
      throw NoMachineCode{"the instruction set has no AVX2"};
    }
    const size_t operations = program.code.size() + program.of_first.size();
    if (operations > kMostOperations) {
      throw NoMachineCode{"the formula has " + std::to_string(operations) +
                          " operations, at most " + std::to_string(kMostOperations) +
                          " are compiled"};
    }
    Refusal refusal;
    CodeHolder holder;
    holder.init(Environment::host());
    holder.setErrorHandler(&refusal);
    x86::Compiler code(&holder);
    const auto assembler = [&] {
      return VectorAssembler(code, kernels.set == InstructionSet::kAvx512, sizeof(Real) == 8,
                             reinterpret_cast<const void*>(kernels.function));
    };
    std::optional<Label> rows, gather, pairs;
    VectorAssembler of_run = assembler(), of_rows = assembler(), of_other = assembler();
    const Label run = EmitRun(of_run, program);
    const bool all_pairs = pass.kind == BlockKind::kPairs && pass.within == kNoNode;
    if (pass.kind == BlockKind::kRows) {
      if (HasRowsCode(law, pass, program)) rows = EmitRows(of_rows, law, program);
    } else if (!all_pairs) {
      gather = EmitGather(of_other, law, program);
    } else if (!program.results.empty()) {
      pairs = EmitPairs(of_other, program, law.graph);
    }
    code.finalize();
    holder.flatten();
    holder.resolveUnresolvedLinks();
    if (!refusal.reason.empty()) throw NoMachineCode{refusal.reason};
    const size_t size = holder.codeSize();
    result.memory = CodeMemory(size, [&](uint8_t* to) {
      holder.relocateToBase(reinterpret_cast<uint64_t>(to));
      holder.copyFlattenedData(to, size);
    });
    if (!refusal.reason.empty()) throw NoMachineCode{refusal.reason};
    const auto set = [&](auto& function, const std::optional<Label>& label) {
      if (!label) return;
      uint8_t* begin = result.memory.data() + holder.labelOffset(*label);
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(begin);
    };
    set(result.run, run);
    set(result.rows, rows);
    set(result.gather, gather);
    set(result.pairs, pairs);
  } catch (const NoMachineCode& no) {
    result = {};
    result.reason = no.reason;
  }
  return result;
}

#else
namespace vesper::text {

template <class Real>
MachineCode<Real> Generate(const LawCode&, const PassCode&, const Program&, const Kernels<Real>&) {
  return {};
}

#endif

template MachineCode<float> Generate(const LawCode&, const PassCode&, const Program&,
                                     const Kernels<float>&);
template MachineCode<double> Generate(const LawCode&, const PassCode&, const Program&,
                                      const Kernels<double>&);

std::string FindWhyNoMachineCode(const char* wanted) {
  if (wanted != nullptr && std::string_view(wanted) == "0") {
    return "the environment variable VESPER_TEXT_MACHINE_CODE is 0";
  }
  if (AvailableKernels<double>().front().set == InstructionSet::kBaseline) {
    return "this processor has no AVX2";
  }
  try {
    CodeMemory(1, [](uint8_t*) {});
  } catch (const NoMachineCode& no) {
    return no.reason;
  }
  return "";
}

const std::string& WhyNoMachineCode() {
  static const std::string reason = FindWhyNoMachineCode(std::getenv("VESPER_TEXT_MACHINE_CODE"));
  return reason;
}

}  // namespace vesper::text
