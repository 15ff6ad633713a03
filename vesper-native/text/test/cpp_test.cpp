// SPDX-License-Identifier: Apache-2.0
// Laws that `vesper law to-cpp` has written, compiled, give the declarations and numbers of their
// texts. Formulas without elementary functions give the same bits; sums over many rows differ by
// rounding, because compiled laws add in another order.
#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <span>
#include <sstream>

#include "text_engine.hpp"
#include "vesper/law.h"

namespace vesper::test {
namespace {

void CallOnce(void*, uint64_t count, uint64_t, void (*body)(void*, uint64_t, uint64_t),
              void* user) {
  body(user, 0, count);
}

std::string FileText(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// A text, and the library that was written from it.
struct TwoForms {
  const vesper_law_library* text = nullptr;
  const vesper_law_library* compiled = nullptr;

  explicit TwoForms(const std::string& name, const char* prototype = "si-f64") {
    const std::string folder = VESPER_GENERATED_LAWS "/";
    const std::string source = FileText(folder + name + ".law");
    EXPECT_OK(Try([&](vesper_error* e) {
      return vesper_library_prepare_text(name.c_str(), source.data(), source.size(), &prepared_, e);
    }));
    EXPECT_OK(Try([&](vesper_error* e) {
      return vesper_library_table(prepared_, vesper_prototype_standard(prototype), &text, e);
    }));
    library_ = dlopen((folder + "libvesper_law_written_" + name + ".so").c_str(), RTLD_NOW);
    const void* entry = library_ == nullptr ? nullptr : dlsym(library_, "vesper_law_library_entry");
    if (entry == nullptr) {
      ADD_FAILURE() << dlerror();
      return;
    }
    compiled = reinterpret_cast<decltype(&vesper_law_library_entry)>(entry)();
  }
  ~TwoForms() {
    vesper_library_discard(prepared_);
    if (library_ != nullptr) dlclose(library_);
  }
  TwoForms(const TwoForms&) = delete;
  TwoForms& operator=(const TwoForms&) = delete;

 private:
  vesper_prepared_library* prepared_ = nullptr;
  void* library_ = nullptr;
};

const vesper_law_desc& LawOf(const vesper_law_library& table, const std::string& name,
                             vesper_scalar_type real) {
  for (uint32_t i = 0; i < table.law_count; ++i) {
    if (table.laws[i].name == name && table.laws[i].real_type == real) return table.laws[i];
  }
  ADD_FAILURE() << "no law " << name;
  return table.laws[0];
}

std::string UseText(const vesper_property_use& use) {
  std::ostringstream text;
  text << use.kind << "." << use.name << " type " << use.scalar_type << " x " << use.components
       << " access " << use.access << " flags " << use.flags << " unit";
  for (const int8_t exponent : use.unit.exponent) text << " " << int{exponent};
  return text.str();
}

std::string Declaration(const vesper_law_desc& law) {
  std::ostringstream text;
  text.precision(17);
  text << law.name << " " << law.version << " " << law.doc << " phase " << law.phase << " stages "
       << law.stages << " from " << law.first_stage << " claims " << law.claims << " energy "
       << (law.potential_energy != nullptr) << "\n";
  for (uint32_t i = 0; i < law.use_count; ++i) text << UseText(law.uses[i]) << "\n";
  for (uint32_t i = 0; i < law.parameter_count; ++i) {
    const vesper_parameter_desc& parameter = law.parameters[i];
    text << parameter.name << " " << parameter.doc << " " << parameter.default_value << " "
         << parameter.minimum << " " << parameter.maximum << " unit";
    for (const int8_t exponent : parameter.unit.exponent) text << " " << int{exponent};
    text << "\n";
  }
  for (uint32_t i = 0; law.force_weights != nullptr && i <= law.stages; ++i) {
    text << law.force_weights[i] << " ";
  }
  return text.str();
}

std::string DeclarationsOfFields(const vesper_law_library& table) {
  std::ostringstream text;
  for (uint32_t i = 0; i < table.field_count; ++i) {
    const vesper_field_desc& field = table.fields[i];
    text << field.name << " " << field.doc << " x " << field.components << " of time "
         << (field.begin_step != nullptr) << " unit";
    for (const int8_t exponent : field.unit.exponent) text << " " << int{exponent};
    text << "\n";
  }
  return text.str();
}

/// Computes (y, x z, x - 1).
void Blow(void*, uint64_t count, const double* at, double* out) {
  for (uint64_t i = 0; i < count; ++i) {
    out[3 * i] = at[3 * i + 1];
    out[3 * i + 1] = at[3 * i] * at[3 * i + 2];
    out[3 * i + 2] = at[3 * i] - 1;
  }
}

/// The results of a law for columns with random numbers, in four calls.
template <class Real>
struct Run {
  std::vector<std::string> names;
  std::vector<std::vector<Real>> columns;
  std::vector<std::vector<double>> wide;  // columns of 64 bits in runs of single precision
  std::vector<double> energies;
  std::vector<double> fields;  // values of the fields, which the first law of the table provides
  std::string failure;         // message of the first call that failed
  vesper_field blown{sizeof(vesper_field), 0, nullptr, Blow};

  /// `lost`: the position of row 1 is NaN, so that calls may fail.
  Run(const vesper_law_library& table, const vesper_law_desc& law, uint64_t rows,
      bool lost = false) {
    std::mt19937 random(7);
    std::vector<std::vector<uint32_t>> references(law.use_count);
    columns.resize(law.use_count);
    wide.resize(law.use_count);
    std::vector<vesper_property> bound(law.use_count);
    for (uint32_t u = 0; u < law.use_count; ++u) {
      const vesper_property_use& use = law.uses[u];
      names.emplace_back(use.name);
      const uint64_t count = std::string(use.kind) == "world" ? 1 : rows;
      vesper_property& property = bound[u];
      property.struct_size = sizeof property;
      property.row_count = count;
      if (use.scalar_type == VESPER_FIELD) {
        property.row_count = 0;
        property.data = &blown;
        continue;
      }
      if (use.scalar_type == VESPER_U32) {
        // The springs form a chain, so at most two springs end at each body.
        for (uint32_t i = 0; i < count; ++i) {
          references[u].push_back(i);
          references[u].push_back(static_cast<uint32_t>((i + 1) % rows));
        }
        property.data = references[u].data();
        continue;
      }
      for (uint64_t i = 0; i < count * use.components; ++i) {
        const double value = 4 * static_cast<double>(random()) / 4294967296.0 - 1.5;
        const bool immovable = names[u] == "mass" && random() % 4 == 0;
        const bool zero = use.access == VESPER_ACCUMULATE;
        columns[u].push_back(static_cast<Real>(zero || immovable ? 0 : value));
        wide[u].push_back(value);
      }
      if (lost && names[u] == "position") columns[u][3] = std::numeric_limits<Real>::quiet_NaN();
      property.data = columns[u].data();
      if (use.scalar_type == VESPER_F64) {
        property.data = sizeof(Real) == 4 ? wide[u].data() : property.data;
      }
    }
    Call(table, law, bound, lost);
  }

  void Call(const vesper_law_library& table, const vesper_law_desc& law,
            const std::vector<vesper_property>& bound, bool may_fail) {
    vesper_host host{};
    host.struct_size = sizeof host;
    host.user = table.user;
    host.parallel_for = CallOnce;
    host.log = [](void*, uint32_t, const char*) {};
    std::vector<double> parameters;
    for (uint32_t i = 0; i < law.parameter_count; ++i) {
      parameters.push_back(law.parameters[i].default_value * 1.25);
    }
    vesper_law* instance = nullptr;
    vesper_suite* suite = nullptr;
    const auto ok = [&](auto&& call) { EXPECT_OK(Try(call)); };
    if (table.open != nullptr) {
      ok([&](vesper_error* e) { return table.open(&host, &suite, e); });
    }
    ok([&](vesper_error* e) { return law.create(&host, suite, parameters.data(), &instance, e); });
    if (instance == nullptr) return;
    if (law.bind != nullptr) {
      ok([&](vesper_error* e) { return law.bind(instance, bound.data(), e); });
    }
    for (uint32_t call = 0; call < 4; ++call) {
      vesper_step step{};
      step.struct_size = sizeof step;
      step.stage = law.stages == 0 ? 1 : call % (law.stages + 1);
      step.stage_count = std::max(law.stages, 1u);
      step.dt = 0.01;
      step.time = 0.01 * call;
      for (uint32_t u = 0; u < law.use_count; ++u) {
        if (law.uses[u].access == VESPER_ACCUMULATE) std::ranges::fill(columns[u], Real(0));
      }
      const vesper_error error =
          Try([&](vesper_error* e) { return law.advance(instance, &step, e); });
      if (may_fail && error.status != VESPER_OK) {
        failure = error.message;
        break;
      }
      EXPECT_OK(error);
      if (std::string(law.name) == table.laws[0].name) EvaluateFields(table, suite, step);
      if (law.potential_energy == nullptr) continue;
      energies.push_back(0);
      ok([&](vesper_error* e) { return law.potential_energy(instance, &energies.back(), e); });
    }
    law.destroy(instance);
    if (table.close != nullptr) table.close(suite);
  }

  void EvaluateFields(const vesper_law_library& table, vesper_suite* suite,
                      const vesper_step& step) {
    constexpr uint64_t kPlaces = 50;
    std::vector<double> at(3 * kPlaces);
    for (size_t i = 0; i < at.size(); ++i) at[i] = 2 * std::sin(static_cast<double>(i * i));
    for (uint32_t i = 0; i < table.field_count; ++i) {
      const vesper_field_desc& field = table.fields[i];
      if (field.begin_step != nullptr) field.begin_step(suite, &step);
      std::vector<double> values(kPlaces * field.components);
      field.evaluate(suite, kPlaces, at.data(), values.data());
      fields.insert(fields.end(), values.begin(), values.end());
    }
  }
};

/// Largest difference of two columns, relative to their largest number.
template <class Real>
double Difference(const std::vector<Real>& a, const std::vector<Real>& b) {
  double most = 0, size = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof(Real)) == 0) continue;
    if (!std::isfinite(a[i]) && !std::isfinite(b[i])) continue;
    most = std::max(most, std::abs(double{a[i]} - double{b[i]}));
  }
  for (const Real value : b)
    size = std::max(size, std::isfinite(value) ? std::abs(double{value}) : 0);
  return most == 0 ? 0 : most / size;
}

