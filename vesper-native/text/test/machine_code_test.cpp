// SPDX-License-Identifier: Apache-2.0
// Machine code of laws as text gives the bits of the evaluator: for the texts that are shipped and
// for random programs, on all instruction sets, on one thread and two.
// VESPER_RANDOM_PROGRAMS sets the number of random programs.
#include "machine_code.hpp"

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <numeric>
#include <random>
#include <span>
#include <sstream>
#include <thread>

#include "evaluator.hpp"
#include "problem.hpp"
#include "prototype.hpp"
#include "vesper/engine.h"

namespace vesper::text {
namespace {

/// Calls the ranges on one thread, or alternately on two.
template <size_t threads>
void CallRanges(void*, uint64_t count, uint64_t grain,
                void (*body)(void* user, uint64_t begin, uint64_t end), void* user) {
  const auto run = [&](uint64_t first) {
    for (uint64_t begin = first * grain; begin < count; begin += threads * grain) {
      body(user, begin, std::min(count, begin + grain));
    }
  };
  if constexpr (threads == 2) {
    std::thread other(run, 1);
    run(0);
    other.join();
  } else {
    run(0);
  }
}

/// The columns of a law: all kinds but `world` have the same number of rows.
template <class Real>
struct Columns {
  std::vector<std::vector<Real>> numbers;
  std::vector<std::vector<uint32_t>> references;

