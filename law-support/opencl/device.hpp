// SPDX-License-Identifier: Apache-2.0
// The OpenCL device of the laws of a suite. It has one context and one in-order queue.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

namespace vesper::opencl {

/** The functions of the OpenCL library that the suite calls. They are not linked, but looked up
 *  when a law is created. Therefore a machine without OpenCL reports a clear error. */
struct Api {
  /** Looks up the functions. Throws std::runtime_error if the machine has no OpenCL library. */
  Api();

  decltype(&clGetPlatformIDs) GetPlatformIDs;
  decltype(&clGetDeviceIDs) GetDeviceIDs;
  decltype(&clGetDeviceInfo) GetDeviceInfo;
  decltype(&clCreateContext) CreateContext;
  decltype(&clReleaseContext) ReleaseContext;
  decltype(&clCreateCommandQueue) CreateCommandQueue;
  decltype(&clReleaseCommandQueue) ReleaseCommandQueue;
  decltype(&clCreateProgramWithSource) CreateProgramWithSource;
  decltype(&clBuildProgram) BuildProgram;
  decltype(&clGetProgramBuildInfo) GetProgramBuildInfo;
  decltype(&clReleaseProgram) ReleaseProgram;
  decltype(&clCreateKernel) CreateKernel;
  decltype(&clSetKernelArg) SetKernelArg;
  decltype(&clReleaseKernel) ReleaseKernel;
  decltype(&clCreateBuffer) CreateBuffer;
  decltype(&clReleaseMemObject) ReleaseMemObject;
  decltype(&clEnqueueWriteBuffer) EnqueueWriteBuffer;
  decltype(&clEnqueueReadBuffer) EnqueueReadBuffer;
  decltype(&clEnqueueNDRangeKernel) EnqueueNDRangeKernel;
  decltype(&clFinish) Finish;
};

class Device;

/** Memory on the device; it grows when needed, and never shrinks. Not copyable, not movable;
 *  destroyed before its device. */
class Buffer {
 public:
  explicit Buffer(Device& device) : device_(device) {}
  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  /** Makes room for at least this many bytes. The contents are lost if the buffer grows. */
  void Reserve(size_t bytes);
  void Upload(const void* from, size_t bytes);
  /** Copies to the host, after all previously enqueued work. */
  void Download(void* to, size_t bytes);
  cl_mem handle() const { return memory_; }

 private:
  Device& device_;
  cl_mem memory_ = nullptr;
  size_t capacity_ = 0;
};

/** A compiled kernel; calling the object enqueues it. */
class Kernel {
 public:
  Kernel(Device& device, cl_kernel kernel) : device_(device), kernel_(kernel) {}
  ~Kernel();
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;

  /** Enqueues `items` work items. Arguments are Buffers and numbers, in the kernel's order. */
  template <class... Arguments>
  void operator()(size_t items, const Arguments&... arguments) {
    if (items == 0) return;
    cl_uint index = 0;
    (Set(index++, arguments), ...);
    Enqueue(items);
  }

 private:
  void Set(cl_uint index, const Buffer& buffer) {
    const cl_mem memory = buffer.handle();
    SetBytes(index, sizeof memory, &memory);
  }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  void Set(cl_uint index, const Number& number) {
    SetBytes(index, sizeof number, &number);
  }
  void SetBytes(cl_uint index, size_t size, const void* value);
  void Enqueue(size_t items);

  Device& device_;
  cl_kernel kernel_;
};

/** A context on one device. Every failure throws std::runtime_error with the device and the
 *  call. */
class Device {
 public:
  /** Opens the device whose number (over all platforms, from 0) is in the environment variable
   *  VESPER_OPENCL_DEVICE. Without the variable, opens the first GPU, or else the first device.
   *  The variable is not a parameter of a law, because device numbers differ between machines. */
  Device();
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const std::string& name() const { return name_; }
  /** Throws if the device does not support double precision. */
  void RequireDoubles() const;
  /** Returns the number of values of this size (4 or 8 bytes) that one instruction of the device
   *  processes. */
  uint32_t VectorWidth(size_t number_size) const;
  /** Compiles kernel `kernel` of a program. */
  std::unique_ptr<Kernel> Compile(const char* source, const std::string& options,
                                  const char* kernel);
  void Finish();

 private:
  friend class Buffer;
  friend class Kernel;

  void Check(cl_int result, const char* call) const;
  std::string Info(cl_device_info what) const;

  const Api api_;
  cl_device_id device_ = nullptr;
  std::string name_;
  cl_context context_ = nullptr;
  cl_command_queue queue_ = nullptr;
};

}  // namespace vesper::opencl
