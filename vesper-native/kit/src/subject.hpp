// SPDX-License-Identifier: Apache-2.0
// One library in one precision, the subject of the checks.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "expect.hpp"
#include "vesper/kit/check.hpp"
#include "vesper/kit/law_file.hpp"
#include "vesper/kit/world.hpp"

namespace vesper {

inline constexpr uint32_t kSeed = 20260;
inline constexpr double kDt = 1.0 / 240;  // [s]

class LawsUnderTest {
 public:
  explicit LawsUnderTest(const Subject& subject);

  const std::string& file() const { return file_; }
  const LawFile& library() const { return library_; }
  vesper_scalar_type real_type() const { return real_type_; }
  const std::vector<const vesper_law_desc*>& laws() const { return laws_; }

  World MakeWorld(uint64_t rows) const {
    return World(real_type_, laws_, library_.Fields(), rows, kSeed);
  }
  /// Skips the check unless all laws of the library make the claim.
  void RequireClaim(uint32_t claim) const;
  /// Returns the rounding tolerance of a sum of some hundred numbers of this size.
  double Tolerance(double size) const { return size * (real_type_ == VESPER_F64 ? 1e-12 : 1e-4); }
  /// Returns the uses of all laws.
  std::vector<vesper_property_use> Uses() const;
  /// Returns the names of the properties that the laws write.
  std::set<std::string> Written() const;
  /// Throws unless the laws wrote equal results in both worlds, up to rounding.
  void ExpectSameResults(const World& a, const World& b, double slack) const;

 private:
  std::string file_;
  vesper_scalar_type real_type_;
  LawFile library_;
  std::vector<const vesper_law_desc*> laws_;
};

// The checks, grouped by file; see Checks().
std::string CheckExports(const Subject&);
std::string CheckImports(const Subject&);
std::string CheckTable(const Subject&);
std::string CheckPrecisions(const Subject&);
std::string CheckReload(const Subject&);
std::string CheckRows(const Subject&);
std::string CheckGuardPages(const Subject&);
std::string CheckThreads(const Subject&);
std::string CheckRepeat(const Subject&);
std::string CheckRollback(const Subject&);
std::string CheckMassZero(const Subject&);
std::string CheckOutput(const Subject&);
std::string CheckCoincident(const Subject&);
std::string CheckModes(const Subject&);
std::string CheckMemory(const Subject&);
std::string CheckStepLength(const Subject&);
std::string CheckNames(const Subject&);
std::string CheckParameters(const Subject&);
std::string CheckNotANumber(const Subject&);
std::string CheckMomentum(const Subject&);
std::string CheckAngularMomentum(const Subject&);
std::string CheckTranslation(const Subject&);
std::string CheckRotation(const Subject&);
std::string CheckPotentialEnergy(const Subject&);
std::string CheckEnergy(const Subject&);
std::string CheckConvergence(const Subject&);
std::string MeasureTime(const Subject&);

}  // namespace vesper
