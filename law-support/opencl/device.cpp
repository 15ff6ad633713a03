// SPDX-License-Identifier: Apache-2.0
#include "device.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace vesper::opencl {
namespace {

constexpr const char* kLoader = "libOpenCL.so.1";

struct Found {
  cl_device_id device;
  cl_device_type type;
};

/** Returns the devices of all platforms, in the order in which OpenCL lists platforms and
 *  devices. */
std::vector<Found> FindDevices(const Api& api) {
  std::vector<Found> found;
  cl_uint platform_count = 0;
  if (api.GetPlatformIDs(0, nullptr, &platform_count) != CL_SUCCESS) return found;
  std::vector<cl_platform_id> platforms(platform_count);
  if (platform_count == 0 ||
      api.GetPlatformIDs(platform_count, platforms.data(), nullptr) != CL_SUCCESS) {
    return found;
  }
  for (const cl_platform_id platform : platforms) {
    cl_uint count = 0;
    if (api.GetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count) != CL_SUCCESS) continue;
    std::vector<cl_device_id> devices(count);
    if (api.GetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, devices.data(), nullptr) !=
        CL_SUCCESS) {
      continue;
    }
    for (const cl_device_id device : devices) {
      cl_device_type type = 0;
      api.GetDeviceInfo(device, CL_DEVICE_TYPE, sizeof type, &type, nullptr);
      found.push_back({device, type});
    }
  }
  return found;
}

cl_device_id Choose(const Api& api) {
  const std::vector<Found> found = FindDevices(api);
  if (found.empty()) {
    throw std::runtime_error(
        "no OpenCL device on this machine; install a driver, such as the "
        "package pocl-opencl-icd, which computes on the CPU");
  }
  if (const char* wanted = std::getenv("VESPER_OPENCL_DEVICE")) {
    size_t number = 0;
    const char* end = wanted + std::strlen(wanted);
    const auto [rest, error] = std::from_chars(wanted, end, number);
    if (error == std::errc() && rest == end && number < found.size()) return found[number].device;
    throw std::runtime_error("VESPER_OPENCL_DEVICE is '" + std::string(wanted) +
                             "', expected a number below " + std::to_string(found.size()) +
                             ", the number of OpenCL devices here");
  }
  const auto gpu = std::ranges::find_if(
      found, [](const Found& one) { return (one.type & CL_DEVICE_TYPE_GPU) != 0; });
  return (gpu != found.end() ? *gpu : found.front()).device;
}

}  // namespace

Api::Api() {
  // The flag NODELETE keeps the loader mapped. OpenCL drivers have threads and global state, so the
  // drivers and their loader must stay mapped.
  void* library = dlopen(kLoader, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) {
    throw std::runtime_error(std::string("no OpenCL on this machine: there is no ") + kLoader +
                             "; install the package ocl-icd-libopencl1 and a driver, such as "
                             "pocl-opencl-icd");
  }
  const auto find = [library](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    if (function != nullptr) return;
    throw std::runtime_error(std::string(kLoader) + " has no function " + name +
                             "; OpenCL 1.2 or newer is needed");
  };
  find(GetPlatformIDs, "clGetPlatformIDs");
  find(GetDeviceIDs, "clGetDeviceIDs");
  find(GetDeviceInfo, "clGetDeviceInfo");
  find(CreateContext, "clCreateContext");
  find(ReleaseContext, "clReleaseContext");
  find(CreateCommandQueue, "clCreateCommandQueue");
  find(ReleaseCommandQueue, "clReleaseCommandQueue");
  find(CreateProgramWithSource, "clCreateProgramWithSource");
  find(BuildProgram, "clBuildProgram");
  find(GetProgramBuildInfo, "clGetProgramBuildInfo");
  find(ReleaseProgram, "clReleaseProgram");
  find(CreateKernel, "clCreateKernel");
  find(SetKernelArg, "clSetKernelArg");
  find(ReleaseKernel, "clReleaseKernel");
  find(CreateBuffer, "clCreateBuffer");
  find(ReleaseMemObject, "clReleaseMemObject");
  find(EnqueueWriteBuffer, "clEnqueueWriteBuffer");
  find(EnqueueReadBuffer, "clEnqueueReadBuffer");
  find(EnqueueNDRangeKernel, "clEnqueueNDRangeKernel");
  find(Finish, "clFinish");
}

Device::Device() : device_(Choose(api_)), name_(Info(CL_DEVICE_NAME)) {
  cl_int result = CL_SUCCESS;
  context_ = api_.CreateContext(nullptr, 1, &device_, nullptr, nullptr, &result);
  Check(result, "clCreateContext");
  queue_ = api_.CreateCommandQueue(context_, device_, 0, &result);
  if (result != CL_SUCCESS) api_.ReleaseContext(context_);
  Check(result, "clCreateCommandQueue");
}

