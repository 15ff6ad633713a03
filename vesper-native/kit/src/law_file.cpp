// SPDX-License-Identifier: Apache-2.0
#include "vesper/kit/law_file.hpp"

#include <dlfcn.h>
#include <elf.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>

#include "python_laws.hpp"
#include "vesper/kit/test_prototype.hpp"

namespace vesper {
namespace {

constexpr const char* kTextEnding = ".law";
constexpr const char* kPythonEnding = ".py";

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void RequireOk(vesper_status status, const vesper_error& error) {
  if (status != VESPER_OK) throw std::runtime_error(error.message);
}

const vesper_law_library& TableOf(vesper_prepared_library* prepared,
                                  const vesper_prototype& prototype) {
  const vesper_law_library* table = nullptr;
  vesper_error error{};
  RequireOk(vesper_library_table(prepared, &prototype, &table, &error), error);
  return *table;
}

/// Returns the sections of one type of a 64-bit ELF file.
std::vector<Elf64_Shdr> Sections(const std::string& elf, uint32_t type) {
  Elf64_Ehdr header;
  std::memcpy(&header, elf.data(), sizeof header);
  std::vector<Elf64_Shdr> found;
  for (size_t i = 0; i < header.e_shnum; ++i) {
    Elf64_Shdr section;
    std::memcpy(&section, elf.data() + header.e_shoff + i * sizeof section, sizeof section);
    if (section.sh_type == type) found.push_back(section);
  }
  return found;
}

template <class Entry>
std::vector<Entry> Entries(const std::string& elf, const Elf64_Shdr& section) {
  std::vector<Entry> entries(section.sh_size / sizeof(Entry));
  std::memcpy(entries.data(), elf.data() + section.sh_offset, entries.size() * sizeof(Entry));
  return entries;
}

/// Returns a text from the string table of a section.
const char* Text(const std::string& elf, const Elf64_Shdr& section, uint64_t offset) {
  Elf64_Ehdr header;
  std::memcpy(&header, elf.data(), sizeof header);
  Elf64_Shdr strings;
  std::memcpy(&strings, elf.data() + header.e_shoff + section.sh_link * sizeof strings,
              sizeof strings);
  return elf.data() + strings.sh_offset + offset;
}

}  // namespace

void LawFile::Close::operator()(void* handle) const { dlclose(handle); }

bool LawFile::IsPython(const std::string& path) { return path.ends_with(kPythonEnding); }

LawFile::Prepared LawFile::PrepareFile(const vesper_prototype& prototype, const std::string& path) {
  vesper_error error{};
  vesper_prepared_library* prepared = nullptr;
  if (IsPython(path)) {
    const std::string text = ReadFile(path);
    const std::string source = std::filesystem::path(path).filename();
    RequireOk(python::PreparePython(prototype, source, text.data(), text.size(), &prepared, &error),
              error);
    return Prepared(prepared);
  }
  vesper_engine_config config;
  vesper_engine_config_init(&config);
  const std::string place = path.find('/') == std::string::npos ? "./" + path : path;
  RequireOk(vesper_library_prepare(&config, place.c_str(), &prepared, &error), error);
  return Prepared(prepared);
}

PreparedLibrary LawFile::Prepare(const vesper_prototype& prototype, const std::string& path) {
  return PreparedLibrary(PrepareFile(prototype, path).release());
}

LawFile::LawFile(const std::string& path) : path_(path) {
  if (path.ends_with(kTextEnding) || IsPython(path)) {
    const vesper_prototype& f64 = TestPrototype(VESPER_F64);
    prepared_ = PrepareFile(f64, path);
    table_ = &TableOf(prepared_.get(), f64);
    if (!IsPython(path)) return;  // the table of a text has both precisions
    const vesper_prototype& f32 = TestPrototype(VESPER_F32);
    f32_prepared_ = PrepareFile(f32, path);
    f32_table_ = &TableOf(f32_prepared_.get(), f32);
    return;
  }
  handle_.reset(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL));
  if (!handle_) throw std::runtime_error(dlerror());
  void* entry = dlsym(handle_.get(), VESPER_LAW_LIBRARY_ENTRY);
  if (entry == nullptr) throw std::runtime_error(dlerror());
  table_ = reinterpret_cast<decltype(&vesper_law_library_entry)>(entry)();
  if (table_ == nullptr) throw std::runtime_error(path + ": the entry returned null");
  if (table_->abi_version != VESPER_ABI_VERSION) {
    throw std::runtime_error(path + ": built for another version of the contract than " +
                             std::to_string(VESPER_ABI_MAJOR) + "." +
                             std::to_string(VESPER_ABI_MINOR) + "; rebuild it to test it");
  }
}

std::string LawFile::NameOf(const std::string& path) {
  const std::string stem = std::filesystem::path(path).stem();
  const std::string prefix = "libvesper_law_";
  if (path.ends_with(kTextEnding) || IsPython(path)) return stem;
  return stem.starts_with(prefix) ? stem.substr(prefix.size()) : "";
}

std::string LawFile::FileNameFor(const std::string& path, const std::string& name) {
  if (path.ends_with(kTextEnding)) return name + kTextEnding;
  return IsPython(path) ? name + kPythonEnding : "libvesper_law_" + name + ".so";
}

std::vector<const vesper_law_desc*> LawFile::Laws(vesper_scalar_type real_type) const {
  std::vector<const vesper_law_desc*> laws;
  const vesper_law_library& of = table(real_type);
  for (const vesper_law_desc& law : std::span(of.laws, of.law_count)) {
    if (law.real_type == real_type || law.real_type == 0) laws.push_back(&law);
  }
  return laws;
}

std::span<const vesper_field_desc> LawFile::Fields() const {
  return {table_->fields, table_->field_count};
}

