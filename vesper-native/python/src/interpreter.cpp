// SPDX-License-Identifier: Apache-2.0
#include "interpreter.hpp"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>

#include "vesper/engine.h"

namespace vesper::python {
namespace {

constexpr const char* kModule =
#include "vesper_module.inc"
    ;

PyObject* module = nullptr;  // the module `vesper`; kept as long as the process lives

/// Implements parse_unit(text) of the module `vesper`. Returns the bytes of a vesper_unit.
PyObject* ParseUnit(PyObject*, PyObject* argument) {
  const char* text = PyUnicode_AsUTF8(argument);
  if (text == nullptr) return nullptr;
  vesper_unit unit{};
  vesper_error error{};
  if (vesper_unit_parse(text, &unit, &error) != VESPER_OK) {
    PyErr_SetString(PyExc_ValueError, error.message);
    return nullptr;
  }
  return PyBytes_FromStringAndSize(reinterpret_cast<const char*>(&unit), sizeof unit);
}

/// Implements evaluate_field(field, at, out) of the module `vesper`. Writes the values of a field
/// at positions (rows x 3) into `out` (rows x components). Both are arrays of f64.
PyObject* EvaluateField(PyObject*, PyObject* arguments) {
  PyObject* capsule;
  Py_buffer at{}, out{};
  if (!PyArg_ParseTuple(arguments, "Oy*w*", &capsule, &at, &out)) return nullptr;
  const auto* field =
      static_cast<const vesper_field*>(PyCapsule_GetPointer(capsule, kFieldCapsule));
  if (field != nullptr) {
    const auto components = reinterpret_cast<intptr_t>(PyCapsule_GetContext(capsule));
    const Py_ssize_t rows = at.len / Py_ssize_t{3 * sizeof(double)};
    if (out.len == rows * components * Py_ssize_t{sizeof(double)}) {
      field->evaluate(field->user, static_cast<uint64_t>(rows), static_cast<const double*>(at.buf),
                      static_cast<double*>(out.buf));
    } else {
      PyErr_SetString(PyExc_ValueError, "the values of a field do not fit into the array");
    }
  }
  PyBuffer_Release(&at);
  PyBuffer_Release(&out);
  if (PyErr_Occurred() != nullptr) return nullptr;
  Py_RETURN_NONE;
}

PyMethodDef functions[] = {{"parse_unit", ParseUnit, METH_O, nullptr},
                           {"evaluate_field", EvaluateField, METH_VARARGS, nullptr},
                           {}};
PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_vesper", nullptr, -1, functions, nullptr, nullptr, nullptr, nullptr};

PyObject* InitModule() { return PyModule_Create(&definition); }

/// Makes libraries for linear algebra use one thread, because the order of their sums depends on
/// the number of threads.
void KeepToOneThread() {
  for (const char* name : {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS",
                           "BLIS_NUM_THREADS", "NUMEXPR_NUM_THREADS"}) {
    setenv(name, "1", 1);
  }
}

/// Returns the virtual environment whose packages laws may import. Laws may import the packages of
/// the system if it is empty.
std::string Environment() {
  const char* folder = std::getenv("VESPER_PYTHON");
  return folder == nullptr ? "" : folder;
}

/// Returns the folder of the Python from which a virtual environment was made; empty if none.
std::string HomeOf(const std::string& environment) {
  std::ifstream file(environment + "/pyvenv.cfg");
  for (std::string line; std::getline(file, line);) {
    const size_t value = line.find_first_not_of(' ', line.find('=') + 1);
    if (line.starts_with("home") && value != std::string::npos) return line.substr(value);
  }
  return "";
}

/// Refuses a folder that is no virtual environment made from the embedded Python, because modules
/// for another Python may not fit.
void RequireEnvironment(const std::string& folder) {
  const std::filesystem::path program(VESPER_PYTHON_PROGRAM);
  const std::string home = HomeOf(folder);
  std::error_code unknown;
  if (std::filesystem::equivalent(home, program.parent_path(), unknown)) return;
  throw Failure(VESPER_LIBRARY_LOAD_FAILED,
                "%s is %s%s, expected a virtual environment of %s; make it with %s -m venv DIR",
                folder.c_str(), home.empty() ? "no virtual environment" : "one of ", home.c_str(),
                program.c_str(), program.c_str());
}

/// Returns the end of the message for a missing NumPy. It tells the user how to install NumPy.
std::string NeedsNumPy() {
  const std::string folder = Environment();
  return "laws in Python need NumPy" +
         (folder.empty() ? ": install the Debian package python3-numpy"
                         : ": install it with " + folder + "/bin/python3 -m pip install numpy");
}

/// Starts Python without the user's environment variables, packages and byte code, and with fixed
/// hashes of strings. Therefore a law depends only on its file and the installed packages.
void Initialize() {
  if (const std::string folder = Environment(); !folder.empty()) RequireEnvironment(folder);
  KeepToOneThread();
  PyImport_AppendInittab("_vesper", InitModule);
  PyConfig config;
  PyConfig_InitIsolatedConfig(&config);
  config.install_signal_handlers = 0;
  config.write_bytecode = 0;
  config.buffered_stdio = 0;  // keeps the output of laws in order with other output
  config.use_hash_seed = 1;
  config.hash_seed = 0;
  // The path of the program is set, because Python uses it to find its packages.
  const std::string folder = Environment();
  PyStatus status = folder.empty()
                        ? PyConfig_SetString(&config, &config.program_name, VESPER_PYTHON_PROGRAM)
                        : PyConfig_SetBytesString(&config, &config.program_name,
                                                  (folder + "/bin/python3").c_str());
  if (!PyStatus_Exception(status)) status = Py_InitializeFromConfig(&config);
  PyConfig_Clear(&config);
  if (PyStatus_Exception(status)) {
    throw Failure(VESPER_LIBRARY_LOAD_FAILED, "Python cannot start: %s",
                  status.err_msg == nullptr ? "no reason given" : status.err_msg);
  }
}

/// Runs the module `vesper` and registers it, so that laws can import it.
void RunModule() {
  const char* name = "vesper";
  const Object code(Py_CompileString(kModule, "vesper", Py_file_input));
  if (code) module = PyImport_ExecCodeModule(name, code.get());
  if (module != nullptr) return;
  throw Raised(VESPER_LIBRARY_LOAD_FAILED, "vesper").Within(NeedsNumPy());
}

std::string TextOf(PyObject* object) {
  const char* text = object == nullptr ? nullptr : PyUnicode_AsUTF8(object);
  return text == nullptr ? "" : text;
}

/// Returns Python's pending exception and clears it.
Object Fetch() {
  PyObject *type = nullptr, *value = nullptr, *trace = nullptr;
  PyErr_Fetch(&type, &value, &trace);
  PyErr_NormalizeException(&type, &value, &trace);
  if (value != nullptr && trace != nullptr) PyException_SetTraceback(value, trace);
  Py_XDECREF(type);
  Py_XDECREF(trace);
  return Object(value);
}

}  // namespace

void Start() {
  static std::mutex starting;
  static std::optional<Failure> refused;
  const std::lock_guard<std::mutex> lock(starting);
  if (refused) throw *refused;
  if (module != nullptr) return;
  try {
    Initialize();
    RunModule();
    PyEval_SaveThread();  // releases the interpreter's lock, which each call acquires again
  } catch (const Failure& failure) {
    refused = failure;  // Python cannot be started again in the same process
    throw;
  }
}

Object Function(const char* name) { return Object(PyObject_GetAttrString(module, name)); }

Failure Raised(vesper_status status, const std::string& source) {
  const Object exception = Fetch();
  std::string message;
  if (module != nullptr && exception) {
    const Object describe = Function("_describe");
    const Object text(
        describe ? PyObject_CallFunction(describe.get(), "Os", exception.get(), source.c_str())
                 : nullptr);
    message = TextOf(text.get());
  } else if (exception) {
    const Object text(PyObject_Str(exception.get()));
    message = TextOf(text.get());
  }
  PyErr_Clear();
  if (message.empty()) message = source + ": an exception that cannot be described";
  return Failure(status, "%s", message.c_str());
}

Object Checked(PyObject* object, vesper_status status, const std::string& source) {
  if (object == nullptr) throw Raised(status, source);
  return Object(object);
}

}  // namespace vesper::python
