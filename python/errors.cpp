#include "python/errors.h"

namespace py = pybind11;

namespace scanknit {
namespace {

const char* name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage: return "usage";
    case ErrorCode::kConfig: return "config";
    case ErrorCode::kInput: return "input";
    case ErrorCode::kDevice: return "device";
    case ErrorCode::kTooLittle: return "too_little";
    case ErrorCode::kMesh: return "mesh";
    case ErrorCode::kOutput: return "output";
    case ErrorCode::kBudget: return "budget";
    case ErrorCode::kInternal: return "internal";
  }
  return "internal";
}

}  // namespace

py::object error_object(const Failure& failure) {
  py::object error = py::module_::import("scanknit._core").attr("Error")(failure.what());
  error.attr("code") = name_of(failure.code);
  return error;
}

void add_errors(py::module_& module) {
  static const py::exception<Failure> error(module, "Error", PyExc_RuntimeError);
  error.attr("__doc__") =
      "What ScanKnit cannot do, and why. `code` is one word: config, input, mesh, output, budget ...";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Failure& failure) {
      PyErr_SetObject(error.ptr(), error_object(failure).ptr());
    }
  });
}

}  // namespace scanknit