  Columns(const LawCode& law, uint64_t rows, uint32_t seed) {
    std::mt19937 random(seed);
    for (const PropertyCode& property : law.properties) {
      const uint64_t count = property.kind == "world" ? 1 : rows;
      auto& column = numbers.emplace_back();
      auto& ends = references.emplace_back();
      const bool special = random() % 16 == 0;
      for (uint64_t i = 0; i < count * property.components; ++i) {
        if (property.is_reference) {
          ends.push_back(static_cast<uint32_t>(random() % rows));
          continue;
        }
        const double u = static_cast<double>(random()) / 4294967296.0;
        column.push_back(static_cast<Real>(property.accumulator ? 0 : 4 * u - 1));
        if (random() % 64 != 0) continue;
        constexpr double kSpecial[] = {0, -0.0, 1, 1e-30, 1e30, INFINITY, NAN};
        column.back() = static_cast<Real>(kSpecial[random() % (special ? 7 : 4)]);
      }
    }
  }
};

struct Outcome {
  std::vector<std::string> faults;
  std::vector<double> energies;
};

template <class Real>
struct Way {
  const Kernels<Real>& kernels;
  bool machine_code;
  decltype(vesper_host::parallel_for) parallel_for;
};

/// A copy of a column, behind which nothing can be read: the next page belongs to nobody.
class GuardedColumn {
 public:
  explicit GuardedColumn(std::span<const std::byte> column) : size_(column.size()) {
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    const size_t used = (size_ + page - 1) / page * page;
    mapped_ = used + page;
    memory_ = static_cast<std::byte*>(
        mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (memory_ == MAP_FAILED) throw std::bad_alloc();
    if (mprotect(memory_ + used, page, PROT_NONE) != 0) throw std::bad_alloc();
    data_ = memory_ + used - size_;
    std::ranges::copy(column, data_);
  }
  GuardedColumn(const GuardedColumn&) = delete;
  GuardedColumn& operator=(const GuardedColumn&) = delete;
  ~GuardedColumn() { munmap(memory_, mapped_); }

  void* data() { return data_; }
  void CopyTo(std::span<std::byte> column) const { std::copy_n(data_, size_, column.begin()); }

 private:
  size_t size_;
  size_t mapped_;
  std::byte* memory_;
  std::byte* data_;
};

/// Calls a law in some steps. Its results are then in `columns`.
template <class Real>
Outcome Apply(const LawCode& law, std::string_view text, const Way<Real>& way,
              Columns<Real>& columns) {
  vesper_host host{};
  host.parallel_for = way.parallel_for;
  std::vector<double> parameters;
  for (const ParameterCode& parameter : law.parameters) parameters.push_back(parameter.value);
  Evaluator<Real> evaluator(law, "x.law", text, host, parameters.data(), way.kernels,
                            way.machine_code);
  if (way.machine_code) {
    EXPECT_EQ(evaluator.WhyEvaluated(), "") << way.kernels.name;
  }
  std::vector<vesper_property> bound;
  std::vector<std::unique_ptr<GuardedColumn>> guarded(law.properties.size());
  for (const uint32_t i : law.table_order) {
    vesper_property property{};
    const bool reference = law.properties[i].is_reference;
    guarded[i] =
        std::make_unique<GuardedColumn>(reference ? std::as_bytes(std::span(columns.references[i]))
                                                  : std::as_bytes(std::span(columns.numbers[i])));
    property.data = guarded[i]->data();
    const size_t size = reference ? columns.references[i].size() : columns.numbers[i].size();
    property.row_count = size / law.properties[i].components;
    if (law.properties[i].optional && i % 2 == 1) {  // an absent property
      property.data = nullptr;
      property.row_count = 0;
    }
    bound.push_back(property);
  }
  evaluator.Bind(bound.data());
  Outcome outcome;
  for (uint32_t call = 0; call < 4; ++call) {
    vesper_step step{};
    step.stage = law.phase == VESPER_PHASE_INTEGRATE ? call % (law.stages + 1) : 1;
    step.stage_count = 1;
    step.dt = 0.01;
    step.time = 0.01 * call;
    const std::optional<Fault> fault = evaluator.Advance(step);
    outcome.faults.push_back(fault ? fault->message + fault->property : "");
    outcome.energies.push_back(evaluator.PotentialEnergy());
  }
  for (const uint32_t i : law.table_order) {
    if (law.properties[i].is_reference) continue;
    guarded[i]->CopyTo(std::as_writable_bytes(std::span(columns.numbers[i])));
  }
  return outcome;
}

/// Numbers that are NaN have many bit patterns. All of them count as equal.
template <class Real>
bool SameNumber(Real a, Real b) {
  return (std::isnan(a) && std::isnan(b)) || std::memcmp(&a, &b, sizeof a) == 0;
}

/// Returns whether all ways give the bits of the evaluator with the baseline instruction set.
template <class Real>
testing::AssertionResult AllWaysAgree(const LawCode& law, std::string_view text, uint64_t rows,
                                      uint32_t seed, bool two_threads) {
  const auto& sets = AvailableKernels<Real>();
  Columns<Real> expected(law, rows, seed);
  const Outcome wanted = Apply<Real>(law, text, {sets.back(), false, CallRanges<1>}, expected);
  for (const Kernels<Real>& kernels : sets) {
    if (kernels.set == InstructionSet::kBaseline) continue;
    for (const auto parallel_for : {CallRanges<1>, CallRanges<2>}) {
      if (parallel_for == CallRanges<2> && !two_threads) continue;
      Columns<Real> found(law, rows, seed);
      const Outcome outcome = Apply<Real>(law, text, {kernels, true, parallel_for}, found);
      const auto where = [&] {
        return testing::AssertionFailure() << kernels.name << ", " << law.name << ", f"
                                           << 8 * sizeof(Real) << ", " << rows << " rows: ";
      };
      if (outcome.faults != wanted.faults) {
        for (size_t i = 0; i < wanted.faults.size(); ++i) {
          if (outcome.faults[i] == wanted.faults[i]) continue;
          return where() << "fault '" << outcome.faults[i] << "', expected '" << wanted.faults[i]
                         << "'";
        }
      }
      for (size_t i = 0; i < wanted.energies.size(); ++i) {
        if (!SameNumber(outcome.energies[i], wanted.energies[i])) {
          return where() << "energy " << outcome.energies[i] << ", expected " << wanted.energies[i];
        }
      }
      for (size_t p = 0; p < law.properties.size(); ++p) {
        for (size_t i = 0; i < expected.numbers[p].size(); ++i) {
          if (SameNumber(found.numbers[p][i], expected.numbers[p][i])) continue;
          return where() << law.properties[p].name << "[" << i << "] is " << found.numbers[p][i]
                         << ", expected " << expected.numbers[p][i];
        }
      }
    }
  }
  return testing::AssertionSuccess();
}

// --- texts ------------------------------------------------------------------------------------

std::string TextOf(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Returns the texts that are shipped, and those of the documents.
std::vector<std::string> ShippedTexts() {
  std::vector<std::string> texts;
  for (const char* folder : {"/laws", "/worlds"}) {
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(std::string(VESPER_ROOT) + folder)) {
      if (entry.path().extension() == ".law") texts.push_back(TextOf(entry.path()));
    }
  }
  const std::string page = TextOf(std::string(VESPER_ROOT) + "/docs/laws-as-text.md");
  for (size_t at = 0; (at = page.find("\n```law title=", at)) != std::string::npos;) {
    const size_t begin = page.find('\n', at + 1) + 1;
    at = page.find("\n```", begin) + 4;
    texts.push_back(page.substr(begin, at - 3 - begin));
  }
  return texts;
}

/// Texts with all kinds of blocks and functions.
constexpr const char* kMore[] = {
    "law lennard_jones\n"
    "  each pair of bodies within 1.5 m, r apart:\n"
    "    energy = 4 J ((1 m/r)^12 - (1 m/r)^6)\n",
    "law waves\n"
    "  each pair of bodies, r apart:\n"
    "    energy = -1 N*m^2 / sqrt(r^2 + 1 m^2) * (1 + 0.1 sin(r / 1 m)) * exp(-r / 3 m)\n"
    "    a.heat += 1; b.heat -= a.mass / (2 kg)\n"
    "  each body has heat\n",
    "law choices\n"
    "  each body:\n"
    "    if mass > 1 kg and not velocity.x < 0 m/s or position.y = 0 m:\n"
    "      force.y += max(mass, 2 kg) * 3 m/s^2\n"
    "    else:\n"
    "      force -= min(|velocity| / (1 m/s), floor(position.x / (1 m))) * velocity * 1 kg/s\n"};

std::vector<LawCode> CheckedLaws(const std::string& text, const Prototype& prototype) {
  Problems problems;
  std::vector<LawCode> codes;
  for (const LawTree& law : Parse(text, problems)) {
    codes.push_back(Check(text, law, prototype, problems));
  }
  EXPECT_TRUE(problems.empty()) << problems.Report("x.law", text);
  return codes;
}

TEST(MachineCodeTest, TextsGiveTheBitsOfTheEvaluator) {
  if (!WhyNoMachineCode().empty()) GTEST_SKIP() << WhyNoMachineCode();
  const Prototype prototype(*vesper_prototype_standard("si-f64"));
  std::vector<std::string> texts = ShippedTexts();
  EXPECT_GE(texts.size(), 12u);
  texts.insert(texts.end(), std::begin(kMore), std::end(kMore));
  for (const std::string& text : texts) {
    for (const LawCode& law : CheckedLaws(text, prototype)) {
      for (const uint64_t rows : {1, 7, 64, 100, 259}) {
        EXPECT_TRUE(AllWaysAgree<double>(law, text, rows, 1, false));
        EXPECT_TRUE(AllWaysAgree<float>(law, text, rows, 2, false));
      }
    }
  }
}

// Rows are divided from 4096 rows on, and pairs from 2048 rows on.
TEST(MachineCodeTest, TwoThreadsGiveTheBitsOfTheEvaluator) {
  if (!WhyNoMachineCode().empty()) GTEST_SKIP() << WhyNoMachineCode();
  const Prototype prototype(*vesper_prototype_standard("si-f64"));
  for (const char* name : {"lorentz_field", "hooke_spring", "newton_gravitation"}) {
    const std::string folder = std::string(VESPER_ROOT) + "/laws/" + name + "/";
    const std::string text = TextOf(folder + name + ".law");
    for (const LawCode& law : CheckedLaws(text, prototype)) {
      const uint64_t rows = law.passes[0].kind == BlockKind::kPairs ? 2100 : 9001;
      EXPECT_TRUE(AllWaysAgree<double>(law, text, rows, 3, true));
      EXPECT_TRUE(AllWaysAgree<float>(law, text, rows, 4, true));
    }
  }
}

// --- random programs --------------------------------------------------------------------------

enum : uint16_t { kPosition, kVelocity, kMass, kForce, kSpin, kEnds, kLength, kPush, kGravity };

/// A law with one block of random operations. Its properties are those above.
class RandomLaw {
 public:
  explicit RandomLaw(uint32_t seed) : random_(seed) {
    law_.name = "program " + std::to_string(seed);
    Property("position", "body", 3);
    Property("velocity", "body", 3);
    Property("mass", "body", 1);
    Property("force", "body", 3).accumulator = true;
    Property("spin", "body", 4);
    Property("ends", "spring", 2).is_reference = true;
    Property("length", "spring", 1).optional = true;
    Property("push", "spring", 1);
    Property("gravity", "world", 3);
    for (const double value : {0.5, -2.0}) law_.parameters.push_back({"p", "", {}, value, 0, 0});
  }

