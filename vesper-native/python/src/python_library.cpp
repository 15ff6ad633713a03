// SPDX-License-Identifier: Apache-2.0
// The laws of a file in Python as the table of a law library.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <limits>
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
  bool is_field = false;
  vesper_unit field_unit{};
  uint32_t field_components = 0;
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
  size_t size() const { return laws_.size(); }
  /// Returns the index of the law of a field, counted among the fields.
  size_t law_of_field(size_t field) const { return law_of_field_[field]; }

 private:
  void FillFields();

  void Read(PyObject* law, Declared& to, vesper_scalar_type real_type);

  std::string source_;
  std::string versions_;
  std::vector<Declared> laws_;
  std::vector<vesper_law_desc> descs_;
  std::vector<size_t> law_of_field_;
  std::vector<vesper_field_desc> fields_;
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

  PyObject* object() const { return instance_.get(); }

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

/// The fields of a file in one engine. Their functions run while the interpreter's lock is held, so
/// calls of several threads take turns.
class Fields {
 public:
  explicit Fields(const Library& library) : library_(library), providers_(library.size()) {}
  ~Fields() {
    const Turn turn;
    providers_.clear();
  }
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;

  /// Sets the Python object that evaluates the field of a law.
  void Set(size_t law, PyObject* provider) {
    const Turn turn;
    Py_INCREF(provider);
    providers_[law] = Object(provider);
  }
  void BeginStep(double time) { time_ = time; }

  /// Writes the values of a field [its unit] at positions (count x 3) [m] to `out`. Throws the
  /// exception of its function.
  void Evaluate(size_t field, uint64_t count, const double* at, double* out) const {
    const Turn turn;
    const size_t law = library_.law_of_field(field);
    const auto rows = static_cast<Py_ssize_t>(count * sizeof(double));
    const Object positions =
        Checked(PyMemoryView_FromMemory(reinterpret_cast<char*>(const_cast<double*>(at)), 3 * rows,
                                        PyBUF_READ),
                VESPER_LAW_FAILED, library_.source());
    const Object values = Checked(
        PyMemoryView_FromMemory(reinterpret_cast<char*>(out),
                                static_cast<Py_ssize_t>(Components(field)) * rows, PyBUF_WRITE),
        VESPER_LAW_FAILED, library_.source());
    Checked(PyObject_CallMethod(providers_[law].get(), "evaluate", "OOd", positions.get(),
                                values.get(), time_),
            VESPER_LAW_FAILED, library_.source());
  }

  /// Like Evaluate; the values are not finite if the function raises an exception.
  void EvaluateQuietly(size_t field, uint64_t count, const double* at, double* out) const noexcept {
    vesper_error ignored = BlankError();
    if (Guarded(&ignored, [&] { Evaluate(field, count, at, out); }) != VESPER_OK) {
      std::fill_n(out, count * Components(field), std::numeric_limits<double>::quiet_NaN());
    }
  }

  /// Describes why a field has no finite value at a position.
  void Explain(size_t field, const double* at, vesper_error& error) const {
    std::vector<double> value(Components(field));
    const Declared& law = library_.law(library_.law_of_field(field));
    char place[100];
    std::snprintf(place, sizeof place, " at (%g, %g, %g) m", at[0], at[1], at[2]);
    std::string what;
    vesper_error raised = BlankError();
    if (Guarded(&raised, [&] { Evaluate(field, 1, at, value.data()); }) == VESPER_OK) {
      what = library_.source() + ": field " + law.name + " has no finite value";
    } else {
      what = raised.message;
    }
    std::snprintf(error.message, sizeof error.message, "%s%s", what.c_str(), place);
    error.law_index = static_cast<uint32_t>(library_.law_of_field(field));
  }

 private:
  uint32_t Components(size_t field) const {
    return library_.law(library_.law_of_field(field)).field_components;
  }