std::vector<LawFile::Symbol> LawFile::DynamicSymbols() const {
  const std::string elf = ReadFile(path_);
  std::vector<Symbol> symbols;
  for (const Elf64_Shdr& section : Sections(elf, SHT_DYNSYM)) {
    for (const Elf64_Sym& symbol : Entries<Elf64_Sym>(elf, section)) {
      if (symbol.st_name == 0) continue;
      symbols.push_back({Text(elf, section, symbol.st_name), symbol.st_shndx != SHN_UNDEF,
                         ELF64_ST_BIND(symbol.st_info) == STB_WEAK});
    }
  }
  return symbols;
}

std::vector<std::string> LawFile::Exports() const {
  std::vector<std::string> names;
  for (const Symbol& symbol : DynamicSymbols()) {
    if (symbol.defined) names.push_back(symbol.name);
  }
  return names;
}

std::vector<std::string> LawFile::Needed() const {
  const std::string elf = ReadFile(path_);
  std::vector<std::string> names;
  for (const Elf64_Shdr& section : Sections(elf, SHT_DYNAMIC)) {
    for (const Elf64_Dyn& entry : Entries<Elf64_Dyn>(elf, section)) {
      if (entry.d_tag == DT_NEEDED) names.push_back(Text(elf, section, entry.d_un.d_val));
    }
  }
  return names;
}

std::vector<std::string> LawFile::Imports() const {
  std::vector<std::string> imports;
  for (const Symbol& symbol : DynamicSymbols()) {
    if (symbol.defined) continue;
    Dl_info info{};
    // The handle of this library is searched first, because the program may contain copies of the
    // library's data.
    void* address = dlsym(handle_.get(), symbol.name.c_str());
    if (address == nullptr) address = dlsym(RTLD_DEFAULT, symbol.name.c_str());
    if (address == nullptr && symbol.weak) continue;
    const bool known = address != nullptr && dladdr(address, &info) != 0;
    const std::string provider =
        known ? std::filesystem::path(info.dli_fname).filename().string() : "no library";
    imports.push_back(symbol.name + " (" + provider + ")");
  }
  return imports;
}

namespace {

/// A host with one thread that discards log lines.
const vesper_host kHost = {
    sizeof(vesper_host),
    0,
    nullptr,
    [](void*, uint32_t, const char*) {},
    [](void*, uint64_t count, uint64_t grain, void (*body)(void*, uint64_t, uint64_t), void* user) {
      if (grain == 0) grain = count;
      for (uint64_t begin = 0; begin < count; begin += grain) {
        body(user, begin, std::min(begin + grain, count));
      }
    },
    nullptr};

vesper_host HostFor(const vesper_law_library* library) {
  vesper_host host = kHost;
  host.user = library == nullptr ? nullptr : library->user;
  return host;
}

vesper_suite* Open(const vesper_law_library* library, const vesper_host& host) {
  if (library == nullptr || library->open == nullptr) return nullptr;
  vesper_suite* suite = nullptr;
  vesper_error error{};
  RequireOk(library->open(&host, &suite, &error), error);
  return suite;
}

bool Defers(const vesper_property_use& use) { return (use.flags & VESPER_USE_DEFERRED) != 0; }

vesper_law* Create(const vesper_law_desc& desc, const vesper_host& host, vesper_suite* suite) {
  std::vector<double> parameters;
  for (const auto& parameter : std::span(desc.parameters, desc.parameter_count)) {
    parameters.push_back(parameter.default_value);
  }
  vesper_law* law = nullptr;
  vesper_error error{};
  RequireOk(desc.create(&host, suite, parameters.data(), &law, &error), error);
  return law;
}

}  // namespace

BareLaw::BareLaw(const vesper_law_desc& desc, const std::vector<vesper_property>& properties,
                 const vesper_law_library* library)
    : desc_(desc),
      host_(HostFor(library)),
      properties_(properties),
      suite_(Open(library, host_), Close{library}),
      law_(Create(desc, host_, suite_.get()), Destroy{&desc}) {
  Bind();
}

/// Binds a law with deferred uses again, so that it reads the arrays.
void BareLaw::TakeArrays() const {
  if (std::ranges::any_of(std::span(desc_.uses, desc_.use_count), Defers)) Bind();
}

void BareLaw::Bind() const {
  for (vesper_property& property : properties_) ++property.version;
  vesper_error error{};
  RequireOk(desc_.bind(law_.get(), properties_.data(), &error), error);
}

void BareLaw::Step(const Time& time, const std::function<void(uint32_t)>& evaluate) const {
  const double start = static_cast<double>(time.index) * time.dt;
  vesper_step step{sizeof step, 0, std::max(desc_.stages, 1u), 0, time.dt, start, time.index};
  if (desc_.phase == VESPER_PHASE_INTEGRATE && desc_.first_stage == 0) Advance(step);
  for (step.stage = 1; step.stage <= step.stage_count; ++step.stage) {
    evaluate(step.stage);
    Advance(step);
  }
}

void BareLaw::Advance(const vesper_step& step) const {
  TakeArrays();
  vesper_error error{};
  RequireOk(desc_.advance(law_.get(), &step, &error), error);
  for (uint32_t i = 0; i < desc_.use_count; ++i) {
    if (!Defers(desc_.uses[i]) || desc_.uses[i].access == VESPER_READ) continue;
    RequireOk(desc_.synchronize(law_.get(), i, &error), error);
  }
}

double BareLaw::PotentialEnergy() const {
  TakeArrays();
  double energy = 0;
  vesper_error error{};
  RequireOk(desc_.potential_energy(law_.get(), &energy, &error), error);
  return energy;
}

}  // namespace vesper
