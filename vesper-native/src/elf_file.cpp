// SPDX-License-Identifier: Apache-2.0
#include "elf_file.hpp"

#include <elf.h>

#include <algorithm>
#include <bit>
#include <cinttypes>
#include <cstdint>
#include <cstring>

#include "failure.hpp"

namespace vesper {
namespace {

#if defined(__x86_64__)
constexpr uint16_t kMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr uint16_t kMachine = EM_AARCH64;
#else
#error "Vesper loads law libraries on x86-64 and AArch64 only"
#endif
constexpr unsigned char kByteOrder =
    std::endian::native == std::endian::little ? ELFDATA2LSB : ELFDATA2MSB;

class Reader {
 public:
  Reader(std::span<const std::byte> file, const std::string& source)
      : file_(file), source_(source) {}

  void Require(bool condition, const char* what) const {
    if (!condition) {
      throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: %s", source_.c_str(), what);
    }
  }

  /// Returns `offset + size` of a part that a header describes. Refuses an overflow of the sum.
  uint64_t End(uint64_t offset, uint64_t size) const {
    uint64_t end = 0;
    Require(!__builtin_add_overflow(offset, size, &end),
            "an ELF header holds an impossible offset");
    return end;
  }

  void RequireSize(uint64_t needed) const {
    if (needed <= file_.size()) return;
    throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: truncated: needs %" PRIu64 " bytes, has %zu",
                  source_.c_str(), needed, file_.size());
  }

  template <class T>
  T At(uint64_t offset) const {
    RequireSize(End(offset, sizeof(T)));
    T value;
    std::memcpy(&value, file_.data() + offset, sizeof value);
    return value;
  }

 private:
  std::span<const std::byte> file_;
  const std::string& source_;
};

Elf64_Ehdr ReadHeader(const Reader& reader, std::span<const std::byte> file) {
  const size_t magic = std::min<size_t>(file.size(), SELFMAG);
  reader.Require(magic > 0 && std::memcmp(file.data(), ELFMAG, magic) == 0,
                 file.empty() ? "the file is empty" : "not an ELF file");
  const auto header = reader.At<Elf64_Ehdr>(0);
  reader.Require(header.e_ident[EI_CLASS] == ELFCLASS64, "not a 64-bit ELF file");
  reader.Require(header.e_ident[EI_DATA] == kByteOrder, "ELF file of another byte order");
  reader.Require(header.e_ident[EI_VERSION] == EV_CURRENT && header.e_version == EV_CURRENT,
                 "ELF file of an unknown version");
  reader.Require(header.e_machine == kMachine, "ELF file for another processor");
  reader.Require(header.e_type == ET_DYN, "ELF file, but not a shared object");
  return header;
}

void CheckTables(const Reader& reader, const Elf64_Ehdr& header) {
  reader.Require(header.e_phentsize == sizeof(Elf64_Phdr) && header.e_phnum > 0,
                 "ELF file without program headers");
  const uint64_t segments = reader.End(header.e_phoff, header.e_phnum * sizeof(Elf64_Phdr));
  const uint64_t sections = reader.End(header.e_shoff, header.e_shnum * sizeof(Elf64_Shdr));
  reader.RequireSize(std::max(segments, sections));
}

void CheckSegments(const Reader& reader, const Elf64_Ehdr& header) {
  bool loadable = false;
  bool dynamic = false;
  for (uint32_t i = 0; i < header.e_phnum; ++i) {
    const auto segment = reader.At<Elf64_Phdr>(header.e_phoff + i * sizeof(Elf64_Phdr));
    reader.RequireSize(reader.End(segment.p_offset, segment.p_filesz));
    reader.Require(segment.p_type != PT_LOAD || segment.p_filesz <= segment.p_memsz,
                   "an ELF segment is larger in the file than in memory");
    loadable |= segment.p_type == PT_LOAD;
    dynamic |= segment.p_type == PT_DYNAMIC;
  }
  reader.Require(loadable && dynamic, "ELF file without a loadable or dynamic segment");
}

}  // namespace

void CheckSharedObject(std::span<const std::byte> file, const std::string& source) {
  const Reader reader(file, source);
  const Elf64_Ehdr header = ReadHeader(reader, file);
  CheckTables(reader, header);
  CheckSegments(reader, header);
}

}  // namespace vesper
