// SPDX-License-Identifier: Apache-2.0
#include "subject.hpp"

#include <algorithm>
#include <cmath>

namespace vesper {
namespace {

constexpr Check kChecks[] = {
    {"exports", "exports its entry and nothing else", false, CheckExports},
    {"imports", "imports symbols from the standard libraries only", false, CheckImports},
    {"table", "its declarations are complete and valid", false, CheckTable},
    {"precisions", "declares the same in both precisions", false, CheckPrecisions},
    {"guard-pages", "accesses its rows only, and writes only where it may", true, CheckGuardPages},
    {"rows", "runs on 0, 1, 7 and 1021 rows as declared", true, CheckRows},
    {"reload", "loads and unloads 25 times without leaks", true, CheckReload},
    {"threads", "same bits on 1, 2 and 8 threads", true, CheckThreads},
    {"repeat", "same bits in a second run", true, CheckRepeat},
    {"rollback", "same bits after a rollback and after a restart", true, CheckRollback},
    {"mass-0", "accepts bodies of mass 0 and does not move them", true, CheckMassZero},
    {"output", "writes nothing to standard output or standard error", true, CheckOutput},
    {"coincident", "accepts bodies at one place", true, CheckCoincident},
    {"modes", "leaves the floating-point modes as they were", true, CheckModes},
    {"memory", "needs no more memory in later steps", true, CheckMemory},
    {"step-length", "its forces do not depend on dt", true, CheckStepLength},
    {"names", "has no misspelt names of standard properties", true, CheckNames},
    {"parameters", "accepts the limits of every parameter", true, CheckParameters},
    {"not-a-number", "NaN in an input is reported or has no influence", true, CheckNotANumber},
    {"momentum", "its forces sum to zero", true, CheckMomentum},
    {"angular-momentum", "its moments sum to zero", true, CheckAngularMomentum},
    {"translation", "results do not depend on the origin", true, CheckTranslation},
    {"rotation", "results rotate with the world", true, CheckRotation},
    {"potential-energy", "its forces are the gradient of its potential energy", true,
     CheckPotentialEnergy},
    {"energy", "its forces do the work by which its potential energy falls", true, CheckEnergy},
    {"convergence", "its error vanishes with dt", true, CheckConvergence},
    {"time", "nanoseconds per row", true, MeasureTime},
};

}  // namespace

std::span<const Check> Checks() { return kChecks; }

LawsUnderTest::LawsUnderTest(const Subject& subject)
    : file_(subject.file),
      real_type_(subject.real_type),
      library_(subject.file),
      laws_(library_.Laws(subject.real_type)) {
  if (real_type_ != 0 && laws_.empty()) throw CheckSkipped("has no law in this precision");
}

void LawsUnderTest::RequireClaim(uint32_t claim) const {
  const bool all =
      std::ranges::all_of(laws_, [&](const auto* law) { return (law->claims & claim) != 0; });
  if (!all) throw CheckSkipped("not claimed");
}

std::vector<vesper_property_use> LawsUnderTest::Uses() const {
  std::vector<vesper_property_use> uses;
  for (const vesper_law_desc* law : laws_) {
    uses.insert(uses.end(), law->uses, law->uses + law->use_count);
  }
  return uses;
}

std::set<std::string> LawsUnderTest::Written() const {
  std::set<std::string> names;
  for (const vesper_property_use& use : Uses()) {
    if (use.access == VESPER_WRITE || use.access == VESPER_READ_WRITE ||
        use.access == VESPER_ACCUMULATE) {
      names.insert(use.name);
    }
  }
  return names;
}

void LawsUnderTest::ExpectSameResults(const World& a, const World& b, double slack) const {
  for (const std::string& name : Written()) {
    const AnyColumn &x = a[name], &y = b[name];
    const double tolerance = Tolerance(slack * (1 + x.Largest()));
    for (uint64_t i = 0; i < x.size(); ++i) {
      Expect(std::abs(x.Get(i) - y.Get(i)) <= tolerance,
             "'" + name + "' differs in row " + std::to_string(i / x.descriptor().components) +
                 ": " + std::to_string(x.Get(i)) + " and " + std::to_string(y.Get(i)) + " (seed " +
                 std::to_string(kSeed) + ")");
    }
  }
}

}  // namespace vesper