/// Compares both forms of a law. The `tolerance` is in units of the precision's last digit.
template <class Real>
void Compare(const TwoForms& forms, const std::string& name, uint64_t rows, double tolerance) {
  const vesper_scalar_type real = sizeof(Real) == 4 ? VESPER_F32 : VESPER_F64;
  const vesper_law_desc& text = LawOf(*forms.text, name, real);
  const vesper_law_desc& compiled = LawOf(*forms.compiled, name, real);
  ASSERT_EQ(Declaration(compiled), Declaration(text));
  const Run<Real> expected(*forms.text, text, rows);
  const Run<Real> found(*forms.compiled, compiled, rows);
  const double allowed = tolerance * double{std::numeric_limits<Real>::epsilon()};
  bool changes = false;
  for (size_t u = 0; u < expected.columns.size(); ++u) {
    EXPECT_LE(Difference(found.columns[u], expected.columns[u]), allowed)
        << name << "." << expected.names[u] << ", f" << 8 * sizeof(Real) << ", " << rows << " rows";
    const bool written = text.uses[u].access != VESPER_READ;
    changes = changes || (written && std::ranges::any_of(expected.columns[u],
                                                         [](Real value) { return value != 0; }));
  }
  for (size_t u = 0; u < expected.wide.size(); ++u) {
    EXPECT_EQ(found.wide[u], expected.wide[u]) << name << "." << expected.names[u];
  }
  EXPECT_TRUE(changes || rows < 300 || text.use_count == 0) << name;
  EXPECT_EQ(found.fields, expected.fields) << name;
  EXPECT_LE(Difference(found.energies, expected.energies), allowed) << name << ", energy";
}