  LawCode Make() { return Make(random_() % 60); }

  LawCode Make(size_t operations) {
    PassCode pass{};
    const uint32_t kind = random_() % 4;
    pass.kind = kind == 0 ? BlockKind::kRows : kind == 1 ? BlockKind::kJoined : BlockKind::kPairs;
    pass.rows = kind == 1 ? "spring" : "body";
    pass.position = kPosition;
    if (kind == 1) pass.references = {{kFirst, kEnds, 0}, {kFirst, kEnds, 1}};
    for (Load& reference : pass.references) reference.participant = kOwnRow;
    if (kind != 0) pass.participant_names = {"a", "b"};
    if (kind == 3) pass.within = law_.graph.Constant(0.7);
    AddLeaves(kind);
    for (size_t i = 0; i < operations; ++i) AddOperation();
    AddOutputs(kind, pass);
    if (random_() % 4 == 0) pass.energy = Any();
    law_.passes.push_back(std::move(pass));
    return std::move(law_);
  }

 private:
  PropertyCode& Property(const char* name, const char* kind, uint32_t components) {
    law_.table_order.push_back(static_cast<uint32_t>(law_.properties.size()));
    PropertyCode& property = law_.properties.emplace_back();
    property.name = name;
    property.kind = kind;
    property.components = components;
    return property;
  }