Device::~Device() {
  api_.Finish(queue_);
  api_.ReleaseCommandQueue(queue_);
  api_.ReleaseContext(context_);
}

void Device::Check(cl_int result, const char* call) const {
  if (result == CL_SUCCESS) return;
  throw std::runtime_error("OpenCL device " + name_ + ": " + call + " failed with error " +
                           std::to_string(result));
}

std::string Device::Info(cl_device_info what) const {
  char text[1024] = "";
  api_.GetDeviceInfo(device_, what, sizeof text - 1, text, nullptr);
  return text;
}

void Device::RequireDoubles() const {
  cl_device_fp_config doubles = 0;
  api_.GetDeviceInfo(device_, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof doubles, &doubles, nullptr);
  if (doubles != 0) return;
  throw std::runtime_error("OpenCL device " + name_ +
                           " has no double precision; use a prototype of f32 reals, as si-f32");
}

uint32_t Device::VectorWidth(size_t number_size) const {
  cl_uint width = 1;
  api_.GetDeviceInfo(
      device_,
      number_size == 4 ? CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT : CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE,
      sizeof width, &width, nullptr);
  return width;
}

std::unique_ptr<Kernel> Device::Compile(const char* source, const std::string& options,
                                        const char* kernel) {
  cl_int result = CL_SUCCESS;
  const cl_program program = api_.CreateProgramWithSource(context_, 1, &source, nullptr, &result);
  Check(result, "clCreateProgramWithSource");
  result = api_.BuildProgram(program, 1, &device_, options.c_str(), nullptr, nullptr);
  if (result != CL_SUCCESS) {
    size_t length = 0;
    api_.GetProgramBuildInfo(program, device_, CL_PROGRAM_BUILD_LOG, 0, nullptr, &length);
    std::string log(length, ' ');
    api_.GetProgramBuildInfo(program, device_, CL_PROGRAM_BUILD_LOG, length, log.data(), nullptr);
    api_.ReleaseProgram(program);
    throw std::runtime_error("OpenCL device " + name_ + " refuses kernel " + kernel + ": " + log);
  }
  const cl_kernel made = api_.CreateKernel(program, kernel, &result);
  api_.ReleaseProgram(program);
  Check(result, "clCreateKernel");
  return std::make_unique<Kernel>(*this, made);
}

void Device::Finish() { Check(api_.Finish(queue_), "clFinish"); }

Buffer::~Buffer() {
  if (memory_ != nullptr) device_.api_.ReleaseMemObject(memory_);
}

void Buffer::Reserve(size_t bytes) {
  if (memory_ != nullptr && bytes <= capacity_) return;
  const size_t capacity = std::max<size_t>(bytes + bytes / 4, 64);
  cl_int result = CL_SUCCESS;
  const cl_mem memory =
      device_.api_.CreateBuffer(device_.context_, CL_MEM_READ_WRITE, capacity, nullptr, &result);
  device_.Check(result, "clCreateBuffer");
  if (memory_ != nullptr) device_.api_.ReleaseMemObject(memory_);
  memory_ = memory;
  capacity_ = capacity;
}

void Buffer::Upload(const void* from, size_t bytes) {
  Reserve(bytes);
  if (bytes == 0) return;
  // CL_TRUE makes the call wait until the copy is done, because the caller may change its array as
  // soon as Upload returns.
  device_.Check(device_.api_.EnqueueWriteBuffer(device_.queue_, memory_, CL_TRUE, 0, bytes, from, 0,
                                                nullptr, nullptr),
                "clEnqueueWriteBuffer");
}

void Buffer::Download(void* to, size_t bytes) {
  if (bytes == 0) return;
  device_.Check(device_.api_.EnqueueReadBuffer(device_.queue_, memory_, CL_TRUE, 0, bytes, to, 0,
                                               nullptr, nullptr),
                "clEnqueueReadBuffer");
}

Kernel::~Kernel() { device_.api_.ReleaseKernel(kernel_); }

void Kernel::SetBytes(cl_uint index, size_t size, const void* value) {
  device_.Check(device_.api_.SetKernelArg(kernel_, index, size, value), "clSetKernelArg");
}

void Kernel::Enqueue(size_t items) {
  device_.Check(device_.api_.EnqueueNDRangeKernel(device_.queue_, kernel_, 1, nullptr, &items,
                                                  nullptr, 0, nullptr, nullptr),
                "clEnqueueNDRangeKernel");
}

}  // namespace vesper::opencl
