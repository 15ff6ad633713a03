// SPDX-License-Identifier: Apache-2.0
// The laws of a file in Python as the table of a law library.
#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "interpreter.hpp"
#include "python_front_end.hpp"
#include "vesper/law.h"

namespace vesper::python {
namespace {

constexpr size_t kMaxLaws = 16;  // maximum number of laws in one file

vesper_unit UnitOf(PyObject* bytes) {
  vesper_unit unit{};
  if (!PyBytes_Check(bytes) || PyBytes_GET_SIZE(bytes) != sizeof unit) {
    throw Failure(VESPER_INTERNAL, "a unit of a law in Python has a wrong form");
  }
  std::memcpy(&unit, PyBytes_AS_STRING(bytes), sizeof unit);
  return unit;
}

/// A law of the file: its declarations, and the Python object that creates its instances.
struct Declared {
  std::string name, version, doc;
  vesper_law_desc desc{};
  std::vector<std::string> texts;  // strings to which uses and parameters point
  std::vector<vesper_property_use> uses;
  std::vector<vesper_parameter_desc> parameters;
  PyObject* law = nullptr;  // a Python object of class vesper._Law
};

/// The laws of one file. The engine frees this object after the laws.
class Library {
 public:
  Library(const vesper_prototype& prototype, std::string source, const char* text, uint64_t size);
  ~Library() {
    const Turn turn;
    for (Declared& law : laws_) Py_XDECREF(law.law);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  const vesper_law_library& table() const { return table_; }
  const std::string& source() const { return source_; }
  /// Returns the versions of Python, NumPy and other packages on which the bits of the laws
  /// depend.
  const std::string& versions() const { return versions_; }
  const Declared& law(size_t index) const { return laws_[index]; }

 private:
  void Read(PyObject* law, Declared& to, vesper_scalar_type real_type);

  std::string source_;
  std::string versions_;
  std::vector<Declared> laws_;
  std::vector<vesper_law_desc> descs_;
  vesper_law_library table_{};
};

/// A law in an engine: the `vesper_law` between `create` and `destroy`.
class Instance {
 public:
  Instance(const Library& library, const Declared& law, const double* parameters)
      : source_(library.source()) {
    const Turn turn;
    const Object values(PyTuple_New(static_cast<Py_ssize_t>(law.parameters.size())));
    for (size_t i = 0; i < law.parameters.size(); ++i) {
      PyTuple_SET_ITEM(values.get(), static_cast<Py_ssize_t>(i), PyFloat_FromDouble(parameters[i]));
    }
    Object instance = Checked(PyObject_CallMethod(law.law, "create", "(O)", values.get()),
                              VESPER_LAW_FAILED, source_);
    advance_ =
        Checked(PyObject_GetAttrString(instance.get(), "advance"), VESPER_LAW_FAILED, source_);
    instance_ = std::move(instance);
    columns_ = law.uses.size();
  }
  ~Instance() {
    const Turn turn;
    advance_ = Object();
    instance_ = Object();
  }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  /// Makes a NumPy array on the memory of each column, and a function of each field. The array of a
  /// column that the law only reads refuses writes.
  void Bind(const vesper_property* properties) {
    const Turn turn;
    const Object columns(PyList_New(0));
    for (size_t i = 0; i < columns_; ++i) {
      const vesper_property& property = properties[i];
      if (property.scalar_type == VESPER_FIELD) {
        Append(columns.get(), FieldOf(property), property);
        continue;
      }
      const auto size = static_cast<Py_ssize_t>(property.row_count * property.components *
                                                (property.scalar_type == VESPER_F64 ? 8 : 4));
      static char none[8];
      const Object memory = Checked(
          PyMemoryView_FromMemory(size == 0 ? none : static_cast<char*>(property.data), size,
                                  property.access == VESPER_READ ? PyBUF_READ : PyBUF_WRITE),
          VESPER_LAW_FAILED, source_);
      Append(columns.get(), memory, property);
    }
    Checked(PyObject_CallMethod(instance_.get(), "bind", "(O)", columns.get()), VESPER_LAW_FAILED,
            source_);
  }

  double PotentialEnergy() {
    const Turn turn;
    const Object energy = Checked(PyObject_CallMethod(instance_.get(), "potential_energy", nullptr),
                                  VESPER_LAW_FAILED, source_);
    return PyFloat_AsDouble(energy.get());
  }