  NodeId Any() {
    // The newest values are chosen most often.
    const size_t back =
        random_() % (random_() % 3 == 0 ? values_.size() : std::min<size_t>(values_.size(), 8));
    return values_[values_.size() - 1 - back];
  }

  void AddLeaves(uint32_t kind) {
    Graph& graph = law_.graph;
    values_ = {graph.Constant(0),
               graph.Constant(-1),
               graph.Constant(1.75),
               graph.Parameter(0),
               graph.Parameter(1),
               graph.Leaf(Operation::kTime),
               graph.Leaf(Operation::kStep),
               graph.LoadOf({kWorld, kGravity, 1})};
    std::vector<uint16_t> bodies{kOwnRow};
    if (kind != 0) bodies = {kFirst, kFirst + 1};
    for (const uint16_t body : bodies) {
      for (uint16_t property = kPosition; property <= kSpin; ++property) {
        if (property == kForce || random_() % 3 == 0) continue;
        const uint32_t components = law_.properties[property].components;
        for (uint16_t k = 0; k < components; ++k) {
          if (random_() % 5 != 0) values_.push_back(graph.LoadOf({body, property, k}));
        }
      }
    }
    if (kind == 1) {
      values_.push_back(graph.LoadOf({kOwnRow, kLength, 0}));
      values_.push_back(graph.LoadOf({kOwnRow, kPush, 0}));
    }
  }

  void AddOperation() {
    constexpr Operation kBinary[] = {Operation::kAdd,  Operation::kSubtract, Operation::kMultiply,
                                     Operation::kAdd,  Operation::kMultiply, Operation::kDivide,
                                     Operation::kMin,  Operation::kMax,      Operation::kLess,
                                     Operation::kAtan2};
    constexpr Operation kUnary[] = {
        Operation::kNegate, Operation::kSqrt, Operation::kAbs,  Operation::kFloor, Operation::kExp,
        Operation::kLn,     Operation::kSin,  Operation::kCos,  Operation::kTan,   Operation::kAsin,
        Operation::kAcos,   Operation::kAtan, Operation::kTanh, Operation::kNot};
    constexpr Operation kConditions[] = {Operation::kLess,  Operation::kLessOrEqual,
                                         Operation::kEqual, Operation::kAnd,
                                         Operation::kOr,    Operation::kPower};
    Graph& graph = law_.graph;
    switch (random_() % 6) {
      case 0:
        values_.push_back(graph.Unary(kUnary[random_() % std::size(kUnary)], Any()));
        if (random_() % 2 == 0) values_.push_back(graph.Unary(Operation::kAbs, values_.back()));
        break;
      case 1:
        values_.push_back(
            graph.Binary(kConditions[random_() % std::size(kConditions)], Any(), Any()));
        break;
      case 2:
        values_.push_back(graph.Select(Any(), Any(), Any()));
        break;
      default:
        values_.push_back(graph.Binary(kBinary[random_() % std::size(kBinary)], Any(), Any()));
        break;
    }
  }

