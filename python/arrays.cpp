#include "python/arrays.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "python/errors.h"

namespace py = pybind11;

namespace scanknit {
namespace {

std::string shape_text(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

std::string dtype_text(const py::array& array) {
  return py::str(array.dtype()).cast<std::string>();
}

void require_shape(const py::array& array, py::ssize_t dimensions, const char* name, const char* expected) {
  const bool has_pixels = array.ndim() == dimensions && array.shape(0) > 0 && array.shape(1) > 0;
  constexpr py::ssize_t kLargest = 1 << 15;  // no camera's picture is larger
  if (!has_pixels || array.shape(0) > kLargest || array.shape(1) > kLargest) {
    throw py::value_error(fmt::format("{}: expected the shape {}, got {}", name, expected, shape_text(array)));
  }
}

/// Numbers of any kind, as a dense array of doubles.
py::array_t<double, py::array::c_style | py::array::forcecast> numbers_of(const py::object& given, const char* name,
                                                                          const char* expected) {
  auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(given);
  if (!numbers) {
    PyErr_Clear();
    throw py::type_error(fmt::format("{}: expected {}", name, expected));
  }
  return numbers;
}

float depth_or_none(float depth_m) {
  return std::isfinite(depth_m) && depth_m > 0 ? depth_m : 0.0f;
}

}  // namespace

DepthImage depth_image(const py::array& depth, double units_per_metre) {
  require_shape(depth, 2, "depth", "(height, width)");
  DepthImage image(static_cast<int>(depth.shape(1)), static_cast<int>(depth.shape(0)));
  const auto pixels = image.pixels();
  if (depth.dtype().is(py::dtype::of<float>())) {
    const auto dense = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(depth);
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = depth_or_none(dense.data()[i]);
    return image;
  }
  if (!depth.dtype().is(py::dtype::of<std::uint16_t>())) {
    throw py::type_error(fmt::format("depth: expected float32 (metres) or uint16, got {}", dtype_text(depth)));
  }
  if (!(std::isfinite(units_per_metre) && units_per_metre > 0)) {
    throw py::value_error("depth_scale: expected raw units per metre, above 0, such as 1000 for millimetres");
  }
  const auto dense = py::array_t<std::uint16_t, py::array::c_style | py::array::forcecast>::ensure(depth);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = static_cast<float>(static_cast<double>(dense.data()[i]) / units_per_metre);
  }
  return image;
}

ColourImage colour_image(const py::array& colour) {
  require_shape(colour, 3, "colour", "(height, width, 3)");
  if (colour.shape(2) != 3) {
    throw py::value_error(fmt::format("colour: expected the shape (height, width, 3), got {}", shape_text(colour)));
  }
  if (!colour.dtype().is(py::dtype::of<std::uint8_t>())) {
    throw py::type_error(fmt::format("colour: expected uint8 (sRGB), got {}", dtype_text(colour)));
  }
  const auto dense = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>::ensure(colour);
  ColourImage image(static_cast<int>(colour.shape(1)), static_cast<int>(colour.shape(0)));
  const std::uint8_t* rgb = dense.data();
  for (Rgb8& pixel : image.pixels()) {
    pixel = {rgb[0], rgb[1], rgb[2]};
    rgb += 3;
  }
  return image;
}

CameraIntrinsics intrinsics_of(const py::object& given, int width, int height, const char* name) {
  const char* expected = "(fx, fy, cx, cy) or a 3 x 3 matrix, in pixels";
  const auto numbers = numbers_of(given, name, expected);
  CameraIntrinsics intrinsics{width, height, 0, 0, 0, 0};
  const double* v = numbers.data();
  if (numbers.ndim() == 1 && numbers.shape(0) == 4) {
    intrinsics = {width, height, v[0], v[1], v[2], v[3]};
  } else if (numbers.ndim() == 2 && numbers.shape(0) == 3 && numbers.shape(1) == 3) {
    if (v[1] != 0 || v[3] != 0 || v[6] != 0 || v[7] != 0 || v[8] != 1) {
      throw py::value_error(fmt::format("{}: expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]", name));
    }
    intrinsics = {width, height, v[0], v[4], v[2], v[5]};
  } else {
    throw py::value_error(fmt::format("{}: expected {}, got the shape {}", name, expected, shape_text(numbers)));
  }
  if (!intrinsics.is_valid()) throw py::value_error(fmt::format("{}: expected finite numbers, fx and fy not 0", name));
  return intrinsics;
}

Pose pose_of(const py::object& given, const char* name) {
  const auto numbers = numbers_of(given, name, "a 4 x 4 matrix");
  if (numbers.ndim() != 2 || numbers.shape(0) != 4 || numbers.shape(1) != 4) {
    throw py::value_error(fmt::format("{}: expected the shape (4, 4), got {}", name, shape_text(numbers)));
  }
  const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  auto pose = pose_from_matrix(matrix);
  if (!pose) throw Failure({pose.error().code, pose.error().message, name});
  return *pose;
}

py::array_t<double> matrix_of(const Pose& pose) {
  py::array_t<double> matrix({4, 4});
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = pose.matrix();
  std::memcpy(matrix.mutable_data(), rows.data(), sizeof(double) * 16);
  return matrix;
}

py::tuple tuple_of(const CameraIntrinsics& intrinsics) {
  return py::make_tuple(intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy);
}

}  // namespace scanknit