  const Library& library_;
  std::vector<Object> providers_;  // by law; empty for a law that is no field
  double time_ = 0;                // at the start of the step [s]
};

const Fields& FieldsOf(void* suite) { return *static_cast<const Fields*>(suite); }

vesper_status OpenFields(const vesper_host* host, vesper_suite** out, vesper_error* error) {
  return Guarded(error, [&] {
    *out = reinterpret_cast<vesper_suite*>(new Fields(*static_cast<const Library*>(host->user)));
  });
}

void CloseFields(vesper_suite* suite) { delete reinterpret_cast<Fields*>(suite); }

void BeginStep(void* suite, const vesper_step* step) {
  static_cast<Fields*>(suite)->BeginStep(step->time);
}

template <size_t field>
void EvaluateField(void* suite, uint64_t count, const double* at, double* out) {
  FieldsOf(suite).EvaluateQuietly(field, count, at, out);
}

template <size_t field>
void ExplainField(void* suite, const double* at, vesper_error* error) {
  vesper_error ignored = BlankError();
  Guarded(&ignored, [&] { FieldsOf(suite).Explain(field, at, *error); });
}

/// The functions of a field of a file, of which each has a number.
struct FieldFunctions {
  decltype(vesper_field_desc::evaluate) evaluate;
  decltype(vesper_field_desc::explain) explain;
};
template <size_t... fields>
constexpr auto FunctionsOfFields(std::index_sequence<fields...>) {
  return std::array<FieldFunctions, sizeof...(fields)>{
      FieldFunctions{EvaluateField<fields>, ExplainField<fields>}...};
}

template <size_t index>
vesper_status Create(const vesper_host* host, vesper_suite* suite, const double* parameters,
                     vesper_law** out, vesper_error* error) {
  return Guarded(error, [&] {
    const auto& library = *static_cast<const Library*>(host->user);
    auto instance = std::make_unique<Instance>(library, library.law(index), parameters);
    if (library.law(index).is_field) {
      reinterpret_cast<Fields*>(suite)->Set(index, instance->object());
    }
    *out = reinterpret_cast<vesper_law*>(instance.release());
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
  PyObject *uses, *parameters, *field;
  int has_energy;
  vesper_law_desc& desc = to.desc;
  if (!PyArg_ParseTuple(law, "sssIIIIO!O!OpO", &name, &version, &doc, &desc.phase, &desc.claims,
                        &desc.stages, &desc.first_stage, &PyList_Type, &uses, &PyList_Type,
                        &parameters, &to.law, &has_energy, &field)) {
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
  to.is_field = field != Py_None;
  if (!to.is_field) return;
  PyObject* unit;
  if (!PyArg_ParseTuple(field, "OI", &unit, &to.field_components)) {
    throw Raised(VESPER_INTERNAL, source_);
  }
  to.field_unit = UnitOf(unit);
}

/// Describes the fields that the file provides.
void Library::FillFields() {
  static constexpr auto kFunctions = FunctionsOfFields(std::make_index_sequence<kMaxLaws>());
  for (size_t law = 0; law < laws_.size(); ++law) {
    const Declared& declared = laws_[law];
    if (!declared.is_field) continue;
    vesper_field_desc desc{};
    desc.struct_size = sizeof desc;
    desc.components = declared.field_components;
    desc.name = declared.name.c_str();
    desc.doc = declared.doc.c_str();
    desc.unit = declared.field_unit;
    desc.evaluate = kFunctions[fields_.size()].evaluate;
    desc.explain = kFunctions[fields_.size()].explain;
    desc.begin_step = BeginStep;
    law_of_field_.push_back(law);
    fields_.push_back(desc);
  }
  if (fields_.empty()) return;
  table_.open = OpenFields;
  table_.close = CloseFields;
  table_.field_count = static_cast<uint32_t>(fields_.size());
  table_.fields = fields_.data();
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
  FillFields();
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