  void AddOutputs(uint32_t kind, PassCode& pass) {
    const auto output = [&](uint16_t participant, uint16_t property, bool add) {
      for (uint16_t k = 0; k < law_.properties[property].components; ++k) {
        if (random_() % 6 == 0) continue;
        pass.outputs.push_back({{participant, property, k}, add, Any(), {}});
      }
    };
    if (kind == 0) {
      output(kOwnRow, kForce, true);
      for (const uint16_t property : {kVelocity, kMass, kSpin, kPosition}) {
        if (random_() % 2 == 0) output(kOwnRow, property, random_() % 3 == 0);
      }
    } else {
      output(kFirst, kForce, true);
      if (random_() % 2 == 0) {  // the opposite force
        const size_t count = pass.outputs.size();
        for (size_t i = 0; i < count; ++i) {
          Output opposite = pass.outputs[i];
          opposite.to.participant = kFirst + 1;
          opposite.value = law_.graph.Negate(opposite.value);
          pass.outputs.push_back(opposite);
        }
      } else {
        output(kFirst + 1, kForce, true);
      }
      if (random_() % 3 == 0) output(kFirst + 1, kMass, true);
    }
    if (kind == 1 && random_() % 2 == 0) output(kOwnRow, kPush, random_() % 2 == 0);
    if (pass.outputs.empty()) pass.outputs.push_back({{kFirst, kForce, 0}, true, Any(), {}});
    if (kind == 0) {
      for (Output& each : pass.outputs) each.to.participant = kOwnRow;
    }
  }

  std::mt19937 random_;
  LawCode law_;
  std::vector<NodeId> values_;
};

TEST(MachineCodeTest, RandomProgramsGiveTheBitsOfTheEvaluator) {
  if (!WhyNoMachineCode().empty()) GTEST_SKIP() << WhyNoMachineCode();
  const char* wanted = std::getenv("VESPER_RANDOM_PROGRAMS");
  const uint32_t programs =
      wanted != nullptr ? static_cast<uint32_t>(std::strtoul(wanted, nullptr, 10)) : 2000;
  std::vector<uint32_t> seeds(programs);
  std::iota(seeds.begin(), seeds.end(), 0);
  seeds.push_back(12242);  // NaN of a column precedes NaN of the formula
  for (const uint32_t seed : seeds) {
    const LawCode law = RandomLaw(seed).Make();
    const uint64_t rows = 1 + seed * 7919 % (law.passes[0].kind == BlockKind::kPairs ? 90 : 200);
    const testing::AssertionResult same =
        seed % 2 == 0 ? AllWaysAgree<double>(law, std::string(1, ' '), rows, seed, false)
                      : AllWaysAgree<float>(law, std::string(1, ' '), rows, seed, false);
    ASSERT_TRUE(same);
  }
}

// --- without machine code ---------------------------------------------------------------------

/// Forbids this process to make memory executable, as hardened systems do.
void ForbidNewCode() {
  const sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_mprotect, 0, 3),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[2])),
      BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, PROT_EXEC, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EACCES),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program{std::size(filter), const_cast<sock_filter*>(filter)};
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  ASSERT_EQ(prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program), 0);
}

TEST(MachineCodeTest, ASystemThatForbidsNewCodeGetsTheEvaluatorAndAReason) {
  const auto check = [] {
    ForbidNewCode();
    std::fprintf(stderr, "%s\n", FindWhyNoMachineCode(nullptr).c_str());
    const LawCode law = RandomLaw(4).Make();
    Columns<double> columns(law, 9, 1);
    const Kernels<double>& kernels = AvailableKernels<double>().front();
    const double parameters[] = {1, 2};
    vesper_host host{};
    Evaluator<double> evaluator(law, "x.law", " ", host, parameters, kernels, true);
    std::fprintf(stderr, "%s\n", evaluator.WhyEvaluated().c_str());
    Apply<double>(law, " ", {kernels, false, CallRanges<1>}, columns);
    std::exit(0);
  };
  constexpr const char* kReason = "the operating system refuses to execute generated code: ";
  EXPECT_EXIT(check(), testing::ExitedWithCode(0),
              std::string(kReason) + "Permission denied\n" + kReason + "Permission denied");
}

TEST(MachineCodeTest, AVariableChoosesTheEvaluator) {
  EXPECT_EQ(FindWhyNoMachineCode("0"), "the environment variable VESPER_TEXT_MACHINE_CODE is 0");
  EXPECT_EQ(FindWhyNoMachineCode("1"), FindWhyNoMachineCode(nullptr));
}

TEST(MachineCodeTest, LargeProgramsAreEvaluated) {
  if (!WhyNoMachineCode().empty()) GTEST_SKIP() << WhyNoMachineCode();
  const LawCode law = RandomLaw(4).Make(9000);
  const double parameters[] = {1, 2};
  vesper_host host{};
  const Evaluator<double> evaluator(law, "x.law", " ", host, parameters);
  EXPECT_NE(evaluator.WhyEvaluated().find("operations, at most 2000 are compiled"),
            std::string::npos)
      << evaluator.WhyEvaluated();
}

}  // namespace
}  // namespace vesper::text