/// The laws with elementary functions.
const std::set<std::string> kWithFunctions = {"functions", "turn", "angular_motion",
                                              "predator_prey", "tides"};

void CompareAll(const TwoForms& forms, double tolerance_of_functions) {
  ASSERT_NE(forms.text, nullptr);
  ASSERT_NE(forms.compiled, nullptr);
  ASSERT_EQ(forms.compiled->law_count, forms.text->law_count);
  EXPECT_STREQ(forms.compiled->name, forms.text->name);
  for (uint32_t i = 0; i < forms.text->law_count; i += 2) {
    const std::string name = forms.text->laws[i].name;
    const bool functions = kWithFunctions.contains(name);
    // Each of three rows has at most two pairs and two springs, so their order does not change the
    // sums.
    for (const uint64_t rows : {1, 3, 300}) {
      const double tolerance = functions ? tolerance_of_functions : rows == 300 ? 300 : 0;
      Compare<double>(forms, name, rows, tolerance);
      Compare<float>(forms, name, rows, tolerance);
    }
  }
}

TEST(CppTest, ShippedTextsGiveTheirNumbersAsCpp) {
  const TwoForms forms("shipped");
  EXPECT_GE(forms.text->law_count, 2 * 10u);
  CompareAll(forms, 64);
}

TEST(CppTest, TextsOfTheGalleryGiveTheirNumbersAsCpp) { CompareAll(TwoForms("gallery"), 64); }

