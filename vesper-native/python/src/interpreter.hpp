// SPDX-License-Identifier: Apache-2.0
// Python in this process. There is one interpreter, and each call holds the interpreter's lock (the
// GIL).
#pragma once

#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <cstdint>
#include <string>
#include <utility>

#include "failure.hpp"

namespace vesper::python {

/// A counted reference to a Python object. Use it only while holding the interpreter's lock.
class Object {
 public:
  Object() = default;
  /// Takes over a reference that the caller owns; null stays null.
  explicit Object(PyObject* owned) : object_(owned) {}
  Object(Object&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Object& operator=(Object&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Object() { Py_XDECREF(object_); }

  PyObject* get() const { return object_; }
  PyObject* release() { return std::exchange(object_, nullptr); }
  explicit operator bool() const { return object_ != nullptr; }

 private:
  PyObject* object_ = nullptr;
};

/// Holds the interpreter's lock as long as this object lives.
class Turn {
 public:
  Turn() : state_(PyGILState_Ensure()) {}
  ~Turn() { PyGILState_Release(state_); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  PyGILState_STATE state_;
};

/// Name of the capsules that contain the `vesper_field` of a law. The context of a capsule is the
/// number of components.
inline constexpr const char* kFieldCapsule = "vesper_field";

/// Starts Python with the module `vesper`; further calls do nothing. Python uses the packages of
/// the virtual environment that the environment variable VESPER_PYTHON names, or those of the
/// system. Throws LIBRARY_LOAD_FAILED if Python cannot start.
void Start();

/// Returns a function of the module `vesper`.
Object Function(const char* name);

/// Returns the pending exception as a failure, with the line of `source` at which it was raised,
/// and clears it.
Failure Raised(vesper_status status, const std::string& source);

/// Returns `object`, or throws the pending exception as `Raised`.
Object Checked(PyObject* object, vesper_status status, const std::string& source);

}  // namespace vesper::python