  void Advance(const vesper_step& step) {
    const Turn turn;
    Checked(PyObject_CallFunction(advance_.get(), "ddI", step.dt, step.time, step.stage),
            VESPER_LAW_FAILED, source_);
  }

 private:
  Object FieldOf(const vesper_property& property) const {
    Object field =
        Checked(PyCapsule_New(property.data, kFieldCapsule, nullptr), VESPER_LAW_FAILED, source_);
    const intptr_t components = property.components;
    if (PyCapsule_SetContext(field.get(), reinterpret_cast<void*>(components)) != 0) {
      throw Raised(VESPER_LAW_FAILED, source_);
    }
    return field;
  }

  /// Appends (data, rows, components) to a list.
  void Append(PyObject* columns, const Object& data, const vesper_property& property) const {
    const Object column = Checked(
        Py_BuildValue("(OKI)", data.get(), static_cast<unsigned long long>(property.row_count),
                      property.components),
        VESPER_LAW_FAILED, source_);
    if (PyList_Append(columns, column.get()) != 0) throw Raised(VESPER_LAW_FAILED, source_);
  }

  const std::string& source_;
  Object instance_;
  Object advance_;
  size_t columns_ = 0;
};

template <size_t index>
vesper_status Create(const vesper_host* host, vesper_suite*, const double* parameters,
                     vesper_law** out, vesper_error* error) {
  return Guarded(error, [&] {
    const auto& library = *static_cast<const Library*>(host->user);
    *out = reinterpret_cast<vesper_law*>(new Instance(library, library.law(index), parameters));
    if (index == 0) host->log(host->context, VESPER_LOG_INFO, library.versions().c_str());
  });
}

template <size_t... indices>
constexpr auto CreateFunctions(std::index_sequence<indices...>) {
  return std::array<decltype(vesper_law_desc::create), sizeof...(indices)>{Create<indices>...};
}

Instance& InstanceOf(vesper_law* law) { return *reinterpret_cast<Instance*>(law); }

vesper_status Bind(vesper_law* law, const vesper_property* properties, vesper_error* error) {
  return Guarded(error, [&] { InstanceOf(law).Bind(properties); });
}

vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  return Guarded(error, [&] { InstanceOf(law).Advance(*step); });
}

vesper_status PotentialEnergy(vesper_law* law, double* out, vesper_error* error) {
  return Guarded(error, [&] { *out = InstanceOf(law).PotentialEnergy(); });
}

void Destroy(vesper_law* law) { delete &InstanceOf(law); }

/// Returns the prototype as a list of (name, kind, scalar type, components, access, unit).
Object Properties(const vesper_prototype& prototype) {
  Object list(PyList_New(0));
  const auto* at = reinterpret_cast<const std::byte*>(prototype.properties);
  for (uint32_t i = 0; i < prototype.property_count; ++i) {
    vesper_property_descriptor property{};
    const uint32_t size = prototype.properties->struct_size;
    std::memcpy(&property, at + size_t{i} * size, std::min<size_t>(sizeof property, size));
    const Object entry(Py_BuildValue("(ssIIIy#)", property.name, property.kind,
                                     property.scalar_type, property.components, property.law_access,
                                     reinterpret_cast<const char*>(&property.unit),
                                     Py_ssize_t{sizeof property.unit}));
    if (!entry || PyList_Append(list.get(), entry.get()) != 0) {
      throw Raised(VESPER_INTERNAL, "prototype");
    }
  }
  return list;
}

void Library::Read(PyObject* law, Declared& to, vesper_scalar_type real_type) {
  const char *name, *version, *doc;
  PyObject *uses, *parameters;
  int has_energy;
  vesper_law_desc& desc = to.desc;
  if (!PyArg_ParseTuple(law, "sssIIIIO!O!Op", &name, &version, &doc, &desc.phase, &desc.claims,
                        &desc.stages, &desc.first_stage, &PyList_Type, &uses, &PyList_Type,
                        &parameters, &to.law, &has_energy)) {
    throw Raised(VESPER_INTERNAL, source_);
  }
  Py_INCREF(to.law);
  to.name = name;
  to.version = version;
  to.doc = doc;
  to.texts.reserve(
      static_cast<size_t>(2 * PyList_GET_SIZE(uses) + 2 * PyList_GET_SIZE(parameters)));
  const auto keep = [&to](const char* text) { return to.texts.emplace_back(text).c_str(); };
  for (Py_ssize_t i = 0; i < PyList_GET_SIZE(uses); ++i) {
    vesper_property_use use{};
    const char* kind;
    PyObject* unit;
    if (!PyArg_ParseTuple(PyList_GET_ITEM(uses, i), "ssIIIO", &name, &kind, &use.scalar_type,
                          &use.components, &use.access, &unit)) {
      throw Raised(VESPER_INTERNAL, source_);
    }
    use.struct_size = sizeof use;
    use.name = keep(name);
    use.kind = keep(kind);
    use.unit = UnitOf(unit);
    to.uses.push_back(use);
  }
  for (Py_ssize_t i = 0; i < PyList_GET_SIZE(parameters); ++i) {
    vesper_parameter_desc parameter{};
    PyObject* unit;
    if (!PyArg_ParseTuple(PyList_GET_ITEM(parameters, i), "ssOddd", &name, &doc, &unit,
                          &parameter.default_value, &parameter.minimum, &parameter.maximum)) {
      throw Raised(VESPER_INTERNAL, source_);
    }
    parameter.struct_size = sizeof parameter;
    parameter.name = keep(name);
    parameter.doc = keep(doc);
    parameter.unit = UnitOf(unit);
    to.parameters.push_back(parameter);
  }
  desc.struct_size = sizeof desc;
  desc.real_type = real_type;
  desc.name = to.name.c_str();
  desc.version = to.version.c_str();
  desc.doc = to.doc.c_str();
  desc.use_count = static_cast<uint32_t>(to.uses.size());
  desc.uses = to.uses.data();
  desc.parameter_count = static_cast<uint32_t>(to.parameters.size());
  desc.parameters = to.parameters.data();
  desc.bind = python::Bind;
  desc.advance = python::Advance;
  desc.destroy = python::Destroy;
  if (has_energy != 0) desc.potential_energy = python::PotentialEnergy;
}

Library::Library(const vesper_prototype& prototype, std::string source, const char* text,
                 uint64_t size)
    : source_(std::move(source)) {
  static constexpr auto kCreate = CreateFunctions(std::make_index_sequence<kMaxLaws>());
  const Turn turn;
  const Object properties = Properties(prototype);
  const Object open = Checked(Function("_open").release(), VESPER_INTERNAL, source_);
  const Object opened =
      Checked(PyObject_CallFunction(open.get(), "sy#IOI", source_.c_str(), text,
                                    static_cast<Py_ssize_t>(size), prototype.real_type,
                                    properties.get(), static_cast<unsigned>(kMaxLaws)),
              VESPER_LIBRARY_LOAD_FAILED, source_);
  PyObject* laws;
  const char* versions;
  if (!PyArg_ParseTuple(opened.get(), "O!s", &PyList_Type, &laws, &versions)) {
    throw Raised(VESPER_INTERNAL, source_);
  }
  versions_ = versions;
  laws_.resize(static_cast<size_t>(PyList_GET_SIZE(laws)));
  for (size_t i = 0; i < laws_.size(); ++i) {
    Read(PyList_GET_ITEM(laws, static_cast<Py_ssize_t>(i)), laws_[i], prototype.real_type);
    laws_[i].desc.create = kCreate[i];
    descs_.push_back(laws_[i].desc);
  }
  table_.struct_size = sizeof table_;
  table_.abi_version = VESPER_ABI_VERSION;
  table_.name = laws_.front().name.c_str();
  table_.law_count = static_cast<uint32_t>(descs_.size());
  table_.laws = descs_.data();
  table_.user = this;
}

}  // namespace
}  // namespace vesper::python

vesper_status vesper_python_prepare(const vesper_prototype* prototype, const char* source,
                                    const char* text, uint64_t size, char* versions,
                                    uint64_t versions_size, vesper_prepared_library** out,
                                    vesper_error* error) {
  using vesper::python::Library;
  return vesper::Guarded(error, [&] {
    vesper::python::Start();
    auto library = std::make_unique<Library>(*prototype, source, text, size);
    const auto release = [](void* user) { delete static_cast<Library*>(user); };
    vesper_error refused = vesper::BlankError();
    if (vesper_library_prepare_table(&library->table(), release, library.get(), out, &refused) !=
        VESPER_OK) {
      throw vesper::Failure(refused).Within(source);
    }
    if (versions_size > 0) {
      versions[library->versions().copy(versions, versions_size - 1)] = '\0';
    }
    library.release();
  });
}