TEST(CppTest, FormulasGiveTheirNumbersAsCpp) { CompareAll(TwoForms("formulas"), 16); }

TEST(CppTest, FieldsGiveTheirNumbersAsCpp) {
  const TwoForms forms("fields");
  CompareAll(forms, 0);
  ASSERT_EQ(forms.text->field_count, 1u);
  EXPECT_EQ(DeclarationsOfFields(*forms.compiled), DeclarationsOfFields(*forms.text));
  const test::Run<double> gusts(*forms.text, LawOf(*forms.text, "gusts", VESPER_F64), 1);
  ASSERT_EQ(gusts.fields.size(), 4 * 50 * 3u);
  EXPECT_NE(gusts.fields[3], gusts.fields[3 + 150]) << "the field depends on the time";
}

TEST(CppTest, PropertiesOf64BitsKeepTheirBitsInBothPrecisions) {
  for (const char* prototype : {"si-f64", "si-f32"}) {
    const TwoForms forms("precisions", prototype);
    for (const char* law : {"swell", "flat", "press", "well"}) {
      for (const uint64_t rows : {1, 3}) {
        if (prototype == std::string("si-f64")) {
          Compare<double>(forms, law, rows, 0);
        } else {
          Compare<float>(forms, law, rows, 0);
        }
      }
    }
    const vesper_law_desc& swell = LawOf(*forms.compiled, "swell", VESPER_F32);
    const auto uses = std::span(swell.uses, swell.use_count);
    EXPECT_TRUE(std::ranges::any_of(uses, [](const vesper_property_use& use) {
      return use.name == std::string("size") && use.scalar_type == VESPER_F64;
    }));
  }
}

TEST(CppTest, PositionThatIsNotFiniteFailsBothForms) {
  const TwoForms forms("formulas");
  for (const std::string law : {"flock", "waves"}) {
    for (const vesper_law_library* table : {forms.text, forms.compiled}) {
      const test::Run<double> run(*table, LawOf(*table, law, VESPER_F64), 3, true);
      EXPECT_NE(run.failure.find("the position of row 1"), std::string::npos)
          << law << ": " << run.failure;
      EXPECT_NE(run.failure.find("is not finite, so it has no distance to other rows"),
                std::string::npos)
          << run.failure;
    }
  }
}

}  // namespace
}  // namespace vesper::test
